//! Obstacles whose velocity a tracker publishes with their pose.
//!
//! Such an obstacle moves on at its velocity. What it may do beyond this is limited by its acceleration, so that a point is
//! at most ½ a t² from where the velocity alone would bring it in a time t.

use clearance_checker::{CollisionChecker, PairDistance};
use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_motion::{MovingObstacle, ObstacleLimits, SpeedLimit};
use clearance_robot::LinkPoses;
use clearance_scene::{BodyId, ObstacleId, ObstacleTwist};

use super::obstacle_motion::ObstacleMotion;
use super::{CheckedState, MonitorSettings, Revision, Time};

/// Motion (m) by a rotation of an obstacle without end that the range of `slowdown_range` takes into account.
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
    /// Longest time (s) between its pose and the measurement of a joint.
    longest_age: f64,
}

/// Moving obstacles, as seen from one joint state, in the order of their names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackedObstacles(Vec<TrackedObstacle>);

impl TrackedObstacles {
    /// The obstacles of a revision that move or, by their limits, may start to move, for a joint state with this stamp, whose
    /// joints were measured up to `spread` (s) before or after it.
    pub(super) fn of_state(
        revision: &Revision,
        stamp: Time,
        spread: f64,
        settings: &MonitorSettings,
    ) -> Self {
        let world = revision.checker.world();
        let may_move = |twist: &&ObstacleTwist| {
            twist.moves() || settings.obstacle_limits.of(&twist.name).acceleration > 0.0
        };
        let tracked = |twist: &ObstacleTwist| {
            let pose_ro = world.obstacle_by_name(&twist.name)?.pose_ro;
            let [linear, angular] = [twist.linear_o, twist.angular_o].map(|v| (pose_ro.rotation * v).into());
            let centre = pose_ro.translation.vector.into();
            let motion = MovingObstacle { name: twist.name.clone(), centre, linear, angular, start: None };
            let age = stamp.seconds_since(twist.stamp);
            Some(TrackedObstacle { motion, age, longest_age: age.abs() + spread })
        };
        Self(revision.obstacle_twists.iter().filter(may_move).filter_map(tracked).collect())
    }

    /// Whether any of them has a velocity.
    pub(super) fn any_moves(&self) -> bool {
        self.0.iter().any(|obstacle| !obstacle.motion.stands())
    }

    /// All of them.
    pub(super) fn all(&self) -> &[TrackedObstacle] {
        &self.0
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

    /// Their motions in one second from their poses on, by the time (s) from the pose to the joint state, if it is positive.
    pub(super) fn by_age(&self) -> Vec<(f64, Vec<MovingObstacle>)> {
        let mut groups: Vec<(f64, Vec<MovingObstacle>)> = Vec::new();
        for TrackedObstacle { motion, age, .. } in self.0.iter().filter(|obstacle| obstacle.age > 0.0) {
            match groups.iter_mut().find(|(of_group, _)| of_group == age) {
                Some((_, group)) => group.push(motion.clone()),
                None => groups.push((*age, vec![motion.clone()])),
            }
        }
        groups
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
            let time = obstacle.longest_age + settings.speed.reaction_time;
            let [moved, turned] = obstacle.largest_displacement(checker, poses, time);
            // what has no end, such as a plane, counts as turning by little
            let turned = if turned.is_finite() { turned } else { LONGEST_TURN };
            moved + turned + obstacle.departure(time, settings)
        });
        if settings.speed.world.reach() > 0.0 { approaches.fold(0.0, f64::greater) } else { 0.0 }
    }

    /// Upper bound (m/s) on [`TrackedObstacle::speed`] of all of them.
    pub(super) fn largest_speed(
        &self,
        checker: &CollisionChecker,
        poses: &LinkPoses,
        settings: &MonitorSettings,
    ) -> f64 {
        let speeds = self.0.iter().map(|obstacle| obstacle.speed(checker, poses, settings));
        speeds.fold(0.0, f64::greater)
    }

    /// Upper bound (m) on [`TrackedObstacle::displacement_since_pose`] of all of them, without the motion of the root.
    pub(super) fn largest_displacement_since_pose(
        &self,
        checker: &CollisionChecker,
        poses: &LinkPoses,
        settings: &MonitorSettings,
    ) -> f64 {
        let moved =
            self.0.iter().map(|obstacle| obstacle.most(checker, poses, settings, obstacle.longest_age));
        moved.fold(0.0, f64::greater)
    }
}

impl TrackedObstacle {
    /// Its name.
    pub(super) fn name(&self) -> &str {
        &self.motion.name
    }

    /// Longest time (s) between its pose and the measurement of a joint.
    pub(super) fn longest_age(&self) -> f64 {
        self.longest_age
    }

    /// Upper bound (m) on what it may be nearer to the other body of a pair when the speed scale has an effect: it moves at
    /// its velocity, and the age of its pose and its acceleration make it uncertain where it is. The root has moved since
    /// its pose, too.
    ///
    /// It lies beyond a plane across the line between the nearest points, and so it does after a translation along that plane.
    /// Capsules around both bodies bound how far from it.
    pub(super) fn approach(
        &self,
        pair: &PairDistance,
        checker: &CollisionChecker,
        checked_state: &CheckedState,
        settings: &MonitorSettings,
    ) -> f64 {
        let CheckedState { poses, obstacle_motions, .. } = checked_state;
        let (age, reaction_time) = (self.longest_age, settings.speed.reaction_time);
        let [moved, turned] = self.largest_displacement(checker, poses, reaction_time);
        let point = point_on_obstacle(pair);
        let between = point - point_on_other(pair);
        let from_other = between.try_normalize(0.0).unwrap_or_default();
        let along = (-from_other.dot(&Vector::from(self.motion.linear)) * reaction_time).greater(0.0);
        // without paddings, as the capsules
        let not_convex = between.norm() - gap_along(&from_other, pair, checker, poses);
        let since_state = moved.lesser(not_convex.greater(0.0) + along) + turned;
        let until_state: f64 = self.largest_displacement(checker, poses, age).iter().sum();
        let of_root = self.motion_of_root(pair, obstacle_motions);
        since_state + until_state + of_root + self.departure(age + reaction_time, settings)
    }

