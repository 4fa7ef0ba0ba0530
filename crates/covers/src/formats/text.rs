//! Text formatting of names, numbers and spheres for the files of covers.

use std::fmt::Write;

use clearance_geometry::math::Point;

use crate::sphere_cover::{CoverSphere, SphereCover};
use clearance_robot::RobotModel;

/// A name as a YAML string in double quotes. Line breaks and byte-order marks, which a parser removes or rejects, are escaped.
pub fn quoted(name: &str) -> String {
    let mut text = String::from("\"");
    for c in name.chars() {
        match c {
            '"' | '\\' => text.extend(['\\', c]),
            c if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}') => {
                // writing to a string does not fail
                let _ = write!(text, "\\U{:08X}", u32::from(c));
            }
            c => text.push(c),
        }
    }
    text.push('"');
    text
}

/// A number that is read back exactly, and as a floating-point number by every YAML parser.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Spheres by link as YAML, each line indented by `indent`.
pub fn spheres_by_link(robot: &RobotModel, cover: &SphereCover, indent: &str) -> String {
    let mut text = String::new();
    for link in cover.links.iter().filter(|link| !link.spheres.is_empty()) {
        let _ = writeln!(text, "{indent}{}:", quoted(robot.described_name(link.link)));
        for CoverSphere { centre, radius, .. } in &link.spheres {
            let Point { coords } = centre;
            let [x, y, z] = [coords.x, coords.y, coords.z].map(number);
            let _ = writeln!(
                text,
                "{indent}  - center: [{x}, {y}, {z}]\n{indent}    radius: {}",
                number(*radius)
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_on_one_line_for_every_parser() {
        assert_eq!(quoted("a \"b\" \\ 'c'"), r#""a \"b\" \\ 'c'""#);
        let breaks = ['\t', '\n', '\r', '\u{7f}', '\u{85}', '\u{2028}', '\u{2029}', '\u{feff}'];
        for c in breaks {
            assert_eq!(quoted(&format!("a{c}b")), format!("\"a\\U{:08X}b\"", u32::from(c)));
        }
        assert_eq!(quoted("é漢🤖\u{a0}"), "\"é漢🤖\u{a0}\"");
    }
}
