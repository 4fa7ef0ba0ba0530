//! Text of names and numbers.

use std::fmt::Write;

use clearance_geometry::math::Point;

use crate::sphere_cover::{CoverSphere, SphereCover};
use clearance_robot::RobotModel;

/// A name as a YAML string in double quotes.
pub fn quoted(name: &str) -> String {
    let mut text = String::from("\"");
    for c in name.chars() {
        match c {
            '"' | '\\' => text.extend(['\\', c]),
            c if c.is_control() => {
                // writing to a string does not fail
                let _ = write!(text, "\\U{:08X}", u32::from(c));
            }
            c => text.push(c),
        }
    }
    text.push('"');
    text
}

/// A name as the value of an XML attribute.
pub fn attribute(name: &str) -> String {
    let mut text = String::new();
    for c in name.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '"' => text.push_str("&quot;"),
            c if c.is_control() => {
                let _ = write!(text, "&#{};", u32::from(c));
            }
            c => text.push(c),
        }
    }
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
