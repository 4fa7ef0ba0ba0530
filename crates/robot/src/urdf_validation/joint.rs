//! Validation of joints: type, links, axis, limits, mimic.

use std::collections::HashSet;

use clearance_geometry::constants::AXIS_LENGTH_SLACK;
use clearance_geometry::math::{Extremes, Vector};
use roxmltree::Node;

use super::{JointNotes, Validator};
use crate::decimal_numbers::shortened;
use crate::xml::plain_attribute;

const TYPES: [&str; 6] = ["fixed", "revolute", "continuous", "prismatic", "floating", "planar"];

/// End of a warning about a planar joint that does not move in the plane of x and y.
const ODD_PLANE: &str = ": a planar joint moves in the plane perpendicular to its axis, as URDF defines; MoveIt ignores the axis and \
    moves it along x and y. Write axis '0 0 1', and turn <origin> instead";

impl<'d> Validator<'d> {
    pub(super) fn check_joint(&mut self, name: &str, joint: Node<'d, 'd>, links: &HashSet<&str>) {
        let element = format!("joint '{name}'");
        let kind = self.check_type(joint, &element);
        self.writer.open("joint", &[("name", name), ("type", kind)]);
        let rotation = self.check_origin(joint, &element);
        for end in ["parent", "child"] {
            let link = self.check_end(joint, &element, end, links);
            self.writer.element(end, &[("link", link)]);
        }
        if matches!(kind, "revolute" | "continuous" | "prismatic" | "planar") {
            self.check_axis(joint, &element, kind);
        }
        let limited = match kind {
            "revolute" | "prismatic" => self.check_limit(joint, &element, kind),
            _ => false,
        };
        self.check_mimic(joint, &element, kind);
        self.writer.close("joint");
        self.sound.joints.push(JointNotes { place: self.xml.place(joint, element), rotation, limited });
    }

