//! XML reader: parses text to a tree with the line of every element; nothing is expanded or fetched.

use std::borrow::Cow;

use roxmltree::{Document, Error, Node, ParsingOptions};

use super::decimal_numbers::shortened;
use super::{Fault, Place, Warning, xml_limits};

/// Maximum length (bytes) of an XML text; robot descriptions are rarely longer than one megabyte.
const LARGEST_TEXT: usize = 64 << 20;

/// Maximum number of nodes of a tree: about 200 MB of memory, a hundred times a humanoid with all its visuals.
const MOST_NODES: u32 = 2_000_000;

/// Maximum number of undeclared namespace prefixes that the reader declares itself.
const MOST_UNDECLARED_PREFIXES: usize = 16;

/// Root elements of other XML formats.
const KNOWN_ROOTS: [(&str, &str); 6] = [
    ("COLLADA", "a mesh"),
    ("sdf", "an SDF of Gazebo: convert it to a URDF"),
    ("mujoco", "a model of MuJoCo: convert it to a URDF"),
    ("launch", "a launch file"),
    ("package", "a package.xml"),
    ("svg", "a picture"),
];

/// First bytes of files of other kinds.
const KNOWN_BEGINNINGS: [(&str, &str); 14] = [
    ("solid", "an STL mesh"),
    ("ply", "a PLY mesh or cloud"),
    ("# .PCD", "a cloud, which --world takes"),
    ("v ", "an OBJ mesh"),
    ("mtllib", "an OBJ mesh"),
    ("(", "a .scene file, which --world takes"),
    ("# Octomap", "an octomap, which --world takes"),
    ("world:", "a planning scene, which --world takes"),
    ("collision_objects:", "a planning scene, which --world takes"),
    ("robot_state:", "a planning scene, which --world takes"),
    ("joint_names:", "a trajectory"),
    ("{", "JSON"),
    ("---", "YAML"),
    ("version https://git-lfs", "a pointer of Git LFS: fetch the file with git lfs pull"),
];

/// A parsed XML text with its name and line numbers.
pub(super) struct Xml<'d> {
    pub document: &'d Document<'d>,
    file: Option<String>,
    line_starts: Vec<usize>,
}

impl<'d> Xml<'d> {
    pub fn root(&self) -> Node<'d, 'd> {
        self.document.root_element()
    }

    /// # Errors
    /// If elements of xacro are left.
    pub fn reject_xacro(&self) -> Result<(), Fault> {
        let is_xacro = |n: &Node| n.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"));
        let Some(element) = self.root().descendants().find(is_xacro) else { return Ok(()) };
        let message = format!(
            "xacro:{} is still there: this is a xacro file, expand it first with `ros2 run xacro xacro FILE > OUT`",
            element.tag_name().name()
        );
        Err(self.fault(element, "", message))
    }

    /// Line of the element's start, from 1.
    pub fn line(&self, node: Node) -> u32 {
        let line = self.line_starts.partition_point(|&start| start <= node.range().start);
        u32::try_from(line).unwrap_or(u32::MAX)
    }

    /// Location of `node`; `element` describes to a reader what it belongs to.
    pub fn place(&self, node: Node, element: impl Into<String>) -> Place {
        let element = element.into();
        Place {
            file: self.file.clone(),
            line: Some(self.line(node)),
            element: (!element.is_empty()).then_some(element),
        }
    }

    pub fn fault(&self, node: Node, element: impl Into<String>, message: impl Into<String>) -> Fault {
        Fault { place: self.place(node, element), message: message.into() }
    }

    pub fn warning(&self, node: Node, element: impl Into<String>, message: impl Into<String>) -> Warning {
        Warning { place: self.place(node, element), message: message.into() }
    }
}

/// True if an element has a different XML namespace than the root element.
pub(super) fn is_foreign(node: Node) -> bool {
    node.tag_name().namespace() != node.document().root_element().tag_name().namespace()
}

/// The value of an attribute without a namespace: `Node::attribute` also finds those of other namespaces, whichever comes first.
pub(super) fn plain_attribute<'d>(node: Node<'d, '_>, name: &str) -> Option<&'d str> {
    let mut attributes = node.attributes();
    attributes.find(|other| other.namespace().is_none() && other.name() == name).map(|found| found.value())
}

/// Names of the attributes that have a namespace.
pub(super) fn foreign_attributes<'d>(node: Node<'d, 'd>) -> impl Iterator<Item = &'d str> {
    node.attributes().filter(|attribute| attribute.namespace().is_some()).map(|attribute| attribute.name())
}

