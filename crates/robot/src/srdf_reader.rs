//! Reader of SRDF: pairs that may touch, groups, virtual and passive joints.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use roxmltree::Node;

use super::name_length::check_name_length;
use super::srdf::{DisabledPair, Group, GroupState, Srdf, VirtualJoint};
use super::xml::{Expected, Xml, foreign_attributes, is_foreign, own_children, plain_attribute, read_xml};
use super::{Fault, JointId, LinkId, RobotModel, Warning};

mod collision_rules;
mod group;
mod group_state_reader;

/// Types of virtual joints.
const VIRTUAL_KINDS: [&str; 3] = ["fixed", "floating", "planar"];

/// Elements that are read, with their attributes.
const READ_ATTRIBUTES: [(&str, &[&str]); 11] = [
    ("robot", &["name"]),
    ("group", &["name"]),
    ("joint", &["name", "value"]),
    ("link", &["name"]),
    ("chain", &["base_link", "tip_link"]),
    ("group_state", &["name", "group"]),
    ("virtual_joint", &["name", "type", "parent_frame", "child_link"]),
    ("passive_joint", &["name"]),
    ("disable_collisions", &["link1", "link2", "reason"]),
    ("enable_collisions", &["link1", "link2"]),
    ("disable_default_collisions", &["link"]),
];

/// Elements of SRDF and of Tesseract's dialect that do not concern collisions.
const IGNORED: [&str; 10] = [
    "end_effector",
    "joint_property",
    "link_sphere_approximation",
    "group_tcps",
    "group_opw",
    "kinematics_plugin_config",
    "contact_managers_plugin_config",
    "task_composer_plugin_config",
    "calibration_config",
    "collision_margins",
];

/// Reads an SRDF into `model`.
///
/// # Errors
/// Text that is not an SRDF, collision rules that name no link, and rules that would leave a pair unchecked if they were left out. All
/// other irregularities become warnings: they can only add pairs to check.
pub(super) fn apply(model: &mut RobotModel, text: &str, file: Option<&str>) -> Result<(), Fault> {
    let mut warnings = Vec::new();
    let expected = Expected { file, language: "an SRDF", root: "robot" };
    let read = read_xml(text, expected, &mut warnings, |xml, warnings| {
        let mut reader = Reader::new(xml, model);
        let srdf = reader.read();
        warnings.append(&mut reader.finished_warnings());
        srdf
    });
    let srdf = read??;
    model.warnings.extend(warnings);
    for &joint in &srdf.passive_joints {
        model.joints[joint.index()].passive = true;
    }
    model.srdf = Some(srdf);
    Ok(())
}

struct Reader<'d> {
    xml: &'d Xml<'d>,
    model: &'d RobotModel,
    links: HashMap<&'d str, LinkId>,
    joints: HashMap<&'d str, JointId>,
    virtual_joints: Vec<VirtualJoint>,
    warnings: Vec<Warning>,
    /// Unknown names: a warning for the first occurrence, with the number of occurrences.
    unknown: BTreeMap<(&'static str, String), (Warning, usize)>,
}

impl<'d> Reader<'d> {
    fn new(xml: &'d Xml<'d>, model: &'d RobotModel) -> Self {
        Self {
            xml,
            model,
            links: (model.links.iter().zip(0..)).map(|(l, i)| (l.name.as_str(), LinkId(i))).collect(),
            joints: (model.joints.iter().zip(0..)).map(|(j, i)| (j.name.as_str(), JointId(i))).collect(),
            virtual_joints: Vec::new(),
            warnings: Vec::new(),
            unknown: BTreeMap::new(),
        }
    }

    fn read(&mut self) -> Result<Srdf, Fault> {
        let root = self.xml.root();
        let robot_name = self.check_root(root)?;
        self.check_name_lengths(root)?;
        self.read_virtual_joints(root);
        let passive_joints = self.passive_joints(root);
        let rules = self.collision_rules(root)?;
        let groups = self.read_groups(root);
        let group_states = self.read_group_states(root, &groups);
        self.note_unknown_elements(root);
        Ok(Srdf {
            robot_name,
            disabled_pairs: rules.disabled_pairs,
            enabled_pairs: rules.enabled_pairs,
            unchecked_by_default: rules.unchecked_by_default,
            groups,
            group_states,
            virtual_joints: std::mem::take(&mut self.virtual_joints),
            passive_joints,
        })
    }

    fn check_root(&mut self, root: Node<'d, 'd>) -> Result<String, Fault> {
        self.xml.reject_xacro()?;
        if let Some(link) = own_children(root, "link").next() {
            let message = "the text is a URDF (it has <link>), not an SRDF: give it with --urdf";
            return Err(self.xml.fault(link, "", message));
        }
        let name = plain_attribute(root, "name").unwrap_or_default();
        if name != self.model.name {
            let message = format!("the SRDF is of robot '{name}', the URDF of robot '{}'", self.model.name);
            self.warn(root, "", message);
        }
        Ok(name.to_owned())
    }

    /// All attributes of an SRDF are names, except for values and reasons.
    fn check_name_lengths(&self, root: Node<'d, 'd>) -> Result<(), Fault> {
        for node in root.descendants().filter(Node::is_element) {
            let names = node.attributes().filter(|a| !matches!(a.name(), "value" | "reason"));
            for name in names {
                let fault = |excess| self.xml.fault(node, format!("<{}>", node.tag_name().name()), excess);
                check_name_length(name.value()).map_err(fault)?;
            }
        }
        Ok(())
    }

