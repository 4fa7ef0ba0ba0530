//! Content of an SRDF: pairs that may touch, groups, virtual and passive joints.

use super::ids::{JointId, LinkId};

/// An SRDF with its names resolved; entries about links and joints that the robot does not have are left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Srdf {
    /// Name of the robot.
    pub robot_name: String,
    /// Pairs never checked; each pair once, the link that comes first in the URDF first.
    pub disabled_pairs: Vec<DisabledPair>,
    /// Pairs that are checked although a default entry of their links would allow contact; ordered as above.
    pub enabled_pairs: Vec<(LinkId, LinkId)>,
    /// Links with `<disable_default_collisions>`: they may touch every link, unless a pair is named.
    pub unchecked_by_default: Vec<LinkId>,
    /// Named groups of joints and links.
    pub groups: Vec<Group>,
    /// Named states of groups, in the order of the text.
    pub group_states: Vec<GroupState>,
    /// Virtual joints, in the order of the text.
    pub virtual_joints: Vec<VirtualJoint>,
    /// Passive joints: not driven, but their positions are read.
    pub passive_joints: Vec<JointId>,
}

/// Reason of a pair that no entry names, and that is not checked because of one of its links.
const BY_DEFAULT: &str = "disable_default_collisions";

impl Srdf {
    /// All pairs of these links that are not checked, also because of a `<disable_default_collisions>`: each once, with the reason.
    #[must_use]
    pub fn unchecked_pairs(&self, links: impl Iterator<Item = LinkId>) -> Vec<(LinkId, LinkId, &str)> {
        let named: Vec<_> =
            self.disabled_pairs.iter().map(|pair| (pair.a, pair.b, pair.reason.as_str())).collect();
        let is_named = |a, b| {
            named.iter().any(|(x, y, _)| [(*x, *y), (*y, *x)].contains(&(a, b)))
                || self.enabled_pairs.iter().any(|pair| [(a, b), (b, a)].contains(pair))
        };
        let by_default = |link: &LinkId| self.unchecked_by_default.contains(link);
        let links: Vec<LinkId> = links.collect();
        let pairs = links.iter().flat_map(|a| links.iter().map(move |b| (*a, *b))).filter(|(a, b)| a < b);
        let unnamed = pairs.filter(|(a, b)| (by_default(a) || by_default(b)) && !is_named(*a, *b));
        let unnamed: Vec<_> = unnamed.map(|(a, b)| (a, b, BY_DEFAULT)).collect();
        named.into_iter().chain(unnamed).collect()
    }
}

/// Two links that are never checked against each other, with the reason given in the SRDF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisabledPair {
    /// The link that comes first in the URDF.
    pub a: LinkId,
    /// The other link.
    pub b: LinkId,
    /// Such as `Adjacent` or `Never`; may be empty.
    pub reason: String,
}

/// A named set of joints and links, in the URDF's order; chains and subgroups are resolved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Name of the group.
    pub name: String,
    /// The joints of the group.
    pub joints: Vec<JointId>,
    /// The child links of the joints, and links the group names by themselves.
    pub links: Vec<LinkId>,
}

/// A named state of a group's joints.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupState {
    /// Name of the state, unique within its group.
    pub name: String,
    /// Name of the group.
    pub group: String,
    /// Names and positions (rad, m) of its joints, in the order of the text; a joint with several positions has one entry
    /// for each. Virtual joints at zero are left out; elsewhere they are a fault, since the robot's root does not move.
    pub positions: Vec<(String, f64)>,
    /// Why the state cannot be used, if an entry is faulty.
    pub fault: Option<String>,
}

/// The pose of the robot's root in a frame outside of the robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VirtualJoint {
    /// Name of the joint.
    pub name: String,
    /// `fixed`, `floating` or `planar`.
    pub kind: String,
    /// The frame outside of the robot.
    pub parent_frame: String,
    /// The link whose pose the joint gives.
    pub child_link: LinkId,
}
