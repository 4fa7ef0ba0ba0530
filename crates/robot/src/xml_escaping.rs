//! Escapes texts for XML.

use std::fmt::Write as _;

/// A text as the value of an XML attribute in double quotes, so that every XML reader returns it unchanged.
///
/// Line breaks and tabs are written as references: readers replace plain ones by blanks (XML 1.0, section 3.3.3).
#[must_use]
pub fn xml_attribute(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // U+2028 is a line break in XML 1.1
            c if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') => {
                // writing to a string does not fail
                let _ = write!(escaped, "&#{};", u32::from(c));
            }
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::xml::plain_attribute;

    fn read_back(text: &str) -> String {
        let xml = format!("<a b=\"{}\"/>", xml_attribute(text));
        let document = roxmltree::Document::parse(&xml).unwrap_or_else(|e| panic!("{e}: {xml}"));
        plain_attribute(document.root_element(), "b").unwrap().to_owned()
    }

    #[test]
    fn odd_characters_are_read_back() {
        let odd = "\t\n\r \u{7f}\u{85}\u{a0}\u{2028}\u{2029}\u{feff}\"'<>&;#x10;]]>%é漢🤖";
        for c in odd.chars() {
            let name = format!("a{c}b{c}{c}");
            assert_eq!(read_back(&name), name);
        }
        assert_eq!(read_back(odd), odd);
        assert_eq!(xml_attribute("a\nb\t\r"), "a&#10;b&#9;&#13;");
        assert_eq!(xml_attribute("&#10;"), "&amp;#10;");
    }

    proptest! {
        #[test]
        fn texts_are_read_back(text in "[\\t\\n\\r\\PC]{0,20}") {
            prop_assert_eq!(read_back(&text), text);
        }
    }
}