    fn read_virtual_joints(&mut self, root: Node<'d, 'd>) {
        for node in own_children(root, "virtual_joint") {
            let text = |name| plain_attribute(node, name).unwrap_or_default().trim().to_owned();
            let element = format!("virtual_joint '{}'", text("name"));
            if !VIRTUAL_KINDS.contains(&text("type").as_str()) {
                let message =
                    format!("type '{}' is not known; those are {}", text("type"), VIRTUAL_KINDS.join(", "));
                self.warn(node, element.as_str(), message);
            }
            if let Some(child_link) = self.link(node, "child_link", &element) {
                self.virtual_joints.push(VirtualJoint {
                    name: text("name"),
                    kind: text("type"),
                    parent_frame: text("parent_frame"),
                    child_link,
                });
            }
        }
    }

    fn passive_joints(&mut self, root: Node<'d, 'd>) -> Vec<JointId> {
        let nodes: Vec<Node> = own_children(root, "passive_joint").collect();
        nodes.into_iter().filter_map(|n| self.joint(n, "name", "passive_joint")).collect()
    }

    fn note_unknown_elements(&mut self, root: Node<'d, 'd>) {
        const READ: [&str; 7] = [
            "group",
            "group_state",
            "virtual_joint",
            "passive_joint",
            "disable_collisions",
            "enable_collisions",
            "disable_default_collisions",
        ];
        self.note_foreign_elements(root, &READ);
        self.note_foreign_attributes(root);
        let unknown: BTreeSet<&str> = (root.children().filter(|n| n.is_element() && !is_foreign(*n)))
            .map(|n| n.tag_name().name())
            .filter(|name| !READ.contains(name) && !IGNORED.contains(name))
            .collect();
        if !unknown.is_empty() {
            let names: Vec<String> = unknown.iter().map(|n| format!("<{n}>")).collect();
            self.warn(root, "", format!("not SRDF, ignored: {}", names.join(", ")));
        }
    }

    /// A warning for each name that is ignored because it has a different XML namespace.
    fn note_foreign_elements(&mut self, root: Node<'d, 'd>, read: &[&str]) {
        const READ_IN_GROUPS: [&str; 3] = ["joint", "link", "chain"];
        let is_told = |n: &Node| {
            let name = n.tag_name().name();
            n.is_element() && is_foreign(*n) && (read.contains(&name) || READ_IN_GROUPS.contains(&name))
        };
        let mut seen = BTreeSet::new();
        for node in root.descendants().filter(is_told) {
            let name = node.tag_name().name();
            if seen.insert(name) {
                let message = "has another XML namespace than <robot>; ignored: write it without prefix";
                self.warn(node, format!("<{name}>"), message);
            }
        }
    }

    /// A warning for each attribute that is ignored because it has an XML namespace.
    fn note_foreign_attributes(&mut self, root: Node<'d, 'd>) {
        let mut seen = BTreeSet::new();
        for node in root.descendants().filter(|n| n.is_element() && !is_foreign(*n)) {
            let element = node.tag_name().name();
            let Some((_, read)) = READ_ATTRIBUTES.iter().find(|(name, _)| *name == element) else { continue };
            for attribute in foreign_attributes(node).filter(|attribute| read.contains(attribute)) {
                if seen.insert((element, attribute)) {
                    let message = format!(
                        "attribute '{attribute}' has a namespace of its own and is not read: write it without prefix"
                    );
                    self.warn(node, format!("<{element}>"), message);
                }
            }
        }
    }

    /// The link that an attribute names, or a warning.
    fn link(&mut self, node: Node<'d, 'd>, attribute: &str, element: &str) -> Option<LinkId> {
        let name = plain_attribute(node, attribute).unwrap_or_default().trim();
        let id = self.links.get(name).copied();
        if id.is_none() {
            self.note_unknown("link", node, attribute, name, element);
        }
        id
    }

    /// The joint that an attribute names, or a warning; a virtual joint is valid, but is not a joint of the URDF.
    fn joint(&mut self, node: Node<'d, 'd>, attribute: &str, element: &str) -> Option<JointId> {
        let name = plain_attribute(node, attribute).unwrap_or_default().trim();
        let id = self.joints.get(name).copied();
        if id.is_none() && !self.virtual_joints.iter().any(|v| v.name == name) {
            self.note_unknown("joint", node, attribute, name, element);
        }
        id
    }

    fn note_unknown(&mut self, kind: &'static str, node: Node, attribute: &str, name: &str, element: &str) {
        if name.is_empty() {
            return self.warn(node, element, format!("has no {attribute}; ignored"));
        }
        let xml = self.xml;
        let warning = || xml.warning(node, element, format!("the robot has no {kind} '{name}'; ignored"));
        let entry = self.unknown.entry((kind, name.to_owned()));
        entry.or_insert_with(|| (warning(), 0)).1 += 1;
    }

    fn warn(&mut self, node: Node, element: impl Into<String>, message: impl Into<String>) {
        self.warnings.push(self.xml.warning(node, element, message));
    }

    /// All warnings, ordered by line.
    fn finished_warnings(&mut self) -> Vec<Warning> {
        let mut warnings = std::mem::take(&mut self.warnings);
        let unknown = std::mem::take(&mut self.unknown).into_values();
        warnings.extend(unknown.map(|(mut warning, count)| {
            if count > 1 {
                let more = count - 1;
                warning.message = format!("{}, here and at {more} more places", warning.message);
            }
            warning
        }));
        warnings.sort_by_key(|w| w.place.line);
        warnings
    }
}

#[cfg(test)]
mod tests;
