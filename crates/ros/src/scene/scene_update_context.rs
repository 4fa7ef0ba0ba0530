//! Snapshot of the node's state that scene updates are applied against.

use std::collections::BTreeMap;
use std::sync::Arc;

use clearance_monitor::{CheckedState, Coverage, Evaluation, JointStateHistory, Now};
use clearance_robot::{Configuration, LinkPoses, RobotModel};
use clearance_scene::TransformTree;

use crate::parameters::parameter_set::Parameters;
use crate::scene::cloud_inbox::CloudMessage;

/// The robot at the stamp of each point cloud, by topic.
pub type RobotsAtStamps = BTreeMap<String, RobotAtStamp>;

/// A robot at the stamp of a point cloud.
#[derive(Debug)]
pub struct RobotAtStamp {
    robot: Arc<RobotModel>,
    /// The oldest known configuration if the stamp is older.
    configuration: Configuration,
    /// Whether the configuration at the stamp is known.
    coverage: Coverage,
}

/// Poses of the links at the stamp of a point cloud.
pub(super) struct PosesAtStamp {
    pub poses: LinkPoses,
    /// Whether they are those at the stamp.
    pub coverage: Coverage,
}

/// Configuration of the robot at the stamps of point clouds. In a gap of the joint states longer than `stale_after` (s) it is unknown.
#[must_use]
pub fn robots_at_stamps(
    clouds: &BTreeMap<String, CloudMessage>,
    joint_state_history: &JointStateHistory,
    stale_after: f64,
) -> RobotsAtStamps {
    let at = |stamp| {
        let (robot, configuration) = joint_state_history.at(stamp)?;
        Some(RobotAtStamp {
            robot,
            configuration,
            coverage: joint_state_history.coverage(stamp, stale_after),
        })
    };
    clouds.iter().filter_map(|(topic, cloud)| Some((topic.clone(), at(cloud.stamp())?))).collect()
}

/// Snapshot of clock, parameters, transforms and last result that a scene update is applied against.
#[derive(Debug)]
pub struct SceneUpdateContext {
    pub now: Now,
    pub parameters: Parameters,
    pub transforms: TransformTree,
    pub evaluation: Option<Evaluation>,
    /// The robot at the stamp of each point cloud, by topic.
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

    /// Link poses at the stamp of a cloud, or the nearest ones that the joint state history has; without a history, the
    /// current ones.
    pub(super) fn poses_at(&self, robot: &Arc<RobotModel>, topic: &str) -> Option<PosesAtStamp> {
        let now = self.checked_state(robot)?;
        let then = self.robots_at_stamps.get(topic).filter(|then| Arc::ptr_eq(&then.robot, robot));
        let Some(then) = then else {
            return Some(PosesAtStamp { poses: now.poses.clone(), coverage: Coverage::Before });
        };
        let mut poses = LinkPoses::new(robot);
        robot.forward_kinematics(&then.configuration, &mut poses);
        Some(PosesAtStamp { poses, coverage: then.coverage })
    }
}
