//! Joints of several positions whose places `tf` tells: a base that drives, flies or swims.

use std::time::Duration;

use clearance_geometry::math::{Extremes, Pose};
use clearance_robot::{JointId, RobotModel};
use clearance_scene::TransformTree;

use super::{MonitorSettings, Now, Reason, Time};

/// How far (m, rad) a transform may leave the plane of a planar joint: that much of the base's place is not checked.
const PLANE_SLACK: f64 = 1e-3;

/// Where `tf` has the child link of a joint.
#[derive(Clone, Debug, PartialEq)]
struct Placement {
    joint: JointId,
    /// Pose of the child link in the parent link, and since when; `None` while nothing connects the two.
    found: Option<(Pose, Option<Time>)>,
    /// When that was first judged by, on the steady clock: a clock that stands lets nothing grow old.
    since: Option<Duration>,
}

/// All joints that `tf` places.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Placements {
    placements: Vec<Placement>,
    /// What of the wish for them cannot be fulfilled.
    pub warnings: Vec<String>,
}

/// Numbers of a configuration, where they begin.
pub(super) type Placed = (usize, Vec<f64>);

impl Placements {
    /// What `tf` tells now about the joints that the settings name.
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
            let found = tree.way(parent, child).map(|way| (way.pose(), way.oldest()));
            all.placements.push(Placement { joint, found, since: None });
        }
        all
    }

    /// What is known of earlier ones, where nothing newer was told since.
    pub fn inherit(&mut self, before: &Self) {
        for placement in &mut self.placements {
            let same =
                before.placements.iter().find(|b| b.joint == placement.joint && b.found == placement.found);
            placement.since = same.and_then(|same| same.since);
        }
    }

    /// From now on, at the latest, they grow old.
    pub fn note_seen(&mut self, now: Now) {
        for placement in &mut self.placements {
            placement.since.get_or_insert(now.steady);
        }
    }

    /// The stamp of the newest transform, if any has one.
    pub fn newest_stamp(&self) -> Option<Time> {
        self.placements.iter().filter_map(|p| p.found?.1).max()
    }

    /// Whether they place every number of a configuration.
    pub fn place_all(&self, robot: &RobotModel) -> bool {
        let placed: usize =
            self.placements.iter().map(|p| robot.joint(p.joint).kind.position_suffixes().len()).sum();
        placed > 0 && placed == robot.position_names().len()
    }

    /// The stamp of the oldest transform, if any has one.
    pub fn stamp(&self) -> Option<Time> {
        self.placements.iter().filter_map(|p| p.found?.1).min()
    }

    /// Where the joints are, NaN where that is not known, and why it is not known of the first of these.
    pub fn read(
        &self,
        robot: &RobotModel,
        now: Now,
        settings: &MonitorSettings,
    ) -> (Vec<Placed>, Option<Reason>) {
        let mut unplaced = None;
        let read = |placement: &Placement| match placement.read(robot, now, settings) {
            Ok(placed) => Some(placed),
            Err(why) => {
                unplaced.get_or_insert(why);
                let count = robot.joint(placement.joint).kind.position_suffixes().len();
                Some((robot.first_position(placement.joint)?, vec![f64::NAN; count]))
            }
        };
        let placed = self.placements.iter().filter_map(read).collect();
        (placed, unplaced)
    }

    /// How long (s) the oldest transform still counts; infinite where none grows old.
    pub fn time_to_stale(&self, now: Now, settings: &MonitorSettings) -> f64 {
        let age =
            now.ros.zip(self.stamp()).map_or(f64::NEG_INFINITY, |(ros, stamp)| ros.seconds_since(stamp));
        let silence =
            self.placements.iter().filter_map(|p| p.silence(now)).fold(f64::NEG_INFINITY, f64::greater);
        settings.transform_ttl - age.greater(silence)
    }
}

impl Placement {
    /// How long (s) nothing newer was told of what can grow old.
    fn silence(&self, now: Now) -> Option<f64> {
        self.found?.1?;
        Some(now.steady.saturating_sub(self.since?).as_secs_f64())
    }

    fn read(&self, robot: &RobotModel, now: Now, settings: &MonitorSettings) -> Result<Placed, Reason> {
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
        let age = by_stamp.greater(self.silence(now).unwrap_or(f64::NEG_INFINITY));
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
        Ok((first, positions))
    }
}

/// Names of the links before and behind a joint.
fn frames(robot: &RobotModel, joint: JointId) -> [&str; 2] {
    let joint = robot.joint(joint);
    [joint.parent, joint.child].map(|link| robot.link(link).name.as_str())
}
