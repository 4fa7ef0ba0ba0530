//! Reader of YAML and JSON: splits a text into documents at lines of three dashes, deserializes one within limits.
//!
//! `ros2 topic echo` ends every message with such a line, so a saved message is a document followed by an empty one.

use std::borrow::Cow;

use serde::de::DeserializeOwned;

mod echo;
mod plain_words;

pub use echo::without_remarks_of_echo;
pub use plain_words::in_words;

pub use echo::cut_in_words;

/// A document that holds something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Document<'t> {
    /// The line of the text, from 1, that `text` begins in.
    pub line: usize,
    /// The text of the document.
    pub text: &'t str,
}

/// Why a text is not one document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum DocumentError {
    #[error("it is empty")]
    Empty,
    #[error(
        "it holds {count} documents, but only one is read (the second begins behind '---' in line {line}): \
         give each in a file of its own"
    )]
    Several { count: usize, line: usize },
}

/// The documents of a text, without those that hold nothing but comments.
#[must_use]
pub fn documents(text: &str) -> Vec<Document<'_>> {
    spans(text)
        .into_iter()
        .map(|span| Document { line: span.line, text: &text[span.start..span.end] })
        .collect()
}

/// The only document of a text that holds something; its lines have the numbers that they have in the text.
///
/// # Errors
/// When there is none, or more than one.
pub fn only_document(text: &str) -> Result<Cow<'_, str>, DocumentError> {
    match spans(text)[..] {
        [] => Err(DocumentError::Empty),
        [Span { start: 0, end, .. }] => Ok(Cow::Borrowed(&text[..end])),
        [Span { start, end, line }] => Ok(Cow::Owned("\n".repeat(line - 1) + &text[start..end])),
        [_, second, ..] => {
            let count = spans(text).len();
            Err(DocumentError::Several { count, line: second.line })
        }
    }
}

/// Reads the only document of a text.
///
/// # Errors
/// One line that says where and what.
pub fn from_text<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    // large files are JSON, which is read faster
    let as_json = from_json(text);
    if let Some(Ok(value)) = as_json {
        return Ok(value);
    }
    let read = only_document(text).map_err(|error| error.to_string()).and_then(|d| from_document(&d));
    match (read, as_json) {
        // well-formed JSON that holds something else
        (Err(_), Some(Err(error))) if error.is_data() => Err(error.to_string()),
        (read, _) => read,
    }
}

/// `None` for a text that can not be JSON.
fn from_json<T: DeserializeOwned>(text: &str) -> Option<serde_json::Result<T>> {
    let text = text.trim_start_matches('\u{feff}');
    text.trim_start().starts_with(['{', '[']).then(|| serde_json::from_str(text))
}

/// Reads a document; `y`, `n`, `on` and `off` are words, as the key `y` of a position.
///
/// # Errors
/// As [`from_text`].
pub fn from_document<T: DeserializeOwned>(document: &str) -> Result<T, String> {
    if let Some(message) = cut_in_words(document) {
        return Err(message);
    }
    let read = serde_saphyr::from_str_with_options(document, limits());
    read.map_err(|error| in_words(&error))
}

/// Maximum number of nodes of a text: the count of numbers in a file of the largest allowed size.
const MOST_NODES: usize = 20_000_000;

/// Parser limits that accept long trajectories and large meshes, but no text that expands without end.
fn limits() -> serde_saphyr::Options {
    serde_saphyr::options! {
        with_snippet: false,
        // otherwise the keys y and n of a position or a normal would be booleans
        strict_booleans: true,
        // drivers write .nan into fields that are not read, such as effort; readers check the numbers that they use
        non_finite_float_policy: serde_saphyr::NonFiniteFloatPolicy::PassThrough,
        budget: serde_saphyr::budget! {
            max_events: MOST_NODES,
            max_nodes: MOST_NODES,
            max_total_scalar_bytes: 16 * MOST_NODES,
        },
    }
}

/// Where a document stands in a text.
#[derive(Clone, Copy)]
struct Span {
    start: usize,
    end: usize,
    line: usize,
}

