//! Validation of URDF: rejects all content that `urdf-rs` would accept silently, with its line.
//!
//! `urdf-rs` drops numbers it cannot read, has no line numbers, fails on visuals and inertias that no collision query needs, and its XML
//! reader panics on some namespaces. So the text is read twice. First it is read here as XML, to find errors and their lines. Then
//! `urdf-rs` reads a validated text, reduced to the parts that collision checking needs. A second text, and not structs that are filled
//! here, because `urdf-rs` then remains the only place that defines the defaults and the conversion of attributes; both cost far less
//! than loading the meshes.

use std::collections::HashMap;

use clearance_geometry::math::Rotation;
use roxmltree::Node;

use super::decimal_numbers::shortened;
use super::name_length::check_name_length;
use super::xml::{Expected, Xml, own_children, plain_attribute, read_xml};
use super::{Fault, ModelError, Place, Warning};

mod ignored_elements;
mod joint;
mod link;
mod xml_writer;

use xml_writer::Writer;

/// A validated URDF, before links and joints are put together.
#[derive(Debug, Default)]
pub(super) struct ValidUrdf {
    /// Links with their collisions, and joints; nothing else, all with valid attributes.
    pub text: String,
    /// By link, in the order of the text.
    pub links: Vec<LinkNotes>,
    /// By joint, in the order of the text.
    pub joints: Vec<JointNotes>,
    pub warnings: Vec<Warning>,
}

/// Properties of a link that `urdf-rs` does not keep.
#[derive(Debug)]
pub(super) struct LinkNotes {
    pub place: Place,
    /// By collision, in the order of the text.
    pub collisions: Vec<CollisionNotes>,
}

/// Properties of a collision that `urdf-rs` does not keep.
#[derive(Debug)]
pub(super) struct CollisionNotes {
    pub place: Place,
    /// The rotation of `quat_xyzw`, instead of roll, pitch and yaw.
    pub rotation: Option<Rotation>,
}

/// Properties of a joint that `urdf-rs` does not keep.
#[derive(Debug)]
pub(super) struct JointNotes {
    pub place: Place,
    pub rotation: Option<Rotation>,
    /// True if there is a `<limit>` that has an effect.
    pub limited: bool,
}

/// The geometry of links that is validated and kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GeometryKind {
    Collision,
    /// Visual geometry, which is written as collisions: everything after the validation treats both alike.
    Visual,
}

impl GeometryKind {
    /// Name of the URDF element.
    fn tag(self) -> &'static str {
        match self {
            Self::Collision => "collision",
            Self::Visual => "visual",
        }
    }
}

/// Reads a URDF as XML and reports all its errors, as far as they can be found without meshes.
pub(super) fn check(text: &str, file: Option<&str>) -> Result<ValidUrdf, ModelError> {
    check_geometry(text, file, GeometryKind::Collision)
}

/// As [`check`], for one kind of geometry.
pub(super) fn check_geometry(
    text: &str,
    file: Option<&str>,
    kind: GeometryKind,
) -> Result<ValidUrdf, ModelError> {
    let mut warnings = Vec::new();
    let expected = Expected { file, language: "a URDF", root: "robot" };
    let checked = read_xml(text, expected, &mut warnings, |xml, _| Validator::new(xml, kind).check())?;
    let mut urdf = checked?;
    urdf.warnings.splice(0..0, warnings);
    Ok(urdf)
}

/// State of the validation: errors, warnings and validated text so far.
struct Validator<'d> {
    xml: &'d Xml<'d>,
    kind: GeometryKind,
    version: (u32, u32),
    faults: Vec<Fault>,
    sound: ValidUrdf,
    writer: Writer,
    /// Links with `<visual>` and without `<collision>`.
    without_collision: Vec<(String, Node<'d, 'd>)>,
}

/// Elements that only an SRDF has.
const SRDF_ELEMENTS: [&str; 8] = [
    "group",
    "group_state",
    "end_effector",
    "virtual_joint",
    "passive_joint",
    "disable_collisions",
    "enable_collisions",
    "disable_default_collisions",
];

/// Maximum number of links named in the warning about missing collision geometry.
const MOST_NAMED: usize = 20;

impl<'d> Validator<'d> {
    fn new(xml: &'d Xml<'d>, kind: GeometryKind) -> Self {
        Self {
            xml,
            kind,
            version: (1, 0),
            faults: Vec::new(),
            sound: ValidUrdf::default(),
            writer: Writer::default(),
            without_collision: Vec::new(),
        }
    }

