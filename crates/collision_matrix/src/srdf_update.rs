//! Adds entries to the text of an SRDF; everything that the text has stays as it is.

use clearance_robot::xml_attribute;

/// A new `disable_collisions` element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SrdfEntry {
    /// Name of the first link.
    pub link1: String,
    /// Name of the second link.
    pub link2: String,
    /// The reason, as `Never` or `Adjacent`.
    pub reason: &'static str,
}

/// Reason why entries cannot be added.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SrdfTextError {
    /// There is no `<robot>` element to add them to.
    #[error("the text has no <robot> element: entries cannot be added")]
    NoRobot,
}

/// Indentation of new entries without a model.
const INDENT: &str = "    ";

/// The text with new entries before the end of its `<robot>` element, or a new text if there is none. Line ends and indentation are those
/// of the text.
pub fn add_disabled_pairs(
    srdf: Option<&str>,
    robot: &str,
    entries: &[SrdfEntry],
) -> Result<String, SrdfTextError> {
    let Some(text) = srdf else {
        let robot = xml_attribute(robot);
        let lines = lines(entries, INDENT, "\n");
        return Ok(format!("<?xml version=\"1.0\"?>\n<robot name=\"{robot}\">\n{lines}</robot>\n"));
    };
    if entries.is_empty() {
        return Ok(text.to_owned());
    }
    let line_end = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let markup = markup(text);
    let indent = indent_of_entries(text, &markup).unwrap_or(INDENT);
    let lines = lines(entries, indent, line_end);
    let tags = || markup.iter().map(|(from, to)| (*from, &text[*from..*to]));
    if let Some((end, _)) = tags().rfind(|(_, tag)| is_tag(tag, "</robot")) {
        // entries come before the indentation of the end tag, if nothing else is on its line
        let line = text[..end].rfind('\n').map_or(0, |at| at + 1);
        let alone = text[line..end].trim().is_empty();
        let (at, before) = if alone { (line, "") } else { (end, line_end) };
        return Ok(format!("{}{before}{lines}{}", &text[..at], &text[at..]));
    }
    // <robot name="r"/>
    let (start, tag) = tags().find(|(_, tag)| is_tag(tag, "<robot")).ok_or(SrdfTextError::NoRobot)?;
    let slash = tag.strip_suffix("/>").ok_or(SrdfTextError::NoRobot)?.trim_end().len();
    let rest = &text[start + tag.len()..];
    Ok(format!("{}>{line_end}{lines}</robot>{rest}", &text[..start + slash]))
}

/// One line for each entry.
fn lines(entries: &[SrdfEntry], indent: &str, line_end: &str) -> String {
    let lines = entries.iter().flat_map(|entry| [indent.to_owned(), entry.element(), line_end.to_owned()]);
    lines.collect()
}

impl SrdfEntry {
    fn element(&self) -> String {
        let [link1, link2] = [&self.link1, &self.link2].map(|name| xml_attribute(name));
        format!("<disable_collisions link1=\"{link1}\" link2=\"{link2}\" reason=\"{}\"/>", self.reason)
    }
}

fn is_tag(tag: &str, start: &str) -> bool {
    let ends = |c: char| c.is_whitespace() || c == '>' || c == '/';
    tag.strip_prefix(start).is_some_and(|rest| rest.starts_with(ends))
}

/// Indentation of the last entry that is alone on its line.
fn indent_of_entries<'t>(text: &'t str, markup: &[(usize, usize)]) -> Option<&'t str> {
    let of_tag = |(from, to): &(usize, usize)| {
        let line = text[..*from].rfind('\n').map_or(0, |at| at + 1);
        let indent = &text[line..*from];
        (is_tag(&text[*from..*to], "<disable_collisions") && indent.trim().is_empty()).then_some(indent)
    };
    markup.iter().rev().find_map(of_tag)
}

/// Ranges of the start and end tags; comments, CDATA sections and processing instructions are left out.
fn markup(text: &str) -> Vec<(usize, usize)> {
    let (mut found, mut at) = (Vec::new(), 0);
    while let Some(open) = text[at..].find('<').map(|offset| at + offset) {
        let rest = &text[open..];
        let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("<!", ">")];
        if let Some((start, end)) = skipped.into_iter().find(|(start, _)| rest.starts_with(start)) {
            at = rest[start.len()..].find(end).map_or(text.len(), |to| open + start.len() + to + end.len());
            continue;
        }
        at = open + end_of_tag(rest);
        found.push((open, at));
    }
    found
}

