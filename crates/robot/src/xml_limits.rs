//! Limits of XML text, checked in one linear pass before it is parsed.
//!
//! `roxmltree` compares every attribute with all earlier ones, and every namespace declaration with all declarations in scope: its time
//! is quadratic in their number. Deep nesting is safe in `roxmltree`, but not in all code that walks the tree.

use clearance_geometry::constants::LONGEST_NAME;

/// Maximum number of attributes of one element, namespace declarations included. Descriptions and meshes have at most twenty.
const MOST_ATTRIBUTES: usize = 256;
/// Maximum number of namespace declarations in scope at one element, and in the whole text.
const MOST_NAMESPACES_IN_SCOPE: usize = 64;
const MOST_NAMESPACES: usize = 100_000;
/// Maximum nesting depth of elements.
const DEEPEST: usize = 1000;

/// An exceeded limit: the line, from 1, and a clause that names limit and element.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Excess {
    pub line: u32,
    pub message: String,
}

/// Checks the limits up to the end, or up to a document type, which the parser rejects. Syntax is left to the parser.
pub(super) fn check(text: &str) -> Result<(), Excess> {
    let mut scan = Scan::default();
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        rest = &rest[start..];
        let end = if let Some(mark) = ["<!--", "<![CDATA[", "<?"].into_iter().find(|m| rest.starts_with(m)) {
            let end = if mark == "<?" { "?>" } else { closing(mark) };
            rest.find(end).map(|at| at + end.len())
        } else if rest.starts_with("<!") {
            return Ok(());
        } else if rest.starts_with("</") {
            scan.namespaces.pop();
            rest.find('>').map(|at| at + 1)
        } else {
            let tag = Tag::at_start(rest);
            let line = || line_of(text, text.len() - rest.len());
            scan.enter(&tag).map_err(|message| Excess { line: line(), message })?;
            Some(tag.length)
        };
        rest = end.and_then(|end| rest.get(end..)).unwrap_or_default();
    }
    Ok(())
}

/// Terminator of a comment or a CDATA section.
fn closing(mark: &str) -> &'static str {
    if mark == "<!--" { "-->" } else { "]]>" }
}

fn line_of(text: &str, at: usize) -> u32 {
    u32::try_from(text[..at].matches('\n').count() + 1).unwrap_or(u32::MAX)
}

/// The open elements.
#[derive(Default)]
struct Scan {
    /// By open element: number of namespace declarations in scope.
    namespaces: Vec<usize>,
    declared: usize,
}

impl Scan {
    fn enter(&mut self, tag: &Tag) -> Result<(), String> {
        let name = shown(tag.name);
        if tag.name.len() > LONGEST_NAME {
            let (bytes, most) = (tag.name.len(), LONGEST_NAME);
            return Err(format!(
                "element <{name}> has a name of {bytes} bytes, more than the limit of {most}"
            ));
        }
        if let Some(long) = tag.long_name {
            let (start, bytes) = (shown(long), long.len());
            return Err(format!(
                "element <{name}> has an attribute '{start}' with a name of {bytes} bytes, more than the limit of {LONGEST_NAME}"
            ));
        }
        if tag.attributes > MOST_ATTRIBUTES {
            return Err(format!("element <{name}> has more than the limit of {MOST_ATTRIBUTES} attributes"));
        }
        let in_scope = self.namespaces.last().copied().unwrap_or_default() + tag.namespaces;
        self.declared += tag.namespaces;
        if in_scope > MOST_NAMESPACES_IN_SCOPE || self.declared > MOST_NAMESPACES {
            let most = if in_scope > MOST_NAMESPACES_IN_SCOPE {
                format!("{MOST_NAMESPACES_IN_SCOPE} in scope")
            } else {
                format!("{MOST_NAMESPACES} in all")
            };
            return Err(format!("element <{name}> has too many namespace declarations: the limit is {most}"));
        }
        if self.namespaces.len() >= DEEPEST {
            return Err(format!("element <{name}> is nested deeper than the limit of {DEEPEST} levels"));
        }
        if !tag.is_empty {
            self.namespaces.push(in_scope);
        }
        Ok(())
    }
}

/// A start tag.
struct Tag<'t> {
    name: &'t str,
    /// Counted up to the limit plus one.
    attributes: usize,
    namespaces: usize,
    long_name: Option<&'t str>,
    /// True for an element without content.
    is_empty: bool,
    length: usize,
}

