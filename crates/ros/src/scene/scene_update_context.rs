//! Snapshot of the node's state that scene updates are applied against.

use std::collections::BTreeMap;
use std::sync::Arc;

use clearance_monitor::{CheckedState, Evaluation, JointStateHistory, Now};
use clearance_robot::{Configuration, LinkPoses, RobotModel};
use clearance_scene::TransformTree;

use crate::parameters::parameter_set::Parameters;
use crate::scene::cloud_inbox::CloudMessage;

/// Robot and its configuration at the stamp of each point cloud, by topic.
pub type RobotsAtStamps = BTreeMap<String, (Arc<RobotModel>, Configuration)>;

/// Configuration of the robot at the stamps of point clouds.
#[must_use]
pub fn robots_at_stamps(
    clouds: &BTreeMap<String, CloudMessage>,
    joint_state_history: &JointStateHistory,
) -> RobotsAtStamps {
    clouds
        .iter()
        .filter_map(|(topic, cloud)| Some((topic.clone(), joint_state_history.at(cloud.stamp())?)))
        .collect()
}

/// Snapshot of clock, parameters, transforms and last result that a scene update is applied against.
#[derive(Debug)]
pub struct SceneUpdateContext {
    pub now: Now,
    pub parameters: Parameters,
    pub transforms: TransformTree,
    pub evaluation: Option<Evaluation>,
    /// Robot and its configuration at the stamp of each point cloud, by topic.
    pub robots_at_stamps: RobotsAtStamps,
}

impl SceneUpdateContext {
    /// State before anything but the parameters is known.
    #[must_use]
    pub fn first(parameters: &Parameters, now: Now) -> Self {
        Self {
            now,
            parameters: parameters.clone(),
            transforms: TransformTree::default(),
            evaluation: None,
            robots_at_stamps: RobotsAtStamps::default(),
        }
    }

    /// The monitor's last checked state, if it is for this robot.
    pub(super) fn checked_state(&self, robot: &Arc<RobotModel>) -> Option<Arc<CheckedState>> {
        let evaluation = self.evaluation.as_ref()?;
        let same = evaluation.revision.as_ref().is_some_and(|r| Arc::ptr_eq(r.checker.robot(), robot));
        evaluation.robot_state.clone().filter(|_| same)
    }

    /// Link poses at the stamp of a cloud, if the joint state history contains it; otherwise the current ones.
    pub(super) fn poses_at(&self, robot: &Arc<RobotModel>, topic: &str) -> Option<LinkPoses> {
        let now = self.checked_state(robot)?;
        let then = self.robots_at_stamps.get(topic).filter(|(of, _)| Arc::ptr_eq(of, robot));
        let Some((_, then)) = then else { return Some(now.poses.clone()) };
        let mut poses = LinkPoses::new(robot);
        robot.forward_kinematics(then, &mut poses);
        Some(poses)
    }
}
