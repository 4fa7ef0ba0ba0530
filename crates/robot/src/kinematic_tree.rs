//! Kinematic tree of links and joints: root, topological order, rigid bodies, and errors such as cycles.

use std::collections::{HashMap, VecDeque};

use super::joint::{Joint, JointKind};
use super::{JointId, LinkId};

/// Parents of links, and links that move as one.
#[derive(Debug)]
pub(super) struct Tree {
    pub root: LinkId,
    /// Joints in topological order: parent links come before their children.
    pub topological_order: Vec<JointId>,
    /// By link; `None` for the root.
    pub parent_joint: Vec<Option<JointId>>,
    /// By link: the topmost link that it is connected to by fixed joints.
    pub rigid_body: Vec<LinkId>,
}

/// Reason why links and joints do not form a tree.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum TreeError {
    NoLinks,
    /// Two joints have this child.
    TwoParents(LinkId, JointId, JointId),
    /// More than one link has no parent.
    SeveralRoots(Vec<LinkId>),
    /// Each of these links is the parent of the next, and the last of the first.
    Cycle(Vec<LinkId>),
}

impl Tree {
    pub fn new(link_count: usize, joints: &[Joint]) -> Result<Self, TreeError> {
        let parent_joint = parent_joints(link_count, joints)?;
        let root = root(&parent_joint, joints)?;
        let mut children: HashMap<LinkId, Vec<JointId>> = HashMap::new();
        for (joint, id) in joints.iter().zip(0..) {
            children.entry(joint.parent).or_default().push(JointId(id));
        }
        let mut rigid_body: Vec<LinkId> = link_ids(link_count).collect();
        let mut topological_order = Vec::with_capacity(joints.len());
        let mut frontier = VecDeque::from([root]);
        while let Some(parent) = frontier.pop_front() {
            for id in children.remove(&parent).unwrap_or_default() {
                let joint = &joints[id.index()];
                topological_order.push(id);
                if joint.kind == JointKind::Fixed {
                    rigid_body[joint.child.index()] = rigid_body[parent.index()];
                }
                frontier.push_back(joint.child);
            }
        }
        // a joint that was never reached is below a cycle
        match children.values().flatten().next() {
            None => Ok(Self { root, topological_order, parent_joint, rigid_body }),
            Some(id) => {
                let start = joints[id.index()].parent;
                Err(TreeError::Cycle(cycle_above(start, &parent_joint, joints)))
            }
        }
    }
}

fn link_ids(count: usize) -> impl Iterator<Item = LinkId> {
    (0..u32::try_from(count).unwrap_or(u32::MAX)).map(LinkId)
}

fn root(parent_joint: &[Option<JointId>], joints: &[Joint]) -> Result<LinkId, TreeError> {
    let roots: Vec<LinkId> =
        link_ids(parent_joint.len()).filter(|l| parent_joint[l.index()].is_none()).collect();
    match roots[..] {
        [root] => Ok(root),
        [] if parent_joint.is_empty() => Err(TreeError::NoLinks),
        [] => Err(TreeError::Cycle(cycle_above(LinkId(0), parent_joint, joints))),
        _ => Err(TreeError::SeveralRoots(roots)),
    }
}

/// The cycle found by going up from `start`, parents before children.
fn cycle_above(start: LinkId, parent_joint: &[Option<JointId>], joints: &[Joint]) -> Vec<LinkId> {
    let mut path = Vec::new();
    let mut place_on_path = HashMap::new();
    let mut at = Some(start);
    while let Some(link) = at {
        if let Some(&first) = place_on_path.get(&link) {
            path.drain(..first);
            break;
        }
        place_on_path.insert(link, path.len());
        path.push(link);
        at = parent_joint[link.index()].map(|j| joints[j.index()].parent);
    }
    path.reverse();
    path
}

fn parent_joints(link_count: usize, joints: &[Joint]) -> Result<Vec<Option<JointId>>, TreeError> {
    let mut parent_joint: Vec<Option<JointId>> = vec![None; link_count];
    for (joint, id) in joints.iter().zip(0..) {
        let slot = &mut parent_joint[joint.child.index()];
        if let Some(first) = *slot {
            return Err(TreeError::TwoParents(joint.child, first, JointId(id)));
        }
        *slot = Some(JointId(id));
    }
    Ok(parent_joint)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::math::{Pose, Vector};

    fn joint(parent: u32, child: u32, moving: bool) -> Joint {
        let kind = if moving { JointKind::Continuous(Vector::z_axis()) } else { JointKind::Fixed };
        Joint {
            name: format!("{parent}-{child}"),
            kind,
            parent: LinkId(parent),
            child: LinkId(child),
            pose_pj: Pose::identity(),
            limits: None,
            mimic: None,
            passive: false,
        }
    }

    #[test]
    fn parents_come_first_and_fixed_links_move_as_one() {
        let joints = [joint(1, 2, false), joint(3, 1, true), joint(2, 0, false)];
        let tree = Tree::new(4, &joints).unwrap();
        assert_eq!(tree.root, LinkId(3));
        assert_eq!(tree.topological_order, [1, 0, 2].map(JointId));
        assert_eq!(tree.rigid_body, [1, 1, 1, 3].map(LinkId));
    }

    #[test]
    fn what_is_no_tree_is_named() {
        assert_eq!(Tree::new(0, &[]).unwrap_err(), TreeError::NoLinks);
        assert_eq!(Tree::new(2, &[]).unwrap_err(), TreeError::SeveralRoots(vec![LinkId(0), LinkId(1)]));
        let twice = [joint(0, 1, true), joint(2, 1, true)];
        assert_eq!(
            Tree::new(3, &twice).unwrap_err(),
            TreeError::TwoParents(LinkId(1), JointId(0), JointId(1))
        );
        let circle = [joint(0, 1, true), joint(1, 0, true)];
        assert_eq!(Tree::new(2, &circle).unwrap_err(), TreeError::Cycle(vec![LinkId(1), LinkId(0)]));
        // a root, a cycle, and a link below the cycle
        let beside = [joint(1, 2, true), joint(2, 1, true), joint(2, 3, true)];
        let Err(TreeError::Cycle(mut links)) = Tree::new(4, &beside) else {
            panic!("a circle beside the root was not found");
        };
        links.sort();
        assert_eq!(links, [LinkId(1), LinkId(2)]);
    }
}