    /// Upper bound (m) on the displacement of its points, from where the world has it, until the joint state; the root has
    /// moved meanwhile, too.
    pub(super) fn displacement_since_pose(
        &self,
        pair: &PairDistance,
        checker: &CollisionChecker,
        checked_state: &CheckedState,
        settings: &MonitorSettings,
    ) -> f64 {
        let CheckedState { poses, obstacle_motions, .. } = checked_state;
        self.most(checker, poses, settings, self.longest_age) + self.motion_of_root(pair, obstacle_motions)
    }

    /// Motion (m) of the root since its pose, at its nearest point of a pair.
    fn motion_of_root(&self, pair: &PairDistance, obstacle_motions: &[ObstacleMotion]) -> f64 {
        let point = point_on_obstacle(pair);
        let of_root =
            obstacle_motions.iter().map(|moved| moved.displacement(&point, self.longest_age).norm());
        of_root.fold(0.0, f64::greater)
    }

    /// Upper bound (m/s) on the speed of its points at the joint state.
    pub(super) fn speed(
        &self,
        checker: &CollisionChecker,
        poses: &LinkPoses,
        settings: &MonitorSettings,
    ) -> f64 {
        let MovingObstacle { name, linear, angular, .. } = &self.motion;
        let [linear, angular] = [linear, angular].map(|v| Vector::from(*v).norm());
        let of_turning = if angular > 0.0 { angular * self.extent(checker, poses) } else { 0.0 };
        let acceleration = settings.obstacle_limits.of(name).acceleration;
        linear + of_turning + acceleration * self.longest_age
    }

    /// Upper bound (m) on the displacement of its points in a time (s) from its pose.
    pub(super) fn most(
        &self,
        checker: &CollisionChecker,
        poses: &LinkPoses,
        settings: &MonitorSettings,
        time: f64,
    ) -> f64 {
        let [moved, turned] = self.largest_displacement(checker, poses, time);
        moved + turned + self.departure(time, settings)
    }

    /// Upper bound (m) on the distance between a point and where the velocity alone brings it in a time (s).
    fn departure(&self, time: f64, settings: &MonitorSettings) -> f64 {
        let limit = settings.obstacle_limits.of(&self.motion.name);
        SpeedLimit { speed: 0.0, ..limit }.displacement(time)
    }

    /// Upper bounds (m) on the displacement of its points in a time (s), from where the world has it: by its translation, and by its
    /// rotation, which is infinite for a plane.
    fn largest_displacement(&self, checker: &CollisionChecker, poses: &LinkPoses, time: f64) -> [f64; 2] {
        let MovingObstacle { linear, angular, .. } = &self.motion;
        let [speed, turning] = [linear, angular].map(|v| Vector::from(*v).norm() * time);
        [speed, if turning > 0.0 { turning.lesser(2.0) * self.extent(checker, poses) } else { 0.0 }]
    }

    /// Largest distance (m) of its points from its origin; infinite for a plane.
    fn extent(&self, checker: &CollisionChecker, poses: &LinkPoses) -> f64 {
        checker.world().id(&self.motion.name).map_or(0.0, |id| obstacle_extent(checker, poses, id))
    }
}

/// Largest distance (m) of an obstacle's points from its origin; infinite for a plane.
pub(super) fn obstacle_extent(checker: &CollisionChecker, poses: &LinkPoses, id: ObstacleId) -> f64 {
    let centre = checker.world().obstacle(id).pose_ro.translation.vector;
    let extents = checker.bounding_capsules(BodyId::Obstacle(id), poses).into_iter().map(|capsule| {
        let [a, b] = capsule.ends.map(|end| (end - centre).norm());
        a.greater(b) + capsule.radius
    });
    extents.fold(0.0, f64::greater)
}

/// Whether the first body of a pair is the obstacle.
fn is_first(pair: &PairDistance) -> bool {
    matches!(pair.a, BodyId::Obstacle(_))
}

/// The nearest point of a pair on its obstacle (m, root frame).
fn point_on_obstacle(pair: &PairDistance) -> Point {
    let [a, b] = pair.witness_points;
    if is_first(pair) { a } else { b }
}

/// The nearest point of a pair on its other body (m, root frame).
fn point_on_other(pair: &PairDistance) -> Point {
    let [a, b] = pair.witness_points;
    if is_first(pair) { b } else { a }
}

/// Lower bound (m) on the gap between the bodies of a pair along a direction, towards its obstacle.
fn gap_along(direction: &Vector, pair: &PairDistance, checker: &CollisionChecker, poses: &LinkPoses) -> f64 {
    let least = |body: BodyId, direction: Vector| {
        let capsules = checker.bounding_capsules(body, poses).into_iter();
        let least = capsules.map(|capsule| {
            let [a, b] = capsule.ends.map(|end| end.dot(&direction));
            a.lesser(b) - capsule.radius
        });
        least.fold(f64::INFINITY, f64::lesser)
    };
    let [obstacle, other] = if is_first(pair) { [pair.a, pair.b] } else { [pair.b, pair.a] };
    least(obstacle, *direction) + least(other, -direction)
}