impl<'t> Tag<'t> {
    /// Reads the tag at the start of `text`. The search stops at the first attribute beyond the limit.
    fn at_start(text: &'t str) -> Self {
        let bytes = text.as_bytes();
        let is_end =
            |b: &u8| b.is_ascii_whitespace() || matches!(b, b'>' | b'/' | b'=' | b'"' | b'\'' | b'<');
        let word_end = |from: usize| bytes[from..].iter().position(is_end).map_or(bytes.len(), |n| from + n);
        let mut at = word_end(1);
        let mut tag = Self {
            name: &text[1..at],
            attributes: 0,
            namespaces: 0,
            long_name: None,
            is_empty: false,
            length: 0,
        };
        while let Some(&byte) = bytes.get(at) {
            match byte {
                b'>' => {
                    tag.is_empty = bytes[at - 1] == b'/';
                    at += 1;
                    break;
                }
                // the previous tag has no end: the parser reports it
                b'<' => break,
                b'"' | b'\'' => {
                    let close = bytes[at + 1..].iter().position(|&b| b == byte);
                    at = close.map_or(bytes.len(), |n| at + n + 2);
                }
                _ if is_end(&byte) => at += 1,
                _ => {
                    let end = word_end(at);
                    tag.add_attribute(&text[at..end]);
                    at = end;
                }
            }
            if tag.attributes > MOST_ATTRIBUTES {
                break;
            }
        }
        tag.length = at;
        tag
    }

    fn add_attribute(&mut self, name: &'t str) {
        self.attributes += 1;
        self.namespaces += usize::from(name.starts_with("xmlns"));
        if name.len() > LONGEST_NAME {
            self.long_name.get_or_insert(name);
        }
    }
}

/// At most forty characters of a name.
fn shown(name: &str) -> String {
    match name.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;

    fn message(text: &str) -> String {
        check(text).map_or_else(|e| format!("{}: {}", e.line, e.message), |()| "fine".to_owned())
    }

    fn attributes(count: usize, prefix: &str) -> String {
        (0..count).fold(String::new(), |mut all, i| {
            let _ = write!(all, " {prefix}{i}='a > b = \"c\"'");
            all
        })
    }

    #[test]
    fn attributes_are_counted_by_element() {
        let of = |count| format!("<a>\n<b{}/><c{}></c></a>", attributes(200, "x"), attributes(count, "y"));
        assert_eq!(message(&of(256)), "fine");
        assert_eq!(message(&of(257)), "2: element <c> has more than the limit of 256 attributes");
        assert!(message(&of(200_000)).contains("256 attributes"));
    }

    #[test]
    fn namespaces_are_counted_by_scope() {
        let declare = |count| format!("<a{}>", attributes(count, "xmlns:n"));
        assert_eq!(message(&declare(64)), "fine");
        assert!(message(&declare(65)).contains("namespace"));
        assert_eq!(message(&format!("{0}</a>{0}</a>", declare(40))), "fine");
        assert!(message(&format!("<r>{0}\n{0}", declare(40))).starts_with("2: "));
        assert!(message(&format!("<r>{}", "<a xmlns='x'/>".repeat(100_001))).contains("100000 in all"));
    }

    #[test]
    fn levels_are_counted_and_comments_are_not() {
        let deep = |levels: usize| format!("{}{}", "<a>".repeat(levels), "</a>".repeat(levels));
        assert_eq!(message(&deep(1000)), "fine");
        assert_eq!(message(&deep(1001)), "1: element <a> is nested deeper than the limit of 1000 levels");
        assert_eq!(message(&format!("<r>{}</r>", "<a b='c'/>".repeat(5000))), "fine");
        let hidden = deep(2000).replace("</a>", "");
        assert_eq!(message(&format!("<!--{hidden}--><r><![CDATA[{hidden}]]><?x {hidden}?></r>")), "fine");
    }

    #[test]
    fn long_names_are_named() {
        let long = "n".repeat(1025);
        assert!(message(&format!("<a><{long}/></a>")).contains("a name of 1025 bytes"));
        assert!(message(&format!("<a {long}='1'/>")).contains("'nnnn"));
        assert!(message(&format!("<a {long}='1'/>")).len() < 300);
        assert_eq!(message(&format!("<a b='{long}'/>")), "fine");
    }

    #[test]
    fn broken_text_is_left_to_the_parser() {
        for text in [
            "",
            "<",
            "<a",
            "<a b='",
            "<a b=\"c",
            "</",
            "<!",
            "<!-- ",
            "<?",
            "<ä ö='ü'><",
            "x</a></a>",
            "<a<b",
        ] {
            assert_eq!(message(text), "fine", "{text}");
        }
        assert_eq!(message(&format!("<!DOCTYPE a><a{}/>", attributes(1000, "x"))), "fine");
    }
}
