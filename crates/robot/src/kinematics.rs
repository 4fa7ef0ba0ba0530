//! Forward kinematics: poses of all links.

use clearance_geometry::math::Pose;

use super::chain::{Chain, ChainJoint, Motion, Source};
use super::joint::plane_axes;
use super::{Configuration, JointId, JointKind, LinkId, RobotModel};

/// Pose of every link in the root frame, by link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkPoses(Vec<Pose>);

impl LinkPoses {
    /// Storage for the poses of `model`; all are at the root until computed.
    #[must_use]
    #[inline]
    pub fn new(model: &RobotModel) -> Self {
        Self(vec![Pose::identity(); model.links().len()])
    }

    /// Pose of a link in the root frame.
    #[must_use]
    #[inline]
    pub fn pose(&self, link: LinkId) -> &Pose {
        &self.0[link.index()]
    }
}

impl RobotModel {
    /// Computes the pose of every link for `q` into `poses`, without allocating.
    ///
    /// # Panics
    /// If `q` or `poses` were made for another model.
    #[inline]
    pub fn forward_kinematics(&self, q: &Configuration, poses: &mut LinkPoses) {
        poses.0[self.root.index()] = Pose::identity();
        for &id in &self.topological_order {
            let joint = self.joint(id);
            let pose_rj = poses.0[joint.parent.index()] * joint.pose_pj;
            let mut pose_rl = pose_rj * self.joint_motion(q, id);
            pose_rl.rotation.renormalize_fast();
            poses.0[joint.child.index()] = pose_rl;
        }
    }

    /// Kinematics of the `needed` links (by link), compiled for speed.
    #[must_use]
    #[inline]
    pub fn chain(&self, needed: &[bool]) -> Chain {
        let joints = self.topological_order.iter().map(|&id| {
            let joint = self.joint(id);
            ChainJoint {
                parent: joint.parent.index(),
                child: joint.child.index(),
                pose_pj: joint.pose_pj,
                motion: self.chain_motion(id),
            }
        });
        Chain::compile(self.root.index(), &joints.collect::<Vec<_>>(), needed)
    }

    fn chain_motion(&self, id: JointId) -> Motion {
        let joint = self.joint(id);
        let (driver, multiplier, offset) = match joint.mimic {
            Some(mimic) => (mimic.joint, mimic.multiplier, mimic.offset),
            None => (id, 1.0, 0.0),
        };
        let Some(index) = self.first_position(driver) else { return Motion::Fixed };
        let source = Source { index, multiplier, offset };
        match &joint.kind {
            JointKind::Fixed => Motion::Fixed,
            JointKind::Revolute(axis) | JointKind::Continuous(axis) => Motion::Revolute(*axis, source),
            JointKind::Prismatic(axis) => Motion::Prismatic(*axis, source),
            JointKind::Planar(axis) => Motion::Planar(plane_axes(axis), index),
            JointKind::Floating => Motion::Floating(index),
        }
    }

    fn joint_motion(&self, q: &Configuration, id: JointId) -> Pose {
        let joint = self.joint(id);
        match (self.joint_position(q, id), self.first_position(id)) {
            (Some(position), _) => joint.kind.motion(&[position]),
            (None, Some(first)) => joint.kind.motion(&q.positions()[first..]),
            (None, None) => Pose::identity(),
        }
    }
}
