//! Reader of named states of the SRDF (`<group_state>`): their positions and their errors.

use std::collections::HashSet;

use roxmltree::Node;

use super::{Group, GroupState, Reader};
use crate::JointKind;
use crate::decimal_numbers::{decimal, shortened};
use crate::xml::{own_children, plain_attribute};

/// Maximum number of remarks on named states; a thoroughly wrong text has thousands.
const MOST_REMARKS: usize = 20;

/// Largest deviation of a quaternion's length from 1.
const QUATERNION_SLACK: f64 = 1e-3;

impl<'d> Reader<'d> {
    pub(super) fn read_group_states(&mut self, root: Node<'d, 'd>, groups: &[Group]) -> Vec<GroupState> {
        let mut remarks: Vec<(Node, String, String)> = Vec::new();
        let mut states: Vec<GroupState> = Vec::new();
        let mut seen = HashSet::new();
        for state in own_children(root, "group_state") {
            let text = |name| plain_attribute(state, name).unwrap_or_default().trim();
            let (name, group) = (text("name"), text("group"));
            let element = format!("group_state '{}'", shortened(name));
            let mut remark = |node, message: String| remarks.push((node, element.clone(), message));
            let mut is_first = true;
            if name.is_empty() {
                remark(state, "has no name".to_owned());
            } else if !seen.insert((name, group)) {
                is_first = false;
                remark(state, format!("is there twice for group '{}'", shortened(group)));
            }
            let members = groups.iter().find(|g| g.name == group);
            let mut fault = match members {
                Some(_) => None,
                None if group.is_empty() => Some("has no group".to_owned()),
                None => Some(format!("there is no group '{}'", shortened(group))),
            };
            if let Some(message) = &fault {
                remark(state, message.clone());
            }
            let mut positions = Vec::new();
            let mut joints = HashSet::new();
            for joint in own_children(state, "joint") {
                let name = plain_attribute(joint, "name").unwrap_or_default().trim();
                let of_name = self.fault_of_joint(name, members);
                let values = if of_name.is_none() { self.values(joint, name) } else { Ok(Vec::new()) };
                let (values, of_value) = match values {
                    Ok(values) => (values, None),
                    Err(message) => (Vec::new(), Some(message)),
                };
                let twice = (!name.is_empty() && !joints.insert(name))
                    .then(|| format!("joint '{}' is given twice", shortened(name)));
                let moves_root = self.fault_of_root_pose(name, &values);
                let faults = || of_name.iter().chain(&of_value).chain(&twice).chain(&moves_root);
                fault = fault.or_else(|| faults().next().cloned());
                let outside = self.outside(name, &values);
                faults().cloned().chain(outside).for_each(|message| remark(joint, message));
                positions.extend(self.named_positions(name, &values));
            }
            if is_first && !name.is_empty() {
                let (name, group) = (name.to_owned(), group.to_owned());
                states.push(GroupState { name, group, positions, fault });
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

    /// The names of a joint's positions with their values; none for virtual joints.
    fn named_positions(&self, name: &str, values: &[f64]) -> Vec<(String, f64)> {
        let Some(id) = self.joints.get(name).filter(|_| !self.is_virtual(name)) else { return Vec::new() };
        let joint = self.model.joint(*id);
        let suffixes = if values.len() == 1 { &[""][..] } else { joint.kind.position_suffixes() };
        suffixes.iter().zip(values).map(|(suffix, value)| (format!("{name}{suffix}"), *value)).collect()
    }

    fn is_virtual(&self, name: &str) -> bool {
        self.virtual_joints.iter().any(|joint| joint.name == name)
    }

    /// Error in the values of a virtual joint that is not at zero: no configuration contains the pose of the root.
    fn fault_of_root_pose(&self, name: &str, values: &[f64]) -> Option<String> {
        let is_at_zero = match values {
            // quaternions of both signs are the identity
            [offsets_and_vector @ .., _] if values.len() == 7 => offsets_and_vector.iter().all(|x| *x == 0.0),
            _ => values.iter().all(|x| *x == 0.0),
        };
        (self.is_virtual(name) && !is_at_zero).then(|| {
            format!(
                "virtual joint '{}' is not at zero, but a group state does not move the root: leave it out, or at zero; the robot_state \
                 of a planning scene (--world) places the robot among obstacles",
                shortened(name)
            )
        })
    }

    /// Error in a joint name of a group state, if there is one.
    fn fault_of_joint(&self, name: &str, group: Option<&Group>) -> Option<String> {
        if name.is_empty() {
            return Some("a joint has no name".to_owned());
        }
        if self.is_virtual(name) {
            return None;
        }
        let Some(&id) = self.joints.get(name) else {
            return Some(format!("the robot has no joint '{}'", shortened(name)));
        };
        let group = group.filter(|g| !g.joints.contains(&id))?;
        Some(format!("joint '{name}' is not in group '{}'", shortened(&group.name)))
    }

    /// The values of a joint of a group state, or the error in them; none if the number of values is not known.
    fn values(&self, node: Node, name: &str) -> Result<Vec<f64>, String> {
        let Some(count) = self.position_count(name) else { return Ok(Vec::new()) };
        let quoted = shortened(name);
        let text = plain_attribute(node, "value").ok_or_else(|| format!("joint '{quoted}' has no value"))?;
        let values: Result<Vec<f64>, String> = text.split_whitespace().map(decimal).collect();
        let values = values.map_err(|why| format!("joint '{quoted}': value {why}"))?;
        if values.len() != count {
            let (given, plural) = (values.len(), if count == 1 { "" } else { "s" });
            return Err(format!("joint '{quoted}' has {given} values, but must have {count} value{plural}"));
        }
        let is_floating = count == 7;
        let length = || values[3..].iter().map(|c| c * c).sum::<f64>().sqrt();
        if is_floating && (length() - 1.0).abs() > QUATERNION_SLACK {
            return Err(format!(
                "joint '{quoted}' has a quaternion (x, y, z, w) of length {}, but it must be 1",
                length()
            ));
        }
        Ok(values)
    }

    /// A remark on a value beyond the limits of its joint: it is used nevertheless.
    fn outside(&self, name: &str, values: &[f64]) -> Option<String> {
        let (id, &[value]) = (self.joints.get(name)?, values) else { return None };
        self.model.outside_limit(*id, value).map(|outside| outside.to_string())
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
