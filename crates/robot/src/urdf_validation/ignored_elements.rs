//! Warnings about ignored elements and attributes: misspelt, misplaced, or of another XML namespace.
//!
//! URDF has no schema that forbids anything, and extensions of simulators occur everywhere in it. Next to links and joints, therefore,
//! only names that are almost right, or that contain elements that would be read, cause a warning. Inside collisions and joints every
//! unknown name does, unless it is a known extension.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::Validator;
use crate::Warning;
use crate::decimal_numbers::shortened;
use crate::similar_names::nearest;
use crate::xml::{is_foreign, only_text, plain_attribute};

/// Maximum number of warnings of this kind; a thoroughly wrong text has thousands.
const MOST_WARNINGS: usize = 20;

/// The names allowed inside an element.
struct Vocabulary {
    tag: &'static str,
    attributes: &'static [&'static str],
    children: &'static [&'static str],
    /// Elements and attributes that do not concern collisions.
    extensions: &'static [&'static str],
    /// True if unknown names are usual here.
    is_open: bool,
}

const fn leaf(tag: &'static str, attributes: &'static [&'static str]) -> Vocabulary {
    Vocabulary { tag, attributes, children: &[], extensions: &["name"], is_open: false }
}

const VOCABULARIES: [Vocabulary; 16] = [
    Vocabulary {
        tag: "robot",
        attributes: &["name", "version"],
        children: &["link", "joint"],
        extensions: &[
            "actuator",
            "controller",
            "deformable",
            "gazebo",
            "loop_joint",
            "material",
            "mujoco",
            "plugin",
            "ros2_control",
            "sensor",
            "transmission",
        ],
        is_open: true,
    },
    Vocabulary {
        tag: "link",
        attributes: &["name"],
        children: &["collision"],
        extensions: &["contact", "gazebo", "gravity", "inertial", "sensor", "type", "visual"],
        is_open: true,
    },
    Vocabulary {
        tag: "collision",
        attributes: &["name"],
        children: &["origin", "geometry"],
        extensions: &[
            "concave",
            "contact_coefficients",
            "gazebo",
            "group",
            "material",
            "max_contacts",
            "surface",
            "verbose",
        ],
        is_open: false,
    },
    Vocabulary {
        tag: "geometry",
        attributes: &[],
        children: &super::link::SHAPES,
        extensions: &["name"],
        is_open: false,
    },
    leaf("box", &["size"]),
    leaf("sphere", &["radius"]),
    leaf("cylinder", &["radius", "length"]),
    leaf("capsule", &["radius", "length"]),
    leaf("mesh", &["filename", "scale"]),
    Vocabulary {
        tag: "joint",
        attributes: &["name", "type"],
        children: &["origin", "parent", "child", "axis", "limit", "mimic"],
        extensions: &[
            "actuator",
            "calibration",
            "disableFixedJointLumping",
            "dont_collapse",
            "dynamics",
            "gazebo",
            "hardwareInterface",
            "preserveFixedJoint",
            "ros2_control",
            "safety_controller",
            "sensor",
            "transmission",
        ],
        is_open: false,
    },
    leaf("origin", &["xyz", "rpy", "quat_xyzw"]),
    leaf("axis", &["xyz"]),
    Vocabulary {
        tag: "limit",
        attributes: &["lower", "upper", "effort", "velocity", "acceleration"],
        children: &[],
        extensions: &["damping", "deceleration", "friction", "jerk"],
        is_open: false,
    },
    leaf("mimic", &["joint", "multiplier", "offset"]),
    leaf("parent", &["link"]),
    leaf("child", &["link"]),
];

/// Kinds of names, for messages.
const ELEMENT: &str = "element";
const ATTRIBUTE: &str = "attribute";

/// Elements that include the content of another file.
const INCLUDES: [&str; 1] = ["include"];

/// Ignored names, each with the warning about its first occurrence and the number of occurrences.
#[derive(Default)]
struct Unread(BTreeMap<(&'static str, &'static str, String), (Warning, usize)>);

impl<'d> Validator<'d> {
    /// Adds the warnings about ignored names, ordered by line.
    pub(super) fn warn_of_unread(&mut self, root: Node<'d, 'd>) {
        let mut unread = Unread::default();
        self.find_unread(root, &VOCABULARIES[0], "", &mut unread);
        let mut warnings: Vec<Warning> = (unread.0.into_values())
            .map(|(mut warning, count)| {
                if count > 1 {
                    let places =
                        if count == 2 { "1 more place" } else { &format!("{} more places", count - 1) };
                    warning.message = format!("{}; here and at {places}", warning.message);
                }
                warning
            })
            .collect();
        warnings.sort_by_key(|warning| warning.place.line);
        let more = warnings.len().saturating_sub(MOST_WARNINGS);
        warnings.truncate(MOST_WARNINGS);
        self.sound.warnings.extend(warnings);
        if more > 0 {
            self.warn(root, "", format!("{more} more names that are not read are not listed"));
        }
    }

    /// `label` names the link or joint that `node` belongs to.
    fn find_unread(&self, node: Node<'d, 'd>, vocabulary: &Vocabulary, label: &str, unread: &mut Unread) {
        let mut note = |kind: &'static str, name: &str, at: Node, message: String| {
            let key = (vocabulary.tag, kind, name.to_owned());
            unread.0.entry(key).or_insert_with(|| (self.xml.warning(at, label, message), 0)).1 += 1;
        };
        for attribute in node.attributes() {
            let name = attribute.name();
            if let Some(why) = vocabulary.why_attribute_is_unread(name, attribute.namespace().is_some()) {
                note(ATTRIBUTE, name, node, why);
            }
        }
        if let Some(text) = only_text(node).filter(|_| !vocabulary.is_open) {
            let message = format!("the text '{}' in <{}> is not read", shortened(text), vocabulary.tag);
            note("text", "", node, message);
        }
        let mut known = Vec::new();
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            if vocabulary.children.contains(&name) && !is_foreign(child) {
                known.push(child);
            } else if let Some(why) = vocabulary.why_element_is_unread(child) {
                note(ELEMENT, name, child, why);
            }
        }
        for child in known {
            let tag = child.tag_name().name();
            let named = matches!(tag, "link" | "joint").then(|| {
                format!("{tag} '{}'", shortened(plain_attribute(child, "name").unwrap_or_default().trim()))
            });
            if let Some(of_child) = vocabulary_of(tag) {
                self.find_unread(child, of_child, named.as_deref().unwrap_or(label), unread);
            }
        }
    }
}