/// A line that begins with `---` or `...` is a marker everywhere: no scalar of a block or in quotes may hold one.
fn spans(text: &str) -> Vec<Span> {
    let mut spans = Vec::new();
    let mut current = Span { start: 0, end: 0, line: 1 };
    let mut holds_something = false;
    let mut at = 0;
    for (line, number) in text.split_inclusive('\n').zip(1..) {
        let rest = line.strip_prefix("---").or_else(|| line.strip_prefix("..."));
        let content = match rest.filter(|rest| rest.is_empty() || rest.starts_with(char::is_whitespace)) {
            Some(rest) => {
                if std::mem::take(&mut holds_something) {
                    spans.push(Span { end: at, ..current });
                }
                // a document without a marker begins at the start of the text, with its comments
                current = Span { start: at + 3, end: 0, line: number };
                rest
            }
            None => line,
        };
        at += line.len();
        let content = content.trim_start_matches('\u{feff}');
        let is_directive = content.starts_with('%') && !holds_something;
        holds_something |=
            !(content.trim().is_empty() || content.trim_start().starts_with('#') || is_directive);
    }
    if holds_something {
        spans.push(Span { end: text.len(), ..current });
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    fn only(text: &str) -> Result<String, String> {
        only_document(text).map(Cow::into_owned).map_err(|error| error.to_string())
    }

    #[test]
    fn empty_documents_around_the_only_one_are_nothing() {
        for text in [
            "a: 1\n",
            "a: 1\n---\n",
            "a: 1\n---",
            "a: 1\r\n---\r\n",
            "a: 1\n---\n---\n# nothing more\n\n...\n",
            "a: 1\n...\n",
            "---\na: 1\n---\n",
            "%YAML 1.2\n---\na: 1\n",
            "# a comment\n---\n---\na: 1",
            "\u{feff}a: 1\n---\n",
        ] {
            let value: serde_json::Value = from_text(text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            assert_eq!(value, serde_json::json!({"a": 1}), "{text:?}");
        }
    }

    #[test]
    fn two_documents_are_rejected_by_their_line() {
        let message = only("a: 1\n---\n---\nb: 2\n---\nc: 3\n").unwrap_err();
        assert!(message.contains("3 documents") && message.contains("line 3"), "{message}");
        assert!(only("a: 1\n...\nb: 2").is_err());
        assert!(only("a: 1\n--- b").is_err());
        for text in ["", " \n", "---\n", "# a comment\n---\n...\n"] {
            assert_eq!(only(text).unwrap_err(), "it is empty", "{text:?}");
        }
    }

    #[test]
    fn long_lists_are_read_and_limits_are_reported_in_words() {
        let numbers = "0.125, ".repeat(300_000);
        for text in [format!("[{numbers}1]"), format!("- {}", "0.125\n- ".repeat(300_000)) + "1\n"] {
            assert_eq!(from_text::<Vec<f64>>(&text).unwrap().len(), 300_001);
        }
        let deep = format!("{}{}", "- ".repeat(300), "1");
        let wide = (0..60_000).map(|i| format!("- &a{i} 1\n")).collect::<Vec<_>>().concat();
        let again = format!("- &a [1]\n{}", "- *a\n".repeat(60_000));
        for text in [deep, wide, again, "a: 1\na: 2\n".to_owned()] {
            let message = match from_text::<serde_json::Value>(&text) {
                Ok(_) => from_text::<Vec<f64>>(&text).unwrap_err(),
                Err(message) => message,
            };
            for word in ["udget", "Options", "{", "policy", "anchor_id", "max_"] {
                assert!(!message.contains(word), "'{word}' in: {message}");
            }
            assert!(!message.contains('\n'), "{message}");
        }
        assert!(from_text::<serde_json::Value>("a: 1\na: 2\n").unwrap_err().contains("'a' is there twice"));
    }

    #[test]
    fn json_is_read_as_json_and_its_faults_have_lines() {
        assert_eq!(from_text::<Vec<f64>>("\u{feff}[0.1, 2]\n"), Ok(vec![0.1, 2.0]));
        assert_eq!(from_text::<Vec<f64>>("[0.1, 2]\n---\n"), Ok(vec![0.1, 2.0]));
        let message = from_text::<Vec<f64>>("[0.1,\n \"x\"]").unwrap_err();
        assert!(message.contains("line 2") && message.contains("\"x\""), "{message}");
        // no JSON, but YAML
        let value: serde_json::Value = from_text("{a: 1}").unwrap();
        assert_eq!(value, serde_json::json!({"a": 1}));
        assert!(from_text::<Vec<f64>>("[0.1,\n2").unwrap_err().contains("line"));
    }

    #[test]
    fn numbers_that_are_not_finite_are_left_to_the_reader() {
        #[derive(serde::Deserialize)]
        struct Joints {
            position: Vec<f64>,
            #[serde(rename = "effort")]
            _effort: serde::de::IgnoredAny,
        }
        for effort in ["[.nan, -.inf, 1e999]", "{x: [.nan]}", ".inf", "[NaN]"] {
            let Joints { position, .. } =
                from_text(&format!("effort: {effort}\nposition: [1, .nan]\n")).unwrap();
            assert!(position[0] == 1.0 && position[1].is_nan(), "{effort}: {position:?}");
        }
    }

    #[test]
    fn dashes_that_are_no_marker_are_content() {
        for text in ["a: ---x\n", " ---\n", "----\n", "- --- \n", "---a: 1\n", "a: '... b'\n"] {
            assert_eq!(only(text).as_deref(), Ok(text));
        }
    }

    #[test]
    fn faults_keep_the_line_of_the_text() {
        let message = from_text::<Vec<f64>>("# one\n---\n---\n- 1\n- x\n").unwrap_err();
        assert!(message.contains("line 5") && !message.contains('\n'), "{message}");
        let all = documents("- 1\n---\n\n- 2\n---\n");
        assert_eq!(all.iter().map(|d| d.line).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(all[1].text.trim(), "- 2");
    }
}