    fn check_type(&mut self, joint: Node<'d, 'd>, element: &str) -> &'static str {
        let given = plain_attribute(joint, "type");
        if let Some(known) = TYPES.into_iter().find(|t| Some(*t) == given) {
            return known;
        }
        let message = match given {
            None => format!("has no type; the types are {}", TYPES.join(", ")),
            Some(other) => {
                format!("type '{}' is not known; the types are {}", shortened(other), TYPES.join(", "))
            }
        };
        self.fault(joint, element, message);
        "fixed"
    }

    fn check_end(&mut self, joint: Node<'d, 'd>, element: &str, end: &str, links: &HashSet<&str>) -> &'d str {
        let Some(node) = self.only_child(joint, end, element) else {
            self.fault(joint, element, format!("has no <{end}>"));
            return "";
        };
        let link = plain_attribute(node, "link").map(str::trim).unwrap_or_default();
        if link.is_empty() {
            self.fault(node, element, format!("<{end}> names no link"));
        } else if !links.contains(link) {
            let message = format!("{end} link '{}' does not exist", shortened(link));
            self.fault(node, element, message);
        }
        link
    }

    fn check_axis(&mut self, joint: Node<'d, 'd>, element: &str, kind: &str) {
        let Some(axis) = self.only_child(joint, "axis", element) else {
            if kind == "planar" {
                self.warn(joint, element, format!("has no <axis>, which is then '1 0 0'{ODD_PLANE}"));
            }
            return;
        };
        let xyz = plain_attribute(axis, "xyz").unwrap_or("1 0 0");
        let Some(components) = self.numbers::<3>(axis, element, "axis xyz", xyz) else {
            return;
        };
        let length = Vector::from(components).norm();
        if !length.is_finite() || length < 1e-9 {
            let message = format!("axis '{}' has no usable length", shortened(xyz));
            self.fault(axis, element, message);
        } else if (length - 1.0).abs() > AXIS_LENGTH_SLACK {
            let message = format!("axis '{}' has length {length}; only its direction counts", shortened(xyz));
            self.warn(axis, element, message);
        }
        let is_odd_plane = kind == "planar" && !is_along_z(components);
        if is_odd_plane {
            self.warn(axis, element, format!("axis is '{}'{ODD_PLANE}", shortened(xyz)));
        }
        self.writer.element("axis", &[("xyz", xyz)]);
    }

    /// Validates `<limit>` as urdfdom does; returns `true` if it limits the joint.
    fn check_limit(&mut self, joint: Node<'d, 'd>, element: &str, kind: &str) -> bool {
        const NAMES: [&str; 5] = ["lower", "upper", "effort", "velocity", "acceleration"];
        let Some(limit) = self.only_child(joint, "limit", element) else {
            self.fault(joint, element, format!("is {kind} and has no <limit>"));
            return false;
        };
        let values = NAMES.map(|name| self.limit_value(limit, element, name));
        let [lower, upper, _, velocity, _] = values;
        let unbounded = self.version >= (1, 2) && (lower.is_none() || upper.is_none());
        if unbounded && (lower.is_some() || upper.is_some()) {
            self.warn(
                limit,
                element,
                "limit has only one of lower and upper: the joint is taken as unbounded",
            );
        } else if !unbounded {
            self.check_bounds(limit, element, lower, upper);
        }
        // urdf-rs requires a velocity
        let attributes: Vec<(&str, &str)> = (NAMES.iter().zip(values))
            .filter_map(|(name, value)| value.and(Some((*name, plain_attribute(limit, name)?))))
            .chain(velocity.is_none().then_some(("velocity", "inf")))
            .collect();
        self.writer.element("limit", &attributes);
        !unbounded
    }

    /// A number of `<limit>`; only positions may be negative.
    fn limit_value(&mut self, limit: Node<'d, 'd>, element: &str, name: &str) -> Option<f64> {
        let text = plain_attribute(limit, name)?;
        let [value] = self.numbers(limit, element, &format!("limit {name}"), text)?;
        if value < 0.0 && !matches!(name, "lower" | "upper") {
            self.fault(limit, element, format!("limit {name} is negative"));
        }
        Some(value)
    }

    fn check_bounds(&mut self, limit: Node<'d, 'd>, element: &str, lower: Option<f64>, upper: Option<f64>) {
        if lower.is_none() && upper.is_none() {
            let message = "limit has neither lower nor upper, which URDF takes as 0: the joint cannot move";
            self.warn(limit, element, message);
        }
        let (lower, upper) = (lower.unwrap_or(0.0), upper.unwrap_or(0.0));
        if lower > upper {
            let message = format!("limit lower {lower} is greater than limit upper {upper}");
            self.fault(limit, element, message);
        }
    }

    fn check_mimic(&mut self, joint: Node<'d, 'd>, element: &str, kind: &str) {
        let Some(mimic) = self.only_child(joint, "mimic", element) else {
            return;
        };
        match kind {
            "fixed" => {
                return self.warn(mimic, element, "a fixed joint mimics none: <mimic> is ignored");
            }
            "floating" | "planar" => {
                return self.fault(mimic, element, format!("a {kind} joint cannot mimic another"));
            }
            _ => {}
        }
        let leader = plain_attribute(mimic, "joint").map(str::trim).unwrap_or_default();
        if leader.is_empty() {
            self.fault(mimic, element, "<mimic> names no joint");
        }
        let multiplier = plain_attribute(mimic, "multiplier").unwrap_or("1");
        let offset = plain_attribute(mimic, "offset").unwrap_or("0");
        self.numbers::<1>(mimic, element, "mimic multiplier", multiplier);
        self.numbers::<1>(mimic, element, "mimic offset", offset);
        self.writer.element("mimic", &[("joint", leader), ("multiplier", multiplier), ("offset", offset)]);
    }
}

/// Whether a direction is that of z, up to rounding of the text.
fn is_along_z([x, y, z]: [f64; 3]) -> bool {
    z > 0.0 && x.abs().greater(y.abs()) <= 1e-6 * z
}
