//! Obstacles whose velocity a tracker publishes with their pose.
//!
//! Such an obstacle moves on at its velocity. What it may do beyond this is limited by its acceleration, so that a point is
//! at most ½ a t² from where the velocity alone would bring it in a time t.

use clearance_checker::{CollisionChecker, PairDistance};
use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_motion::{MovingObstacle, ObstacleLimits, SpeedLimit};
use clearance_robot::LinkPoses;
use clearance_scene::{BodyId, ObstacleTwist};

use super::{MonitorSettings, Revision, Time};

/// Largest motion (m) by a rotation that the range of `slowdown_range` takes into account.
const LONGEST_TURN: f64 = 1.0;

/// Time (s) by which the stamp of an obstacle may be later than that of the joint state, if both have one clock.
const LARGEST_LEAD: f64 = 1.0;

/// A moving obstacle, as seen from one joint state.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TrackedObstacle {
    /// Its motion in one second, in the root frame.
    motion: MovingObstacle,
    /// Time (s) from its pose to the joint state; negative if the pose is newer.
    age: f64,
}

/// Moving obstacles, as seen from one joint state, in the order of their names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackedObstacles(Vec<TrackedObstacle>);

impl TrackedObstacles {
    /// The obstacles of a revision that move or, by their limits, may start to move, for a joint state with this stamp.
    pub(super) fn of_state(revision: &Revision, stamp: Time, settings: &MonitorSettings) -> Self {
        let world = revision.checker.world();
        let may_move = |twist: &&ObstacleTwist| {
            twist.moves() || settings.obstacle_limits.of(&twist.name).acceleration > 0.0
        };
        let tracked = |twist: &ObstacleTwist| {
            let pose_ro = world.obstacle_by_name(&twist.name)?.pose_ro;
            let [linear, angular] = [twist.linear_o, twist.angular_o].map(|v| (pose_ro.rotation * v).into());
            let centre = pose_ro.translation.vector.into();
            let motion = MovingObstacle { name: twist.name.clone(), centre, linear, angular, start: None };
            Some(TrackedObstacle { motion, age: stamp.seconds_since(twist.stamp) })
        };
        Self(revision.obstacle_twists.iter().filter(may_move).filter_map(tracked).collect())
    }

    /// Whether any of them has a velocity.
    pub(super) fn any_moves(&self) -> bool {
        self.0.iter().any(|obstacle| !obstacle.motion.stands())
    }

    /// Whether the obstacle with a name has a velocity.
    pub(super) fn moves(&self, name: &str) -> bool {
        self.of(name).is_some_and(|obstacle| !obstacle.motion.stands())
    }

    /// The obstacle with a name, if it is one of these.
    pub(super) fn of(&self, name: &str) -> Option<&TrackedObstacle> {
        let found = self.0.binary_search_by(|obstacle| obstacle.motion.name.as_str().cmp(name));
        found.ok().map(|index| &self.0[index])
    }

    /// An obstacle whose stamp is too late for the joint state: the clock was set back since.
    pub(super) fn of_a_later_clock(&self) -> Option<&str> {
        let found = self.0.iter().find(|obstacle| obstacle.age < -LARGEST_LEAD);
        found.map(|obstacle| obstacle.motion.name.as_str())
    }

    /// Their motions from the joint state on, for a time (s).
    pub(super) fn motions(&self, time: f64) -> Vec<MovingObstacle> {
        let moving = self.0.iter().filter(|obstacle| !obstacle.motion.stands());
        moving.map(|obstacle| obstacle.motion.part([obstacle.age, obstacle.age + time])).collect()
    }

    /// Limits of what obstacles do beyond their known motion: these have their velocity already.
    pub(super) fn limits_beyond_motion(&self, limits: &ObstacleLimits) -> ObstacleLimits {
        let mut beyond = limits.clone();
        for TrackedObstacle { motion: MovingObstacle { name, .. }, .. } in &self.0 {
            beyond.by_name.insert(name.clone(), SpeedLimit { speed: 0.0, ..limits.of(name) });
        }
        beyond
    }

