//! Converts text from files and messages to a form that is safe for terminals and logs.
//!
//! Guarantee: nothing in the result moves the cursor, colours, hides or reorders text, or begins a new line.

use std::borrow::Cow;
use std::fmt::Write as _;

/// The text with line breaks, control characters and invisible marks written as `\n`, `\u{1b}` and so on.
#[must_use]
pub fn on_one_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_unreadable)
}

/// The same for a message of several lines, which stay lines.
#[must_use]
pub fn lines(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c != '\n' && is_unreadable(c))
}

fn escaped(text: &str, is_unreadable: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_unreadable) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_unreadable(c) {
            let _ = match c {
                '\n' | '\r' | '\t' => write!(escaped, "{}", c.escape_default()),
                _ => write!(escaped, "{}", c.escape_unicode()),
            };
        } else {
            escaped.push(c);
        }
    }
    Cow::Owned(escaped)
}

fn is_unreadable(c: char) -> bool {
    let is_line = matches!(c, '\u{2028}' | '\u{2029}');
    // marks that reorder the text around them
    let is_bidi =
        matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let is_invisible = matches!(c, '\u{ad}' | '\u{200b}'..='\u{200d}' | '\u{2060}'..='\u{2064}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}');
    c.is_control() || is_line || is_bidi || is_invisible
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_terminal_obeys_is_left() {
        for (text, readable) in [
            ("link 'a\nb\u{1b}[31m'", r"link 'a\nb\u{1b}[31m'"),
            ("a\r\tb\u{7}\u{9b}2J\0", r"a\r\tb\u{7}\u{9b}2J\u{0}"),
            ("\u{202e}cba\u{2066}x\u{200f}", r"\u{202e}cba\u{2066}x\u{200f}"),
            ("\u{2028}\u{feff}\u{200b}", r"\u{2028}\u{feff}\u{200b}"),
        ] {
            assert_eq!(on_one_line(text), readable);
        }
        assert_eq!(lines("a\nb\r\n\u{1b}"), "a\nb\\r\n\\u{1b}");
    }

    #[test]
    fn other_text_stays() {
        for text in ["", "Größe – 3 m, ≤ 0.5", "関節", "ذراع", "back\\slash 'q' \"r\""] {
            assert!(matches!(on_one_line(text), Cow::Borrowed(same) if same == text));
        }
    }
}