impl Vocabulary {
    /// The reason why an attribute is ignored, if that deserves a warning.
    fn why_attribute_is_unread(&self, name: &str, has_namespace: bool) -> Option<String> {
        let is_known = self.attributes.contains(&name);
        let (quoted, tag) = (shortened(name), self.tag);
        if has_namespace {
            return is_known.then(|| {
                format!("attribute '{quoted}' of <{tag}> has a namespace of its own and is not read: write it without prefix")
            });
        }
        if is_known || self.extensions.contains(&name) {
            return None;
        }
        let near = nearest(name, self.attributes);
        let is_told = near.is_some() || !self.is_open;
        let hint =
            near.map_or_else(|| self.attributes_in_words(), |near| format!(": did you mean '{near}'?"));
        is_told.then(|| format!("attribute '{quoted}' of <{tag}> is not read{hint}"))
    }

    fn attributes_in_words(&self) -> String {
        match self.attributes {
            [] => "; it has no attributes".to_owned(),
            known => format!("; it has {}", known.join(", ")),
        }
    }

    /// The reason why an unknown child element is ignored, if that deserves a warning.
    fn why_element_is_unread(&self, child: Node) -> Option<String> {
        let name = child.tag_name().name();
        let quoted = shortened(name);
        if INCLUDES.contains(&name) {
            return Some(format!(
                "element '{quoted}' is not read, and the file that it names is not, either: put its content in its place"
            ));
        }
        if is_foreign(child) {
            let is_known = vocabulary_of(name).is_some();
            return is_known.then(|| {
                format!("element '{quoted}' has another XML namespace than <robot> and is not read: write it without prefix")
            });
        }
        if self.extensions.contains(&name) {
            return None;
        }
        if let Some(near) = nearest(name, self.children) {
            return Some(format!("element '{quoted}' is not read: did you mean '{near}'?"));
        }
        if let Some(near) = nearest(name, self.attributes) {
            return Some(format!(
                "element '{quoted}' is not read: write {near}=\"…\" as an attribute of <{}>",
                self.tag
            ));
        }
        if vocabulary_of(name).is_some() {
            return Some(format!("element '{quoted}' does not belong into <{}> and is not read", self.tag));
        }
        let held = child.descendants().skip(1).find(|n| n.is_element() && self.would_be_read(n));
        if let Some(held) = held {
            let held = held.tag_name().name();
            return Some(format!(
                "element '{quoted}' is not read, and neither is the <{held}> in it: put that into <{}>",
                self.tag
            ));
        }
        (!self.is_open).then(|| match self.children {
            [] => format!("element '{quoted}' in <{}> is not read", self.tag),
            known => format!("element '{quoted}' in <{}> is not read; it has {}", self.tag, known.join(", ")),
        })
    }

    /// True if an element inside an unknown one holds geometry, links or joints.
    fn would_be_read(&self, node: &Node) -> bool {
        let name = node.tag_name().name();
        let is_visual = || node.ancestors().any(|a| matches!(a.tag_name().name(), "visual" | "inertial"));
        (self.children.contains(&name) || matches!(name, "collision" | "geometry")) && !is_visual()
    }
}

fn vocabulary_of(tag: &str) -> Option<&'static Vocabulary> {
    // a robot is the outermost element
    VOCABULARIES[1..].iter().find(|vocabulary| vocabulary.tag == tag)
}
