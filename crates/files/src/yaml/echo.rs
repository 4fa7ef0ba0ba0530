//! Handles output of `ros2 topic echo`: its extra lines are skipped; shortened lists and truncated files are rejected.

use std::borrow::Cow;

/// The message about a text that is cut: by `ros2 topic echo` within a list, or by something else within its last number.
#[must_use]
pub fn cut_in_words(document: &str) -> Option<String> {
    let of_list = |line| {
        format!(
            "line {line}: the list is cut there ('...'): save the message with `ros2 topic echo --full-length`"
        )
    };
    line_of_cut(document).map(of_list).or_else(|| cut_number(document))
}

/// The line, from 1, of the mark by which `ros2 topic echo` replaces the rest of a list.
fn line_of_cut(document: &str) -> Option<usize> {
    let is_item = |(at, mark): (usize, &str)| {
        let (before, after) = (&document[..at], &document[at + mark.len()..]);
        let begins = before.trim_end_matches(' ').ends_with(['-', ',', '[', '\n']);
        let ends = after.trim_start_matches(' ');
        begins && (ends.is_empty() || ends.starts_with([',', ']', '\n', '\r']))
    };
    let marks = document.match_indices("'...'").chain(document.match_indices("\"...\""));
    let first = marks.filter(|mark| is_item(*mark)).map(|(at, _)| at).min()?;
    Some(document[..first].matches('\n').count() + 1)
}

/// Without the lines that `ros2 topic echo` prints between messages, and a remark about each kind. Lines keep their numbers.
#[must_use]
pub fn without_remarks_of_echo(text: &str) -> (Cow<'_, str>, Vec<String>) {
    if !(text.contains(LOST) || text.contains(UNPUBLISHED)) {
        return (Cow::Borrowed(text), Vec::new());
    }
    let (mut kept, mut remarks) = (String::with_capacity(text.len()), Vec::new());
    let mut is_about_lost = false;
    for (line, number) in text.split_inclusive('\n').zip(1..) {
        let content = line.trim_end();
        let is_count =
            ["total count change:", "total count:"].iter().any(|c| content.trim_start().starts_with(c));
        if content == LOST {
            is_about_lost = true;
            remarks.push(format!("line {number}: a message was lost while the file was recorded"));
        } else if is_about_lost && is_count {
            // the separator stands behind the last count
            is_about_lost = !content.ends_with("---");
            if content.ends_with("---") {
                kept.push_str("---");
            }
        } else if content.starts_with("WARNING: topic") && content.contains(UNPUBLISHED) {
            remarks.push(format!("line {number} is not part of a message: {content}"));
        } else {
            is_about_lost = false;
            kept.push_str(content);
        }
        if line.ends_with('\n') {
            kept.push('\n');
        }
    }
    (Cow::Owned(kept), bounded(remarks))
}

/// The message about a text that ends within a number, such as one that a full disk has cut.
fn cut_number(document: &str) -> Option<String> {
    let last = document.rsplit(char::is_whitespace).next()?;
    let is_cut =
        last.ends_with(['.', 'e', '-', '+']) && last.starts_with(|c: char| c.is_ascii_digit() || c == '-');
    let is_cut = is_cut
        && last.chars().all(|c| c.is_ascii_digit() || ".e-+".contains(c))
        && last.contains(|c: char| c.is_ascii_digit());
    is_cut.then(|| {
        let line = document.matches('\n').count() + 1;
        format!("line {line}: the text ends in the middle of the number {last}: the file is cut")
    })
}

const LOST: &str = "A message was lost!!!";
const UNPUBLISHED: &str = "does not appear to be published";

/// At most eight remarks.
fn bounded(mut remarks: Vec<String>) -> Vec<String> {
    const MOST: usize = 8;
    let more = remarks.len().saturating_sub(MOST);
    remarks.truncate(MOST);
    if more > 0 {
        remarks.push(format!("{more} more such lines"));
    }
    remarks
}

#[cfg(test)]
mod tests {
    use super::super::{documents, from_text};
    use super::*;

    #[test]
    fn lists_that_echo_has_cut_are_reported() {
        for (text, line) in [
            ("- 1\n- '...'\n", 2),
            ("[1, '...']", 1),
            ("a:\n  - 1\n  - '...'\n", 3),
            ("a: ['...']\r\n", 1),
            ("- 1\n- \"...\"", 2),
        ] {
            let message = from_text::<serde_json::Value>(&format!("# x\n{text}")).unwrap_err();
            assert!(
                message.contains(&format!("line {}", line + 1)) && message.contains("--full-length"),
                "{message}"
            );
        }
        for text in ["a: '...'\n", "- 'b...'\n", "- '... b'\n", "- x '...' y\n"] {
            assert_eq!(line_of_cut(text), None, "{text}");
        }
    }

    #[test]
    fn texts_that_end_within_a_number_are_reported() {
        for text in ["- 1\n- 0.", "- 1\n- -12.", "- 1\n- 3.5e", "- 1\n- 3.5e-"] {
            let message = from_text::<Vec<f64>>(text).unwrap_err();
            assert!(message.contains("line 2") && message.contains("is cut"), "{message}");
        }
        for text in ["- 1\n- 0.\n", "- 1\n- 0.5", "[1, 0.]", "- 1\n---"] {
            assert!(from_text::<Vec<f64>>(text).is_ok(), "{text}");
        }
    }

    #[test]
    fn lines_of_echo_between_messages_are_left_out_and_reported() {
        let text = "WARNING: topic [/j] does not appear to be published yet\na: 1\n---\nA message was lost!!!\n\ttotal count change:1\n\t\
                    total count: 3---\na: 2\n---\n";
        let (kept, remarks) = without_remarks_of_echo(text);
        assert_eq!(remarks.len(), 2, "{remarks:?}");
        assert!(
            remarks[0].starts_with("line 1 ") && remarks[1].starts_with("line 4: a message was lost"),
            "{remarks:?}"
        );
        let lines: Vec<usize> = documents(&kept).iter().map(|d| d.line).collect();
        assert_eq!(lines, [1, 6]);
        assert_eq!(kept.lines().count(), text.lines().count());
        let plain = "a: 'A message'\n";
        assert_eq!(without_remarks_of_echo(plain), (Cow::Borrowed(plain), vec![]));
        assert!(without_remarks_of_echo(&text.repeat(50)).1.len() < 10);
    }
}
