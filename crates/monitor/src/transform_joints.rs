//! Joints with several positions whose positions come from `tf`: a base that drives, flies or swims.

use std::collections::BTreeMap;
use std::ops::Range;

use clearance_geometry::math::{Extremes, Pose};
use clearance_robot::{JointId, RobotModel};
use clearance_scene::{FramePath, NumberedPose, TransformTree};

use super::transform_ages::TransformAges;
use super::transform_stamps::TransformStamps;
use super::unevaluated_states::PartialState;
use super::{MonitorSettings, Now, Reason, Time};

/// Largest deviation (m, rad) of a transform from the plane of a planar joint. The check ignores this deviation.
const PLANE_SLACK: f64 = 1e-3;

/// Transform of a joint from `tf`.
#[derive(Clone, Debug, PartialEq)]
struct TransformJoint {
    joint: JointId,
    /// Pose of the child link in the parent link, and the ages of the transforms between them; `None` while none
    /// connects the two links.
    found: Option<(Pose, TransformAges)>,
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

/// Positions from `tf` with their time.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedAt {
    /// Their indices in a configuration.
    pub positions: Range<usize>,
    /// The time that they are of.
    pub stamp: Time,
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
            let found =
                tree.path(parent, child).map(|path| (path.pose(), TransformAges::of(path.stamped_links())));
            all.transform_joints.push(TransformJoint { joint, found });
        }
        all
    }

    /// Keeps the times of first use of transforms that have not changed.
    pub fn inherit(&mut self, before: &Self) {
        for transform_joint in &mut self.transform_joints {
            let same = before.transform_joints.iter().find(|b| b.joint == transform_joint.joint);
            if let (Some((_, ages)), Some((_, before))) =
                (&mut transform_joint.found, same.and_then(|same| same.found.as_ref()))
            {
                ages.inherit(before);
            }
        }
    }

    /// Starts the age of new transforms.
    pub fn note_seen(&mut self, now: Now) {
        for transform_joint in &mut self.transform_joints {
            if let Some((_, ages)) = &mut transform_joint.found {
                ages.note_seen(now);
            }
        }
    }

    /// The time that the newest position is of, if any can become stale.
    pub fn newest_stamp(&self, now: Now) -> Option<Time> {
        let ros = now.ros?;
        self.ages().filter_map(|ages| ages.pose_stamp(ros)).max()
    }

    /// The time that the oldest position is of, if any can become stale.
    pub fn pose_stamp(&self, now: Now) -> Option<Time> {
        let ros = now.ros?;
        self.ages().filter_map(|ages| ages.pose_stamp(ros)).min()
    }

    /// The frames and stamps of all transforms.
    pub fn stamps(&self) -> TransformStamps {
        let stamps = self.ages().flat_map(TransformAges::stamps);
        stamps.map(|(frame, stamp)| (frame.to_owned(), stamp)).collect()
    }

    /// The times that positions are of.
    pub fn placed_at(&self, robot: &RobotModel, now: Now) -> Vec<PlacedAt> {
        let placed = self.transform_joints.iter().filter_map(|TransformJoint { joint, found }| {
            let first = robot.first_position(*joint)?;
            let count = robot.joint(*joint).kind.position_suffixes().len();
            let stamp = found.as_ref()?.1.pose_stamp(now.ros?)?;
            Some(PlacedAt { positions: first..first + count, stamp })
        });
        placed.collect()
    }

    /// Successive positions from the transforms that were received after the one with this number, in the order of reception; `None`
    /// if some are not kept any more, or a joint has no position now.
    pub fn positions_since(
        &self,
        robot: &RobotModel,
        tree: &TransformTree,
        number: u64,
    ) -> Option<Vec<PartialState>> {
        let mut states = Vec::new();
        for TransformJoint { joint, .. } in &self.transform_joints {
            let [parent, child] = frames(robot, *joint);
            let (path, first) = (tree.path(parent, child)?, robot.first_position(*joint)?);
            for (number, pose) in poses_since(&path, tree, number)? {
                let of_joint = robot.joint(*joint);
                let placed = of_joint.kind.positions_at(&(of_joint.pose_pj.inverse() * pose));
                states.extend(placed.map(|(positions, _)| (number, (first..).zip(positions).collect())));
            }
        }
        states.sort_by_key(|(number, _)| *number);
        Some(states.into_iter().map(|(_, state)| state).collect())
    }

    /// Whether all positions of the robot come from `tf`.
    pub fn place_all(&self, robot: &RobotModel) -> bool {
        let placed: usize =
            self.transform_joints.iter().map(|p| robot.joint(p.joint).kind.position_suffixes().len()).sum();
        placed > 0 && placed == robot.position_names().len()
    }

    /// Stamp of the oldest transform, if any has one.
    pub fn stamp(&self) -> Option<Time> {
        self.ages().filter_map(TransformAges::oldest_stamp).min()
    }

    fn ages(&self) -> impl Iterator<Item = &TransformAges> {
        self.transform_joints.iter().filter_map(|p| Some(&p.found.as_ref()?.1))
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
        let age = self.ages().map(|ages| ages.age(now)).fold(f64::NEG_INFINITY, f64::greater);
        settings.transform_ttl - age
    }
}

impl TransformJoint {
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
        let (pose_pc, ages) =
            self.found.as_ref().ok_or_else(|| unknown("nothing connects these frames".to_owned()))?;
        let ros = now.ros.ok_or(Reason::NoClock)?;
        let (age, lead) = (ages.age(now), ages.lead(ros));
        let ttl = settings.transform_ttl;
        if age > ttl {
            return Err(unknown(format!("it is {age:.3} s old, and transform_ttl is {ttl} s")));
        }
        if lead > ttl {
            return Err(unknown(format!("it is stamped {lead:.3} s in the future")));
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

/// Poses of a path's end in its start, with the numbers of the transforms that gave them; `None` if some are not kept any more.
fn poses_since(path: &FramePath, tree: &TransformTree, number: u64) -> Option<Vec<(u64, Pose)>> {
    let (mut received, mut links) = (Vec::new(), BTreeMap::new());
    for (frame, _) in path.stamped_links() {
        let poses = tree.poses_since(frame, number)?;
        // a frame has its first known pose until it gets another one
        links.extend(poses.first().map(|first| (frame, first.pose_pf)));
        received.extend(poses.into_iter().filter(|pose| pose.number > number).map(|pose| (frame, pose)));
    }
    received.sort_by_key(|(_, pose)| pose.number);
    let poses = received.into_iter().map(|(frame, NumberedPose { number, pose_pf, .. })| {
        links.insert(frame, pose_pf);
        (number, path.pose_by(|link| links.get(link).copied()))
    });
    Some(poses.collect())
}

/// Names of the parent link and child link of a joint.
fn frames(robot: &RobotModel, joint: JointId) -> [&str; 2] {
    let joint = robot.joint(joint);
    [joint.parent, joint.child].map(|link| robot.link(link).name.as_str())
}