/// The text of an element beside its child elements, if there is one.
pub(super) fn only_text<'d>(node: Node<'d, 'd>) -> Option<&'d str> {
    let texts = node.children().filter(Node::is_text).filter_map(|text| text.text());
    texts.map(str::trim).find(|text| !text.is_empty())
}

/// Child elements in the namespace of the outermost element.
pub(super) fn own_elements<'d>(node: Node<'d, 'd>) -> impl Iterator<Item = Node<'d, 'd>> {
    node.children().filter(|child| child.is_element() && !is_foreign(*child))
}

/// [`own_elements`] of that name.
pub(super) fn own_children<'d, 'n>(
    node: Node<'d, 'd>,
    name: &'n str,
) -> impl Iterator<Item = Node<'d, 'd>> + use<'d, 'n> {
    own_elements(node).filter(move |child| child.tag_name().name() == name)
}

/// The first of [`own_children`].
pub(super) fn own_child<'d>(node: Node<'d, 'd>, name: &str) -> Option<Node<'d, 'd>> {
    own_children(node, name).next()
}

/// All text directly inside an element. Comments, processing instructions and CDATA sections do not end it.
///
/// # Errors
/// If it contains an element: a clause that names that element.
pub(super) fn text<'d>(node: Node<'d, 'd>) -> Result<Cow<'d, str>, String> {
    if let Some(inner) = node.children().find(Node::is_element) {
        return Err(format!("has an element <{}> in its text", shortened(inner.tag_name().name())));
    }
    let mut parts = node.children().filter_map(|part| part.text().filter(|_| part.is_text()));
    let first = Cow::Borrowed(parts.next().unwrap_or_default());
    // in XML, sections separated by a comment are one value
    Ok(parts.fold(first, |all, part| all + part))
}

/// Expected kind of a text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected<'f> {
    /// Source of the text, for messages.
    pub file: Option<&'f str>,
    /// Such as `a URDF`.
    pub language: &'static str,
    /// The name of its outermost element.
    pub root: &'static str,
}

impl Expected<'_> {
    fn place(&self, line: Option<u32>) -> Place {
        Place { file: self.file.map(str::to_owned), line, element: None }
    }

    fn fault(&self, line: Option<u32>, message: impl Into<String>) -> Fault {
        Fault { place: self.place(line), message: message.into() }
    }

    /// The text is of a different kind.
    fn wrong_root(&self, found: &str, line: Option<u32>) -> Fault {
        let Self { language, root, .. } = self;
        let kind = KNOWN_ROOTS.iter().find(|(name, _)| name.eq_ignore_ascii_case(found));
        let kind = kind.map_or_else(String::new, |(_, kind)| format!(", {kind}"));
        let found = shortened(found);
        self.fault(line, format!("the text is <{found}>{kind}, but {language} begins with <{root}>"))
    }

    /// The text is not XML.
    fn no_xml(&self, text: &str) -> Fault {
        let first = text.lines().map(str::trim).find(|line| !line.is_empty()).unwrap_or_default();
        let line = text.lines().position(|line| !line.trim().is_empty());
        let kind = KNOWN_BEGINNINGS.iter().find(|(beginning, _)| first.starts_with(beginning));
        let kind = kind.map_or_else(String::new, |(_, kind)| format!(" (this looks like {kind})"));
        let Self { language, root, .. } = self;
        let line = line.and_then(|line| u32::try_from(line + 1).ok());
        let first = shortened(first);
        self.fault(
            line,
            format!("the text is no XML{kind}: {language} begins with <{root}>, not with '{first}'"),
        )
    }
}