    /// Longest time (s) between the joint state and the poses of those with such a limit.
    pub(super) fn longest_age(&self, of: impl Fn(SpeedLimit) -> bool, settings: &MonitorSettings) -> f64 {
        let limit = |obstacle: &TrackedObstacle| settings.obstacle_limits.of(&obstacle.motion.name);
        let ages = self.0.iter().filter(|obstacle| of(limit(obstacle))).map(|obstacle| obstacle.age.abs());
        ages.fold(0.0, f64::greater)
    }

    /// Upper bound (m) on [`TrackedObstacle::approach`] of all of them.
    pub(super) fn largest_approach(
        &self,
        checker: &CollisionChecker,
        poses: &LinkPoses,
        settings: &MonitorSettings,
    ) -> f64 {
        let approaches = self.0.iter().map(|obstacle| {
            let time = obstacle.age.abs() + settings.speed.reaction_time;
            let [moved, turned] = obstacle.largest_displacement(checker, poses, time);
            moved + turned.lesser(LONGEST_TURN) + obstacle.departure(time, settings)
        });
        if settings.speed.world.reach() > 0.0 { approaches.fold(0.0, f64::greater) } else { 0.0 }
    }

    /// The obstacle whose points move farthest in a time (s) before the joint state, and an upper bound (m) on their motion
    /// from its pose.
    pub(super) fn fastest(
        &self,
        checker: &CollisionChecker,
        poses: &LinkPoses,
        settings: &MonitorSettings,
        time: f64,
    ) -> Option<(&str, f64)> {
        let moving = self.0.iter().filter(|obstacle| !obstacle.motion.stands());
        let bounds = moving.map(|obstacle| {
            let time = obstacle.age.abs() + time;
            let [moved, turned] = obstacle.largest_displacement(checker, poses, time);
            (obstacle.motion.name.as_str(), moved + turned + obstacle.departure(time, settings))
        });
        bounds.max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

impl TrackedObstacle {
    /// Distance (m) by which it may be nearer to the other body of a pair when the speed scale has an effect: it moves at
    /// its velocity, and the age of its pose and its acceleration make it uncertain where it is.
    pub(super) fn approach(&self, pair: &PairDistance, settings: &MonitorSettings) -> f64 {
        let [a, b] = pair.witness_points;
        let (on_obstacle, on_other) = if matches!(pair.a, BodyId::Obstacle(_)) { (a, b) } else { (b, a) };
        let towards = (on_other - on_obstacle).try_normalize(0.0).unwrap_or_default();
        let (age, reaction_time) = (self.age.abs(), settings.speed.reaction_time);
        let since_state = self.displacement(&on_obstacle, reaction_time).dot(&towards).greater(0.0);
        let until_state = self.displacement(&on_obstacle, age).norm();
        since_state + until_state + self.departure(age + reaction_time, settings)
    }

    /// Upper bound (m) on the distance between a point and where the velocity alone brings it in a time (s).
    fn departure(&self, time: f64, settings: &MonitorSettings) -> f64 {
        let limit = settings.obstacle_limits.of(&self.motion.name);
        SpeedLimit { speed: 0.0, ..limit }.displacement(time)
    }

    /// Displacement of its point in a time (s).
    fn displacement(&self, point_r: &Point, time: f64) -> Vector {
        self.motion.displacement(time) * point_r - point_r
    }

    /// Upper bounds (m) on the displacement of its points in a time (s): by its translation, and by its rotation, which is
    /// infinite for a plane.
    fn largest_displacement(&self, checker: &CollisionChecker, poses: &LinkPoses, time: f64) -> [f64; 2] {
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
        [speed, if turning > 0.0 { turning * extent } else { 0.0 }]
    }
}
