//! Obstacles whose velocity a tracker publishes with their pose.
//!
//! Such an obstacle moves on at its velocity. What it may do beyond this is limited by its acceleration, so that a point is
//! at most ½ a t² from where the velocity alone would bring it in a time t.

use clearance_checker::CollisionChecker;
use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_motion::{MovingObstacle, ObstacleLimits, SpeedLimit};
use clearance_robot::LinkPoses;
use clearance_scene::{BodyId, ObstacleTwist};

use super::{Revision, Time};

/// Largest motion (m) by a rotation that the range of `slowdown_range` takes into account.
const LONGEST_TURN: f64 = 1.0;

/// A moving obstacle, as seen from one joint state.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedObstacle {
    /// Its motion in one second, in the root frame.
    motion: MovingObstacle,
    /// Time (s) from its pose to the joint state; negative if the pose is newer.
    age: f64,
}

impl TrackedObstacle {
    /// The moving obstacles of a revision, for a joint state with this stamp.
    pub(super) fn all(revision: &Revision, stamp: Time) -> Vec<Self> {
        let world = revision.checker.world();
        let tracked = |twist: &ObstacleTwist| {
            let pose_ro = world.obstacle_by_name(&twist.name)?.pose_ro;
            let [linear, angular] = [twist.linear_o, twist.angular_o].map(|v| (pose_ro.rotation * v).into());
            let centre = pose_ro.translation.vector.into();
            let motion = MovingObstacle { name: twist.name.clone(), centre, linear, angular, start: None };
            Some(Self { motion, age: stamp.seconds_since(twist.stamp) })
        };
        revision.obstacle_twists.iter().filter_map(tracked).collect()
    }

    /// Its motion from the joint state on, for a time (s).
    pub(super) fn after_state(&self, time: f64) -> MovingObstacle {
        self.motion.part([self.age, self.age + time])
    }

    /// Displacement of its point in a time (s).
    fn displacement(&self, point_r: &Point, time: f64) -> Vector {
        self.motion.displacement(time) * point_r - point_r
    }

    /// Upper bound (m) on the displacement of its points in a time (s).
    fn largest_displacement(&self, checker: &CollisionChecker, poses: &LinkPoses, time: f64) -> f64 {
        let MovingObstacle { name, centre, linear, angular, .. } = &self.motion;
        let centre = Vector::from(*centre);
        let capsules =
            checker.world().id(name).map(|id| checker.bounding_capsules(BodyId::Obstacle(id), poses));
        let extents = capsules.into_iter().flatten().map(|capsule| {
            let [a, b] = capsule.ends.map(|end| (end - centre).norm());
            a.greater(b) + capsule.radius
        });
        let extent = extents.fold(0.0, f64::greater);
        let [speed, turning] = [linear, angular].map(|v| Vector::from(*v).norm() * time);
        let turned = if turning > 0.0 { (turning * extent).lesser(LONGEST_TURN) } else { 0.0 };
        speed + turned
    }
}

/// Displacement in a time (s) of a point of an obstacle by its own velocity.
pub(super) fn own_displacement(
    tracked: &[TrackedObstacle],
    name: &str,
    point_r: &Point,
    time: f64,
) -> Vector {
    let of = tracked.iter().find(|obstacle| obstacle.motion.name == name);
    of.map_or_else(Vector::zeros, |obstacle| obstacle.displacement(point_r, time))
}

/// Upper bound (m) on the displacement of any point of a moving obstacle in a time (s).
pub(super) fn largest_displacement(
    tracked: &[TrackedObstacle],
    checker: &CollisionChecker,
    poses: &LinkPoses,
    time: f64,
) -> f64 {
    let displacements = tracked.iter().map(|obstacle| obstacle.largest_displacement(checker, poses, time));
    displacements.fold(0.0, f64::greater)
}

/// Limit of what an obstacle does beyond its known motion: one that moves has its velocity already.
pub(super) fn limit_beyond_motion(
    limits: &ObstacleLimits,
    tracked: &[TrackedObstacle],
    name: &str,
) -> SpeedLimit {
    let limit = limits.of(name);
    let is_tracked = tracked.iter().any(|obstacle| obstacle.motion.name == name);
    if is_tracked { SpeedLimit { speed: 0.0, ..limit } } else { limit }
}

/// The same for all obstacles.
pub(super) fn limits_beyond_motion(limits: &ObstacleLimits, tracked: &[TrackedObstacle]) -> ObstacleLimits {
    let mut beyond = limits.clone();
    for TrackedObstacle { motion: MovingObstacle { name, .. }, .. } in tracked {
        beyond.by_name.insert(name.clone(), limit_beyond_motion(limits, tracked, name));
    }
    beyond
}

/// Longest time (s) between the joint state and the pose of a moving obstacle that may accelerate.
pub(super) fn longest_age(limits: &ObstacleLimits, tracked: &[TrackedObstacle]) -> f64 {
    let accelerating = tracked.iter().filter(|obstacle| limits.of(&obstacle.motion.name).acceleration > 0.0);
    accelerating.map(|obstacle| obstacle.age.abs()).fold(0.0, f64::greater)
}
