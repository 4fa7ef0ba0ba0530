//! URDF with spheres as collision geometry, as VAMP and foam read it.

use std::fmt::Write;
use std::ops::Range;

use clearance_robot::RobotModel;

use crate::formats::text::{attribute, number};
use crate::options::CoverError;
use crate::sphere_cover::{CoverSphere, LinkCover, SphereCover};

/// The URDF text of a robot with its collision elements replaced by the spheres of a cover. All else is unchanged; a link without spheres
/// gets no collision element.
///
/// # Errors
/// If the text is not the one that the robot was read from: its number of links differs, or it ends within an element.
pub fn sphere_urdf(robot: &RobotModel, cover: &SphereCover, urdf: &str) -> Result<String, CoverError> {
    let elements = link_elements(urdf).ok_or(CoverError::OtherUrdf)?;
    if elements.len() != robot.links().len() {
        return Err(CoverError::OtherUrdf);
    }
    let mut text = String::new();
    let mut copied = 0;
    for (id, collisions) in robot.link_ids().zip(elements) {
        let spheres = cover.links.iter().find(|link| link.link == id);
        for (number, collision) in collisions.into_iter().enumerate() {
            text.push_str(&urdf[copied..collision.start]);
            if let (0, Some(link)) = (number, spheres) {
                text.push_str(&collision_elements(robot.described_name(id), link));
            }
            copied = collision.end;
        }
    }
    text.push_str(&urdf[copied..]);
    Ok(text)
}

fn collision_elements(name: &str, link: &LinkCover) -> String {
    let mut text = String::new();
    for (i, CoverSphere { centre, radius, .. }) in link.spheres.iter().enumerate() {
        let [x, y, z] = [centre.x, centre.y, centre.z].map(number);
        // writing to a string does not fail
        let _ = write!(
            text,
            "{}<collision name=\"{}_sphere_{i}\">\n      <origin xyz=\"{x} {y} {z}\" rpy=\"0 0 0\"/>\n      \
             <geometry><sphere radius=\"{}\"/></geometry>\n    </collision>",
            if i == 0 { "" } else { "\n    " },
            attribute(name),
            number(*radius)
        );
    }
    text
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
fn markup_length(text: &str) -> Option<usize> {
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
