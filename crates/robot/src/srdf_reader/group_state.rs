//! Named states (`<group_state>`): not used by any check; their errors are reported as warnings.

use std::collections::HashSet;

use roxmltree::Node;

use super::{Group, Reader};
use crate::JointKind;
use crate::decimal_numbers::{decimal, shortened};
use crate::srdf::GroupState;
use crate::xml::own_children;

/// Maximum number of remarks on named states; a thoroughly wrong text has thousands.
const MOST_REMARKS: usize = 20;

/// Largest deviation of a quaternion's length from 1.
const QUATERNION_SLACK: f64 = 1e-3;

impl<'d> Reader<'d> {
    /// Reads the named states; what is wrong with a value leaves it out, with a warning.
    pub(super) fn read_group_states(&mut self, root: Node<'d, 'd>, groups: &[Group]) -> Vec<GroupState> {
        let mut states = Vec::new();
        let mut remarks: Vec<(Node, String, String)> = Vec::new();
        let mut seen = HashSet::new();
        for state in own_children(root, "group_state") {
            let text = |name| state.attribute(name).unwrap_or_default().trim();
            let (name, group) = (text("name"), text("group"));
            let element = format!("group_state '{}'", shortened(name));
            let mut remark = |node, message: String| remarks.push((node, element.clone(), message));
            if name.is_empty() {
                remark(state, "has no name".to_owned());
            } else if !seen.insert((name, group)) {
                remark(state, format!("is there twice for group '{}'", shortened(group)));
            }
            let members = groups.iter().find(|g| g.name == group);
            if group.is_empty() {
                remark(state, "has no group".to_owned());
            } else if members.is_none() {
                remark(state, format!("there is no group '{}'", shortened(group)));
            }
            let (mut joints, mut positions) = (HashSet::new(), Vec::new());
            for joint in own_children(state, "joint") {
                let joint_name = joint.attribute("name").unwrap_or_default().trim();
                let fault = self.fault_of_joint(joint_name, members);
                let fault = fault.or_else(|| self.fault_of_value(joint, joint_name));
                let twice = (!joint_name.is_empty() && !joints.insert(joint_name))
                    .then(|| format!("joint '{}' is given twice", shortened(joint_name)));
                if twice.is_none() {
                    positions.extend(self.named_values(joint, joint_name));
                }
                fault.into_iter().chain(twice).for_each(|message| remark(joint, message));
            }
            if members.is_some() && !name.is_empty() {
                states.push(GroupState { name: name.to_owned(), group: group.to_owned(), positions });
            }
        }
        let more = remarks.len().saturating_sub(MOST_REMARKS);
        for (node, element, message) in remarks.into_iter().take(MOST_REMARKS) {
            self.warn(node, element, message);
        }
        if more > 0 {
            self.warn(root, "", format!("{more} more remarks about group states are not listed"));
        }
        states
    }

    /// Values of a joint of the robot by the names of its positions; empty if they are not the right number of numbers.
    fn named_values(&self, node: Node, name: &str) -> Vec<(String, f64)> {
        let Some(&id) = self.joints.get(name) else { return Vec::new() };
        let text = node.attribute("value").unwrap_or_default();
        let values: Result<Vec<f64>, String> = text.split_whitespace().map(decimal).collect();
        let suffixes = self.model.joint(id).kind.position_suffixes();
        match values {
            Ok(values) if values.len() == suffixes.len() => {
                suffixes.iter().map(|suffix| format!("{name}{suffix}")).zip(values).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Error in a joint name of a group state, if there is one.
    fn fault_of_joint(&self, name: &str, group: Option<&Group>) -> Option<String> {
        if name.is_empty() {
            return Some("a joint has no name".to_owned());
        }
        if self.virtual_joints.iter().any(|v| v.name == name) {
            return None;
        }
        let Some(&id) = self.joints.get(name) else {
            return Some(format!("the robot has no joint '{}'", shortened(name)));
        };
        let group = group.filter(|g| !g.joints.contains(&id))?;
        Some(format!("joint '{name}' is not in group '{}'", shortened(&group.name)))
    }

    /// Error in a joint value of a group state, if there is one.
    fn fault_of_value(&self, node: Node, name: &str) -> Option<String> {
        let count = self.position_count(name)?;
        let quoted = shortened(name);
        let Some(text) = node.attribute("value") else {
            return Some(format!("joint '{quoted}' has no value"));
        };
        let values: Result<Vec<f64>, String> = text.split_whitespace().map(decimal).collect();
        let values = match values {
            Ok(values) => values,
            Err(why) => return Some(format!("joint '{quoted}': value {why}")),
        };
        if values.len() != count {
            let (given, plural) = (values.len(), if count == 1 { "" } else { "s" });
            return Some(format!("joint '{quoted}' has {given} values, but must have {count} value{plural}"));
        }
        let id = self.joints.get(name).copied();
        if let (Some(id), &[value]) = (id, &values[..])
            && let Some(outside) = self.model.outside_limit(id, value)
        {
            return Some(outside.to_string());
        }
        let is_floating = count == 7;
        let length = || values[3..].iter().map(|c| c * c).sum::<f64>().sqrt();
        (is_floating && (length() - 1.0).abs() > QUATERNION_SLACK).then(|| {
            format!("joint '{quoted}' has a quaternion (x, y, z, w) of length {}, but it must be 1", length())
        })
    }

    /// Number of values of a joint in a state; `None` if it is not known.
    fn position_count(&self, name: &str) -> Option<usize> {
        let of_virtual = |kind: &str| match kind {
            "fixed" => Some(0),
            "planar" => Some(3),
            "floating" => Some(7),
            _ => None,
        };
        if let Some(joint) = self.virtual_joints.iter().find(|v| v.name == name) {
            return of_virtual(&joint.kind);
        }
        let joint = self.model.joint(*self.joints.get(name)?);
        // a mimic joint of a fixed joint may be named
        let follows = joint.mimic.is_some() && joint.kind == JointKind::Fixed;
        Some(if follows { 1 } else { joint.kind.position_suffixes().len() })
    }
}
