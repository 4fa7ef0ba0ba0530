//! Replaces the collision elements in a URDF text; the rest stays unchanged.

use std::ops::Range;

use clearance_robot::{LinkId, RobotModel, xml_attribute};

use crate::formats::text::number;
use crate::options::CoverError;

/// A collision element.
pub struct Element {
    pub name: String,
    /// Position (m), and roll, pitch, yaw (rad).
    pub pose: [[f64; 3]; 2],
    /// The element in `geometry`.
    pub geometry: String,
}

/// The text of collision elements.
pub fn elements_text(elements: impl Iterator<Item = Element>) -> String {
    let text = |Element { name, pose, geometry }: Element| {
        let [xyz, rpy] = pose.map(|numbers| numbers.map(number).join(" "));
        format!(
            "<collision name=\"{}\">\n      <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>\n      \
             <geometry>{geometry}</geometry>\n    </collision>",
            xml_attribute(&name)
        )
    };
    elements.map(text).collect::<Vec<_>>().join("\n    ")
}

/// The URDF text of a robot with the collision elements of each link replaced by a text. A link without one loses its elements.
pub fn with_collisions(
    robot: &RobotModel,
    urdf: &str,
    collisions_of: impl Fn(LinkId) -> Option<String>,
) -> Result<String, CoverError> {
    with_edited_collisions(robot, urdf, |id, [number, _], _| {
        let is_first = number == 0;
        Ok(if is_first { collisions_of(id).unwrap_or_default() } else { String::new() })
    })
}

/// The URDF text of a robot with each collision element replaced by the result of `edit`, which gets the link, the number of the element in
/// it and the count of its elements, and the text of the element.
pub fn with_edited_collisions(
    robot: &RobotModel,
    urdf: &str,
    edit: impl Fn(LinkId, [usize; 2], &str) -> Result<String, CoverError>,
) -> Result<String, CoverError> {
    let elements = link_elements(urdf).ok_or(CoverError::OtherUrdf)?;
    if elements.len() != robot.links().len() {
        return Err(CoverError::OtherUrdf);
    }
    let mut text = String::new();
    let mut copied = 0;
    for (id, collisions) in robot.link_ids().zip(elements) {
        let count = collisions.len();
        for (number, collision) in collisions.into_iter().enumerate() {
            text.push_str(&urdf[copied..collision.start]);
            text.push_str(&edit(id, [number, count], &urdf[collision.clone()])?);
            copied = collision.end;
        }
    }
    text.push_str(&urdf[copied..]);
    Ok(text)
}

/// By link element of a robot: the places of its collision elements. `None` if the text ends within an element.
///
/// The text has been read as a URDF before, so it is well-formed.
fn link_elements(urdf: &str) -> Option<Vec<Vec<Range<usize>>>> {
    let mut links: Vec<Vec<Range<usize>>> = vec![];
    // the names of the open elements, and where they start
    let mut open: Vec<(&str, usize)> = vec![];
    let mut at = 0;
    while let Some(offset) = urdf[at..].find('<') {
        let start = at + offset;
        at = start + markup_length(&urdf[start..])?;
        let tag = &urdf[start..at];
        if tag.starts_with("<!") || tag.starts_with("<?") {
            continue;
        }
        let is_end = tag.starts_with("</");
        if !is_end {
            let name = tag[1..].split(|c: char| c.is_whitespace() || c == '/' || c == '>').next()?;
            open.push((name, start));
            if open.len() == 2 && name == "link" {
                links.push(vec![]);
            }
        }
        if is_end || tag.ends_with("/>") {
            let (name, start) = open.pop()?;
            let is_in_link = open.len() == 2 && open[1].0 == "link";
            if is_in_link && name == "collision" {
                links.last_mut()?.push(start..at);
            }
        }
    }
    open.is_empty().then_some(links)
}

/// Length of the tag, comment, CDATA section, declaration or instruction at the start of a text.
pub fn markup_length(text: &str) -> Option<usize> {
    for (start, end) in [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")] {
        if let Some(rest) = text.strip_prefix(start) {
            return Some(rest.find(end)? + start.len() + end.len());
        }
    }
    let mut quote = None;
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (None, '>') => return Some(i + 1),
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), c) if c == open => quote = None,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn collisions_of_links_are_found_and_nothing_else() {
        let text = "<?xml version='1.0'?><!-- <link><collision/></link> --><robot name='a>b'>\n\
                    <link name='x'><collision><geometry/></collision><visual/><collision name=\"/>\"/></link>\n\
                    <link name='y'/><gazebo><link><collision/></link></gazebo></robot>";
        let links = link_elements(text).unwrap();
        let texts: Vec<Vec<&str>> =
            links.iter().map(|ranges| ranges.iter().map(|r| &text[r.clone()]).collect()).collect();
        let expected = vec![vec!["<collision><geometry/></collision>", "<collision name=\"/>\"/>"], vec![]];
        assert_eq!(texts, expected);
        assert_eq!(link_elements("<robot><link>"), None);
        assert_eq!(link_elements("<robot name='"), None);
    }
}
