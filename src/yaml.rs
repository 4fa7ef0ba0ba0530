//! YAML texts: one document, or several with a line of three dashes between them.
//!
//! `ros2 topic echo` ends every message with such a line, so that a saved message is a document and an empty one behind it.

use std::borrow::Cow;

use serde::de::DeserializeOwned;

/// A document that holds something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Document<'t> {
    /// The line of the text, from 1, that `text` begins in.
    pub line: usize,
    pub text: &'t str,
}

/// Why a text is not one document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
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
    let document = only_document(text).map_err(|error| error.to_string())?;
    from_document(&document)
}

/// Reads a document; `y`, `n`, `on` and `off` are words, as the key `y` of a position.
///
/// # Errors
/// As [`from_text`].
pub fn from_document<T: DeserializeOwned>(document: &str) -> Result<T, String> {
    let options = serde_saphyr::options! { with_snippet: false, strict_booleans: true };
    serde_saphyr::from_str_with_options(document, options).map_err(|error| error.to_string())
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
