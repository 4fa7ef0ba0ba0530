//! Bound on the displacement of obstacles, relative to the root, between two joint states.
//!
//! The world has each obstacle in one place. A motion of the joints is proven free beside it if it is free beside all places
//! where the obstacle may have been meanwhile.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use clearance_checker::CollisionChecker;
use clearance_geometry::math::Extremes;
use clearance_motion::{ObstacleLimits, ObstacleUncertainty, SpeedLimit};
use clearance_robot::LinkPoses;
use clearance_scene::BodyId;

use super::motion_since_previous::GapReason;
use super::obstacle_motion::ObstacleMotion;
use super::pose_history::LargestDisplacement;
use super::tracked_obstacle::{TrackedObstacle, TrackedObstacles, obstacle_extent};
use super::{MonitorSettings, Time};

/// Motion of obstacles and the root as it is known at one end of a motion.
#[derive(Clone, Copy)]
pub(super) struct KnownMotion<'m> {
    /// Motions of the obstacles' frames.
    pub frames: &'m [ObstacleMotion],
    /// Obstacles that move by themselves.
    pub tracked: &'m TrackedObstacles,
    /// Stamp of the state.
    pub stamp: Time,
    /// Time (s) for which the obstacles have not been moved to follow `tf`.
    pub lag: f64,
}

impl<'m> KnownMotion<'m> {
    /// Motion as seen from a state with this stamp; `lag` is the time for which the obstacles have not followed `tf`.
    pub fn new(
        frames: &'m [ObstacleMotion],
        tracked: &'m TrackedObstacles,
        stamp: Time,
        lag: Duration,
    ) -> Self {
        Self { frames, tracked, stamp, lag: lag.as_secs_f64() }
    }
}

/// The robot and its world during a motion.
pub(super) struct Surroundings<'s> {
    pub checker: &'s CollisionChecker,
    pub poses: &'s LinkPoses,
    pub settings: &'s MonitorSettings,
    /// Largest distance (m) of a point of the robot from the root.
    pub radius: f64,
    /// Longest time (s) between two measurements during the motion.
    pub duration: f64,
    /// Displacements of tracked obstacles since the motion began, by name.
    pub obstacle_displacements: &'s BTreeMap<String, LargestDisplacement>,
}

/// Upper bounds (m) on the displacement of obstacles from where the world has them.
#[derive(Debug)]
pub(super) struct ObstacleShift {
    /// Of all obstacles, with the root's frame.
    of_root: f64,
    /// Name of the frame in which the root moves.
    frame: String,
    /// Motion of their own, as the distance in one second.
    own: ObstacleLimits,
}

impl ObstacleShift {
    /// Displacements during a motion, from what is known at both of its ends. The faster one counts: an obstacle may have
    /// changed its velocity at any time.
    pub fn between(ends: [KnownMotion; 2], surroundings: &Surroundings) -> Self {
        let (mut of_root, mut frame) = (0.0, "");
        for (number, KnownMotion { frames, tracked, stamp, lag }) in ends.into_iter().enumerate() {
            // the root has moved since a state of an obstacle, too
            let age_of_tracked =
                tracked.all().iter().map(TrackedObstacle::longest_age).fold(0.0, f64::greater);
            for moved in frames.iter().filter(|moved| !moved.rests()) {
                let age = (moved.difference(stamp) + lag).greater(age_of_tracked);
                let radius = surroundings.radius;
                let mut most = moved.largest_step(radius, surroundings.duration + age);
                // at the start of the motion, it is about the motion before
                if number == 1 {
                    let until_measured =
                        if age > 0.0 { moved.largest_displacement(radius, age) } else { 0.0 };
                    most = most.greater(moved.displacement_since_state(radius) + until_measured);
                }
                if most > of_root {
                    (of_root, frame) = (most, &moved.frame);
                }
            }
        }
        Self { of_root, frame: frame.to_owned(), own: own_motion(ends.map(|end| end.tracked), surroundings) }
    }

    /// Upper bound (m) for all obstacles of a world.
    pub fn largest(&self, checker: &CollisionChecker) -> f64 {
        self.of_root + self.own.largest_displacement(checker.world(), 1.0)
    }

    /// The bound of each obstacle, for a motion of the joints; `None` if it is infinite for one of them.
    pub fn uncertainty(&self) -> Option<ObstacleUncertainty> {
        let limits = self.own.relative_to(SpeedLimit { speed: self.of_root, acceleration: 0.0 });
        ObstacleUncertainty::new(Arc::new(limits), [1.0, 1.0]).ok()
    }

    /// Why a pair of bodies may touch that does not touch where the world has them; `None` if nothing of it moves by itself.
    pub fn why(&self, checker: &CollisionChecker, (a, b): (BodyId, BodyId)) -> Option<GapReason> {
        let obstacle = [a, b].into_iter().find(|body| matches!(body, BodyId::Obstacle(_)))?;
        let name = checker.body_name(obstacle);
        if self.own.of(name).is_zero() {
            return (self.of_root > 0.0).then(|| GapReason::RootMoves { frame: self.frame.clone() });
        }
        Some(GapReason::ObstacleMoves { name: name.to_owned() })
    }

    /// Why the bound is infinite.
    pub fn why_unbounded(&self) -> GapReason {
        let own = self.own.by_name.iter().find(|(_, limit)| !limit.speed.is_finite());
        match own {
            Some((name, _)) => GapReason::ObstacleMoves { name: name.clone() },
            None => GapReason::RootMoves { frame: self.frame.clone() },
        }
    }
}

/// Motion of the obstacles on their own, as the distance in one second.
fn own_motion(ends: [&TrackedObstacles; 2], surroundings: &Surroundings) -> ObstacleLimits {
    let Surroundings { checker, poses, settings, duration, .. } = surroundings;
    let in_one_second = |displacement: f64| SpeedLimit { speed: displacement, acceleration: 0.0 };
    let limited =
        |limit: &SpeedLimit| in_one_second(limit.displacement(settings.obstacle_latency + duration));
    let limits = &settings.obstacle_limits;
    let mut own = ObstacleLimits {
        default: limited(&limits.default),
        by_name: limits.by_name.iter().map(|(name, limit)| (name.clone(), limited(limit))).collect(),
    };
    let mut tracked: BTreeMap<&str, f64> = BTreeMap::new();
    let [_, now] = ends;
    for obstacle in ends.into_iter().flat_map(TrackedObstacles::all) {
        let name = obstacle.name();
        let is_here = checker.world().id(name).is_some();
        // where the world has it: its last state, or a later message with its pose
        let age = now.of(name).map_or(0.0, TrackedObstacle::longest_age);
        let most = obstacle.most(checker, poses, settings, age + duration);
        let known = tracked.entry(name).or_default();
        *known = known.greater(if is_here { most } else { 0.0 });
    }
    let since_pose = |name: &str| match now.of(name) {
        Some(now) => now.most(checker, poses, settings, now.longest_age()),
        None => limited(&limits.of(name)).speed,
    };
    for (name, displacement) in surroundings.obstacle_displacements {
        let Some(id) = checker.world().id(name) else { continue };
        let until_pose = displacement.of_radius(obstacle_extent(checker, poses, id));
        let known = tracked.entry(name).or_default();
        *known = known.greater(until_pose + since_pose(name));
    }
    // one that stands still now, and moved before, moves within its limit again
    for (name, known) in &mut tracked {
        if now.of(name).is_none() {
            *known = known.greater(limited(&limits.of(name)).speed);
        }
    }
    own.by_name.extend(tracked.into_iter().map(|(name, most)| (name.to_owned(), in_one_second(most))));
    own
}