    fn check(mut self) -> Result<ValidUrdf, ModelError> {
        let root = self.xml.root();
        self.check_root(root)?;
        let name = plain_attribute(root, "name").unwrap_or_default();
        if name.is_empty() {
            self.warn(root, "", "the robot has no name");
        }
        if let Err(excess) = check_name_length(name) {
            self.fault(root, "robot", excess);
        }
        let version = format!("{}.{}", self.version.0, self.version.1);
        self.writer.open("robot", &[("name", name), ("version", &version)]);
        let links = self.named(root, "link");
        for (name, link) in &links {
            self.check_link(name, *link);
        }
        self.warn_of_links_without_collision();
        let known = links.iter().map(|(name, _)| name.as_str()).collect();
        for (name, joint) in self.named(root, "joint") {
            self.check_joint(&name, joint, &known);
        }
        self.writer.close("robot");
        self.warn_of_unread(root);
        if links.is_empty() && self.faults.is_empty() {
            let of_srdf = |n: &Node| n.is_element() && SRDF_ELEMENTS.contains(&n.tag_name().name());
            let message = match root.children().find(of_srdf) {
                Some(element) => format!(
                    "the text is an SRDF (it has <{}> and no <link>), not a URDF: give it with --srdf, or publish it on \
                     robot_description_semantic",
                    element.tag_name().name()
                ),
                None => "the robot has no <link>".to_owned(),
            };
            self.fault(root, "", message);
        }
        self.sound.text = self.writer.finish();
        ModelError::unless_sound(self.sound, self.faults)
    }

    /// One warning for all links that are displayed but never checked.
    fn warn_of_links_without_collision(&mut self) {
        let Some((_, first)) = self.without_collision.first() else { return };
        let named = self.without_collision.iter().take(MOST_NAMED);
        let mut names: Vec<String> = named.map(|(name, _)| format!("'{}'", shortened(name))).collect();
        let count = self.without_collision.len();
        if count > MOST_NAMED {
            names.push(format!("and {} more", count - MOST_NAMED));
        }
        let links = if count == 1 { "1 link has" } else { &format!("{count} links have") };
        let message = format!(
            "{links} <visual> but no <collision> geometry and can not be checked: {}; \
             add <collision> elements to those that could touch something",
            names.join(", ")
        );
        // first, so that a truncated list still contains it
        self.sound.warnings.insert(0, self.xml.warning(*first, "", message));
    }

    /// Errors that make all others meaningless: the text is not a URDF.
    fn check_root(&mut self, root: Node<'d, 'd>) -> Result<(), Fault> {
        self.xml.reject_xacro()?;
        self.version = match plain_attribute(root, "version").map(str::trim) {
            None | Some("1.0") => (1, 0),
            Some("1") => {
                self.warn(root, "", "URDF version '1' is read as 1.0");
                (1, 0)
            }
            Some("1.1") => (1, 1),
            Some("1.2") => (1, 2),
            Some(other) => {
                let message =
                    format!("URDF version '{}' is not known; those are 1.0, 1.1 and 1.2", shortened(other));
                return Err(self.xml.fault(root, "", message));
            }
        };
        Ok(())
    }

    /// The links or joints by name. A missing or repeated name is an error, and such an element is left out.
    fn named(&mut self, root: Node<'d, 'd>, kind: &str) -> Vec<(String, Node<'d, 'd>)> {
        let mut first_lines: HashMap<&str, u32> = HashMap::new();
        let mut named = Vec::new();
        for node in own_children(root, kind) {
            let line = self.xml.line(node);
            match plain_attribute(node, "name").map(str::trim) {
                None | Some("") => self.fault(node, "", format!("a {kind} has no name")),
                Some(name) if is_unexpanded(name) => {
                    let message = format!("the {kind} name '{}' is unexpanded xacro", shortened(name));
                    self.fault(node, "", message);
                }
                Some(name) => {
                    if let Err(excess) = check_name_length(name) {
                        self.fault(node, kind, excess);
                    } else if let Some(first) = first_lines.insert(name, line) {
                        let message = format!("another {kind} has this name, at line {first}");
                        self.fault(node, format!("{kind} '{name}'"), message);
                    } else {
                        named.push((name.to_owned(), node));
                    }
                }
            }
        }
        named
    }

    fn fault(&mut self, node: Node, element: impl Into<String>, message: impl Into<String>) {
        self.faults.push(self.xml.fault(node, element, message));
    }

    fn warn(&mut self, node: Node, element: impl Into<String>, message: impl Into<String>) {
        self.sound.warnings.push(self.xml.warning(node, element, message));
    }

    /// The first child of that name; further ones are ignored with a warning.
    fn only_child(&mut self, node: Node<'d, 'd>, name: &str, element: &str) -> Option<Node<'d, 'd>> {
        let mut all = own_children(node, name);
        let first = all.next();
        if let Some(second) = all.next() {
            self.warn(second, element, format!("a second <{name}> is ignored"));
        }
        first
    }
}

/// True if a text contains expressions that xacro should have replaced.
fn is_unexpanded(text: &str) -> bool {
    text.contains("${") || text.contains("$(")
}

#[cfg(test)]
mod tests;
