//! Slow-down range: distance up to which pairs may slow the robot down, from its motion and that of obstacles.

use clearance_checker::CollisionChecker;
use clearance_geometry::math::Extremes;
use clearance_robot::{Configuration, LinkPoses};

use super::approach_rate::STEP;
use super::obstacle_motion::ObstacleMotion;
use super::settings::MonitorSettings;
use super::tracked_obstacle::TrackedObstacles;

/// Largest motion (m) of the robot that the range of `slowdown_range` adds to the slow-down distance.
const LONGEST_MOTION: f64 = 1.0;

/// State of the robot with its velocities.
pub(super) struct MovingState<'s> {
    pub configuration: &'s Configuration,
    pub poses: &'s LinkPoses,
    /// Velocity of each position, if known.
    pub rates: Option<&'s [f64]>,
    pub obstacle_motions: &'s [ObstacleMotion],
    /// Obstacles that move by themselves.
    pub tracked_obstacles: &'s TrackedObstacles,
    /// Longest time (s) between the stamp and the measurement of a joint.
    pub spread: f64,
}

/// Distance (m) up to which pairs may slow the robot down.
pub(super) fn slowdown_range(
    checker: &CollisionChecker,
    moving: &MovingState,
    settings: &MonitorSettings,
) -> f64 {
    let by_distances = range_of_distances(checker, moving, settings);
    let Some(separation) = &settings.speed.separation else { return by_distances };
    let (tracked, poses) = (moving.tracked_obstacles, moving.poses);
    let of_obstacles = tracked.largest_speed(checker, poses, settings);
    let of_separation = separation.range_of_measured(of_obstacles, largest_speed(checker, moving));
    by_distances.greater(of_separation + tracked.largest_displacement_since_pose(checker, poses, settings))
}

/// Upper bound (m/s) on the speed of any point of the robot, as far as velocities are known; 0 where there is no bound, as for a
/// joint that leaves its range.
fn largest_speed(checker: &CollisionChecker, moving: &MovingState) -> f64 {
    let positions = moving.configuration.positions();
    let of_joints = moving.rates.map_or(0.0, |rates| {
        let after_step: Vec<f64> = positions.iter().zip(rates).map(|(q, rate)| q + STEP * rate).collect();
        checker.travel(positions, &after_step) / STEP
    });
    let extent = checker.extent(moving.poses);
    let of_root = moving.obstacle_motions.iter().map(|motion| motion.largest_displacement(extent, 1.0));
    let speed = of_joints + of_root.fold(0.0, f64::greater);
    if speed.is_finite() { speed } else { 0.0 }
}

/// Distance (m) up to which pairs may slow the robot down by their distances: moving bodies may be nearer once the
/// reaction time is over.
fn range_of_distances(
    checker: &CollisionChecker,
    &MovingState { configuration, poses, rates, obstacle_motions, tracked_obstacles, spread }: &MovingState,
    settings: &MonitorSettings,
) -> f64 {
    let (reach, reaction_time) = (settings.speed.reach(), settings.speed.reaction_time);
    if reach == 0.0 {
        return reach;
    }
    let positions = configuration.positions();
    let later = |rates: &[f64]| -> Vec<f64> {
        positions.iter().zip(rates).map(|(q, rate)| q + reaction_time * rate).collect()
    };
    // an unknown velocity may be any
    let of_joints = rates.map_or(LONGEST_MOTION, |rates| checker.travel(positions, &later(rates)));
    let moving = obstacle_motions.iter().filter(|obstacle_motion| !obstacle_motion.is_none());
    let of_root = moving
        .map(|obstacle_motion| obstacle_motion.largest_displacement(checker.extent(poses), reaction_time));
    let of_robot = (of_joints + of_root.fold(0.0, f64::greater)).lesser(LONGEST_MOTION);
    let of_tracked = tracked_obstacles.largest_approach(checker, poses, settings);
    reach + of_robot + of_tracked.greater(settings.largest_obstacle_motion(checker.world(), spread))
}
