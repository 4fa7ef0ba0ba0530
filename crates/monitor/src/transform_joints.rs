//! Joints with several positions whose positions come from `tf`: a base that drives, flies or swims.

use std::time::Duration;

use clearance_geometry::math::{Extremes, Pose};
use clearance_robot::{JointId, RobotModel};
use clearance_scene::TransformTree;

use super::{MonitorSettings, Now, Reason, Time};

/// Largest deviation (m, rad) of a transform from the plane of a planar joint. The check ignores this deviation.
const PLANE_SLACK: f64 = 1e-3;

/// Transform of a joint from `tf`.
#[derive(Clone, Debug, PartialEq)]
struct TransformJoint {
    joint: JointId,
    /// Pose of the child link in the parent link, and its stamp; `None` while no transform connects the two links.
    found: Option<(Pose, Option<Time>)>,
    /// Time of its first use (steady clock), so that it also becomes old while ROS time stands still.
    since: Option<Duration>,
}

/// All joints whose positions come from `tf`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TransformJoints {
    transform_joints: Vec<TransformJoint>,
    /// Warnings about settings that cannot be applied.
    pub warnings: Vec<String>,
}

/// Successive positions of a configuration.
#[derive(Clone, Debug)]
pub(super) struct PlacedPositions {
    /// Index of the first position in a configuration.
    pub first: usize,
    pub positions: Vec<f64>,
}

/// Positions of all joints from `tf`, NaN where unknown, and the reason for the first unknown one.
#[derive(Debug)]
pub(super) struct TransformReading {
    pub placed: Vec<PlacedPositions>,
    pub unknown: Option<Reason>,
}

impl TransformJoints {
    /// Looks up the current transforms of the joints in the settings.
    pub fn look_up(robot: &RobotModel, settings: &MonitorSettings, tree: &TransformTree) -> Self {
        let mut all = Self::default();
        for name in &settings.transform_joints {
            let joint =
                robot.joint_by_name(name).filter(|&id| robot.joint(id).kind.position_suffixes().len() > 1);
            let Some(joint) = joint.filter(|&id| robot.first_position(id).is_some()) else {
                all.warnings.push(format!(
                    "transform_joints names '{name}', but the robot has no planar or floating joint of this name"
                ));
                continue;
            };
            let [parent, child] = frames(robot, joint);
            let found = tree.path(parent, child).map(|path| (path.pose(), path.oldest()));
            all.transform_joints.push(TransformJoint { joint, found, since: None });
        }
        all
    }

    /// Keeps the times of first use of transforms that have not changed.
    pub fn inherit(&mut self, before: &Self) {
        for transform_joint in &mut self.transform_joints {
            let same = before
                .transform_joints
                .iter()
                .find(|b| b.joint == transform_joint.joint && b.found == transform_joint.found);
            transform_joint.since = same.and_then(|same| same.since);
        }
    }

    /// Starts the age of new transforms.
    pub fn note_seen(&mut self, now: Now) {
        for transform_joint in &mut self.transform_joints {
            transform_joint.since.get_or_insert(now.steady);
        }
    }

    /// Stamp of the newest transform, if any has one.
    pub fn newest_stamp(&self) -> Option<Time> {
        self.transform_joints.iter().filter_map(|p| p.found?.1).max()
    }

    /// Whether all positions of the robot come from `tf`.
    pub fn place_all(&self, robot: &RobotModel) -> bool {
        let placed: usize =
            self.transform_joints.iter().map(|p| robot.joint(p.joint).kind.position_suffixes().len()).sum();
        placed > 0 && placed == robot.position_names().len()
    }

    /// Stamp of the oldest transform, if any has one.
    pub fn stamp(&self) -> Option<Time> {
        self.transform_joints.iter().filter_map(|p| p.found?.1).min()
    }

    /// Positions of the joints, NaN where unknown, and the reason for the first unknown one.
    pub fn read(&self, robot: &RobotModel, now: Now, settings: &MonitorSettings) -> TransformReading {
        let mut unknown = None;
        let read = |transform_joint: &TransformJoint| match transform_joint.read(robot, now, settings) {
            Ok(placed) => Some(placed),
            Err(why) => {
                unknown.get_or_insert(why);
                let count = robot.joint(transform_joint.joint).kind.position_suffixes().len();
                let first = robot.first_position(transform_joint.joint)?;
                Some(PlacedPositions { first, positions: vec![f64::NAN; count] })
            }
        };
        let placed = self.transform_joints.iter().filter_map(read).collect();
        TransformReading { placed, unknown }
    }

    /// Time (s) until the oldest transform becomes stale; infinite if none can become stale.
    pub fn time_to_stale(&self, now: Now, settings: &MonitorSettings) -> f64 {
        let age =
            now.ros.zip(self.stamp()).map_or(f64::NEG_INFINITY, |(ros, stamp)| ros.seconds_since(stamp));
        let since_reception = self
            .transform_joints
            .iter()
            .filter_map(|p| p.since_reception(now))
            .fold(f64::NEG_INFINITY, f64::greater);
        settings.transform_ttl - age.greater(since_reception)
    }
}

impl TransformJoint {
    /// Time (s) since the last new transform; `None` for a transform that cannot become stale.
    fn since_reception(&self, now: Now) -> Option<f64> {
        self.found?.1?;
        Some(now.steady.saturating_sub(self.since?).as_secs_f64())
    }

    fn read(
        &self,
        robot: &RobotModel,
        now: Now,
        settings: &MonitorSettings,
    ) -> Result<PlacedPositions, Reason> {
        let [parent, child] = frames(robot, self.joint);
        let joint = robot.joint(self.joint);
        let unknown = |why: String| Reason::NoTransform {
            joint: joint.name.clone(),
            frames: [parent.to_owned(), child.to_owned()],
            why,
        };
        let (pose_pc, stamp) =
            self.found.ok_or_else(|| unknown("nothing connects these frames".to_owned()))?;
        let ros = now.ros.ok_or(Reason::NoClock)?;
        let by_stamp = stamp.map_or(0.0, |stamp| ros.seconds_since(stamp));
        let age = by_stamp.greater(self.since_reception(now).unwrap_or(f64::NEG_INFINITY));
        let ttl = settings.transform_ttl;
        if age > ttl {
            return Err(unknown(format!("it is {age:.3} s old, and transform_ttl is {ttl} s")));
        }
        if -by_stamp > ttl {
            return Err(unknown(format!("it is stamped {:.3} s in the future", -by_stamp)));
        }
        let placed = joint.kind.positions_at(&(joint.pose_pj.inverse() * pose_pc));
        let first = robot.first_position(self.joint);
        let ((positions, apart), first) = placed
            .zip(first)
            .ok_or_else(|| unknown("the joint is neither planar nor floating".to_owned()))?;
        if apart > PLANE_SLACK {
            return Err(unknown(format!("it leaves the joint's plane by {apart:.4} (m, rad)")));
        }
        Ok(PlacedPositions { first, positions })
    }
}

/// Names of the parent link and child link of a joint.
fn frames(robot: &RobotModel, joint: JointId) -> [&str; 2] {
    let joint = robot.joint(joint);
    [joint.parent, joint.child].map(|link| robot.link(link).name.as_str())
}