/// Parses `text` and passes the tree to `read`.
///
/// A byte-order mark and the XML declaration are removed (its version and encoding have no effect: the text is already Unicode).
/// Undeclared namespace prefixes are declared. Both cause a warning where they are errors. Line numbers stay correct.
///
/// # Errors
/// An error with its line: bad syntax, an unexpected root element, a DTD (its entities are never expanded, nothing is fetched), a text
/// that is too long, or one beyond [`xml_limits`].
pub(super) fn read_xml<T>(
    text: &str,
    expected: Expected,
    warnings: &mut Vec<Warning>,
    read: impl FnOnce(&Xml, &mut Vec<Warning>) -> T,
) -> Result<T, Fault> {
    if text.len() > LARGEST_TEXT {
        let message =
            format!("the text has {} bytes, more than the {LARGEST_TEXT} that are read", text.len());
        return Err(expected.fault(None, message));
    }
    let begins = text.trim_start_matches('\u{feff}').trim_start();
    if !(begins.is_empty() || begins.starts_with('<')) {
        return Err(expected.no_xml(begins));
    }
    let mut text = without_declaration(text, &expected, warnings);
    xml_limits::check(&text).map_err(|excess| expected.fault(Some(excess.line), excess.message))?;
    for _ in 0..=MOST_UNDECLARED_PREFIXES {
        let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
        match Document::parse_with_options(&text, options) {
            Ok(document) => {
                let xml = Xml {
                    document: &document,
                    file: expected.file.map(str::to_owned),
                    line_starts: line_starts(&text),
                };
                let found = xml.root().tag_name().name();
                if found != expected.root {
                    return Err(expected.wrong_root(found, Some(xml.line(xml.root()))));
                }
                return Ok(read(&xml, warnings));
            }
            Err(Error::UnknownNamespace(prefix, position)) => {
                warnings.push(Warning {
                    place: expected.place(Some(position.row)),
                    message: format!("the namespace prefix '{prefix}' is not declared; taken as if it were"),
                });
                let Some(declared) = declare_prefix(&text, &prefix) else {
                    return Err(expected.fault(Some(position.row), format!("undeclared prefix '{prefix}'")));
                };
                text = Cow::Owned(declared);
            }
            Err(error) => return Err(syntax_fault(&expected, &error, &text)),
        }
    }
    let message = format!("more than {MOST_UNDECLARED_PREFIXES} namespace prefixes are not declared");
    Err(expected.fault(None, message))
}

fn syntax_fault(expected: &Expected, error: &Error, text: &str) -> Fault {
    match error {
        Error::DtdDetected => doctype_fault(expected, text),
        Error::NoRootNode if text.trim().is_empty() => {
            expected.fault(None, "the text is empty: it has no XML element")
        }
        Error::NoRootNode => expected.fault(None, "bad XML: there is no complete element; is the text cut?"),
        Error::NodesLimitReached => expected.fault(None, format!("more than {MOST_NODES} XML nodes")),
        Error::UnclosedRootNode => {
            expected.fault(None, "bad XML: the text is cut, its first element has no end")
        }
        other => expected.fault(Some(other.pos().row), format!("bad XML: {other}")),
    }
}

/// `<!DOCTYPE html>` is a web page; other document types may hold entities that expand or fetch.
fn doctype_fault(expected: &Expected, text: &str) -> Fault {
    let (before, rest) = text.split_once("<!DOCTYPE").unwrap_or((text, ""));
    let line = u32::try_from(before.matches('\n').count() + 1).ok();
    let name = rest.split(|c: char| c.is_whitespace() || c == '>').find(|w| !w.is_empty());
    match name {
        Some(name) if name.eq_ignore_ascii_case("html") => expected.wrong_root(name, line),
        _ => expected.fault(
            line,
            "a DOCTYPE is rejected: its entities are never expanded and nothing it names is fetched; remove it",
        ),
    }
}

/// The text without byte-order mark and XML declaration; a declaration's line breaks are kept.
fn without_declaration<'t>(text: &'t str, expected: &Expected, warnings: &mut Vec<Warning>) -> Cow<'t, str> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let Some((declaration, rest)) = text.trim_start().strip_prefix("<?xml ").and_then(|t| t.split_once("?>"))
    else {
        return Cow::Borrowed(text);
    };
    let version = declaration.split_once("version").and_then(|(_, v)| v.split(['"', '\'']).nth(1));
    if !matches!(version, Some("1.0" | "1.1")) {
        warnings.push(Warning {
            place: expected.place(Some(1)),
            message: format!("XML version '{}' does not exist; read as 1.0", version.unwrap_or_default()),
        });
    }
    let head = &text[..text.len() - rest.len()];
    if head.contains('\n') {
        let breaks = head.matches('\n').count();
        Cow::Owned("\n".repeat(breaks) + rest)
    } else {
        Cow::Borrowed(rest)
    }
}

/// The text with `prefix` declared on its first element; `None` when there is none.
fn declare_prefix(text: &str, prefix: &str) -> Option<String> {
    let mut at = 0;
    loop {
        at += text.get(at..)?.find('<')?;
        let rest = &text[at..];
        if rest.starts_with("<!--") {
            at += rest.find("-->")?;
        } else if rest.starts_with("<?") {
            at += rest.find("?>")?;
        } else {
            break;
        }
    }
    let name_end = at + text[at..].find(|c: char| c.is_whitespace() || c == '>' || c == '/')?;
    let (head, tail) = text.split_at(name_end);
    Some(format!("{head} xmlns:{prefix}=\"undeclared:{prefix}\"{tail}"))
}

