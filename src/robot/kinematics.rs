//! Forward kinematics: where every link is.

use super::{Configuration, JointId, LinkId, RobotModel};
use crate::math::Pose;

/// Pose of every link in the root frame, by link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkPoses(Vec<Pose>);

impl LinkPoses {
    /// Room for the poses of `model`, all at the root until computed.
    #[must_use]
    pub fn new(model: &RobotModel) -> Self {
        Self(vec![Pose::identity(); model.links().len()])
    }

    /// Pose of a link in the root frame.
    #[must_use]
    pub fn pose(&self, link: LinkId) -> &Pose {
        &self.0[link.index()]
    }
}

impl RobotModel {
    /// Computes the pose of every link for `q` into `poses`, without allocating.
    ///
    /// # Panics
    /// When `q` or `poses` were made for another model.
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

    fn joint_motion(&self, q: &Configuration, id: JointId) -> Pose {
        let joint = self.joint(id);
        match (self.joint_position(q, id), self.first_position(id)) {
            (Some(position), _) => joint.kind.motion(&[position]),
            (None, Some(first)) => joint.kind.motion(&q.positions()[first..]),
            (None, None) => Pose::identity(),
        }
    }
}