/// Length of a tag; a `>` in quotes does not end it.
fn end_of_tag(tag: &str) -> usize {
    let mut quote = None;
    for (at, c) in tag.char_indices() {
        match (c, quote) {
            ('>', None) => return at + 1,
            ('"' | '\'', None) => quote = Some(c),
            (c, Some(open)) if c == open => quote = None,
            _ => {}
        }
    }
    tag.len()
}

#[cfg(test)]
mod tests {
    use clearance_robot::{MeshFiles, RobotModel, RobotText};

    use super::*;

    fn entry() -> [SrdfEntry; 1] {
        [SrdfEntry { link1: "a".to_owned(), link2: "b&c".to_owned(), reason: "Never" }]
    }

    const ELEMENT: &str = r#"<disable_collisions link1="a" link2="b&amp;c" reason="Never"/>"#;

    #[test]
    fn everything_else_stays_as_it_is() {
        let texts = [
            "<robot name=\"r\">\n  <!-- </robot> -->\n  <disable_collisions link1=\"x\" link2='y>' reason=\"mine\"/>\n</robot>\n<!-- end </robot> -->\n",
            "<?xml version='1.0'?>\r\n<robot name='r'>\r\n\t<group name='g'/>\r\n</robot>",
            "<robot name='r'><group name='g'/></robot>",
        ];
        for text in texts {
            let new = add_disabled_pairs(Some(text), "r", &entry()).unwrap();
            let without: Vec<&str> = new.lines().filter(|line| !line.contains(ELEMENT)).collect();
            let kept = without.join("").replace('\r', "");
            assert_eq!(kept, text.replace(['\n', '\r'], ""), "{new}");
            assert_eq!(new.matches(ELEMENT).count(), 1);
            assert_eq!(new.contains("\r\n"), text.contains("\r\n"));
        }
        let new = add_disabled_pairs(Some(texts[0]), "r", &entry()).unwrap();
        assert!(new.contains(&format!("\n  {ELEMENT}\n</robot>\n<!-- end")), "{new}");
    }

    /// A reader replaces a plain line break by a blank: the entry would be about another link.
    #[test]
    fn entries_are_read_back_with_every_character_of_a_name() {
        let names = ["base", "a&#10;b", "a b", "a&#9;b", "a&#x85;b", "a&#x2028;b", "a&quot;&amp;&lt;>'b"];
        let link = |name: &str| format!("<link name=\"{name}\"/>");
        let joint = |name: &str| {
            format!(
                "<joint name=\"to {name}\" type='fixed'><parent link='base'/><child link=\"{name}\"/></joint>"
            )
        };
        let links = names.map(link).concat();
        let joints: String = names[1..].iter().map(|name| joint(name)).collect();
        let urdf = format!("<robot name='r'>{links}{joints}</robot>");
        let read = |srdf: Option<&str>| {
            let text = RobotText { urdf: &urdf, srdf, ..RobotText::default() };
            RobotModel::from_text(&text, &MeshFiles::default()).unwrap()
        };
        let robot = read(None);
        for link in robot.links() {
            for other in robot.links().iter().filter(|other| other.name > link.name) {
                let (link1, link2) = (link.name.clone(), other.name.clone());
                let entries = [SrdfEntry { link1, link2, reason: "Never" }];
                for before in [None, Some("<robot name='r'/>")] {
                    let model = read(Some(&add_disabled_pairs(before, "r", &entries).unwrap()));
                    assert!(model.warnings().is_empty(), "{:?}", model.warnings());
                    let [pair] = &model.srdf().unwrap().disabled_pairs[..] else { panic!("one pair") };
                    let mut found = [pair.a, pair.b].map(|id| &model.link(id).name);
                    found.sort_unstable();
                    assert_eq!(found, [&link.name, &other.name]);
                }
            }
        }
    }

    #[test]
    fn texts_without_content_get_one() {
        let new = add_disabled_pairs(Some("<robot name='r' />\n"), "r", &entry()).unwrap();
        assert_eq!(new, format!("<robot name='r'>\n    {ELEMENT}\n</robot>\n"));
        let new = add_disabled_pairs(None, "r<", &entry()).unwrap();
        assert!(new.contains("<robot name=\"r&lt;\">\n") && new.ends_with("</robot>\n"));
        assert_eq!(add_disabled_pairs(Some("<urdf/>"), "r", &entry()), Err(SrdfTextError::NoRobot));
    }
}