fn line_starts(text: &str) -> Vec<usize> {
    std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root_line(text: &str) -> (Result<u32, String>, Vec<String>) {
        let mut warnings = Vec::new();
        let expected = Expected { file: Some("f.xml"), language: "an A", root: "a" };
        let result = read_xml(text, expected, &mut warnings, |xml, _| xml.line(xml.root()));
        let warnings = warnings.iter().map(ToString::to_string).collect();
        (result.map_err(|f| f.to_string()), warnings)
    }

    #[test]
    fn text_is_all_text_of_the_element() {
        let of = |content: &str| {
            let xml = format!("<a>{content}</a>");
            read_xml(&xml, Expected { file: None, language: "an A", root: "a" }, &mut Vec::new(), |xml, _| {
                text(xml.root()).map(Cow::into_owned)
            })
            .unwrap()
        };
        for (content, expected) in [
            ("", ""),
            ("1 2", "1 2"),
            ("1 <!-- c -->2<!-- d --> 3", "1 2 3"),
            ("<!-- c -->1<?x y?> 2", "1 2"),
            ("1<![CDATA[ 2 ]]>3<!-- c --><![CDATA[ 4]]>", "1 2 3 4"),
            ("<!-- only -->", ""),
            ("1 &#50;", "1 2"),
        ] {
            assert_eq!(of(content).as_deref(), Ok(expected), "{content}");
        }
        for content in ["1 <b/> 2", "<b>1</b>", "1<!-- c --><b/>"] {
            assert_eq!(of(content), Err("has an element <b> in its text".to_owned()), "{content}");
        }
    }

    #[test]
    fn lines_survive_mark_and_declaration() {
        let (result, warnings) = root_line("\u{feff}<?xml version=\"1.0\"\n encoding='utf-8'?>\n\n<a/>");
        assert_eq!(result, Ok(4));
        assert!(warnings.is_empty());
    }

    #[test]
    fn an_impossible_version_is_a_warning() {
        let (result, warnings) = root_line("<?xml version=\"0.0\" ?><a/>");
        assert!(result.is_ok());
        assert_eq!(warnings, ["f.xml:1: XML version '0.0' does not exist; read as 1.0"]);
    }

    #[test]
    fn undeclared_prefixes_are_a_warning() {
        let (result, warnings) = root_line("<!-- <b> -->\n<a>\n<s:x t:y='1'/></a>");
        assert_eq!(result, Ok(2));
        assert_eq!(warnings.len(), 2);
        assert!(warnings[0].starts_with("f.xml:3: "), "{warnings:?}");
    }

    #[test]
    fn entities_are_rejected() {
        let (result, _) = root_line("\n<!DOCTYPE a [<!ENTITY x 'y'>]><a>&x;</a>");
        assert!(result.unwrap_err().starts_with("f.xml:2: a DOCTYPE"));
    }

    #[test]
    fn what_is_no_xml_is_named() {
        for (text, words) in [
            ("solid arm\nfacet normal 0 0 1", "an STL mesh"),
            ("\n\nworld:\n  collision_objects: []\n", "--world"),
            ("joint_names: [a]\n", "a trajectory"),
            ("version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
            ("hello\n", "not with 'hello'"),
        ] {
            let message = root_line(text).0.unwrap_err();
            assert!(message.contains("no XML") && message.contains(words), "{message}");
            assert!(!message.contains('\n'), "{message}");
        }
        assert!(root_line("<COLLADA/>").0.unwrap_err().contains("a mesh, but an A begins with <a>"));
    }

    #[test]
    fn another_language_is_named() {
        for page in ["<!DOCTYPE html><html>", "<html/>"] {
            assert_eq!(
                root_line(page).0.unwrap_err(),
                "f.xml:1: the text is <html>, but an A begins with <a>"
            );
        }
    }

    #[test]
    fn a_hundred_thousand_levels_do_not_overflow_the_stack() {
        let deep = |levels: usize| "<a>".repeat(levels) + &"</a>".repeat(levels);
        assert!(root_line(&deep(1000)).0.is_ok());
        assert!(root_line(&deep(100_000)).0.unwrap_err().starts_with("f.xml:1: element <a> is nested"));
    }

    #[test]
    fn attributes_without_number_are_rejected_at_once() {
        let many = (0..200_000).map(|i| format!(" a{i}='x'")).collect::<Vec<_>>().concat();
        let (result, _) = root_line(&format!("<a>\n<b{many}/></a>"));
        assert_eq!(result.unwrap_err(), "f.xml:2: element <b> has more than the limit of 256 attributes");
    }

    #[test]
    fn faults_name_the_line() {
        let (result, _) = root_line("<a>\n<b>\n</a>");
        assert!(result.unwrap_err().starts_with("f.xml:3: bad XML"));
        assert!(root_line("").0.unwrap_err().contains("empty"));
    }
}
