//! Time before which nothing can touch, whatever motion follows within the limits of joints and obstacles.
//!
//! From a state with joint velocities, a robot with limited joint accelerations a is, after a time τ, within ½ a τ² of
//! where its velocities alone would bring it. This is a tube around a straight motion that widens with time (Hubbard
//! 1995, *Collision detection for interactive graphics applications*, calls such bounds space-time bounds).

use std::sync::Arc;

use clearance_motion::{
    MotionSegment, MovingObstacle, ObstacleLimits, ObstacleUncertainty, SegmentError, floating,
};
use clearance_robot::{Configuration, RobotModel};
use clearance_scene::BodyId;

use super::motion_check::MotionCheck;
use super::motion_report::{MotionOptions, MotionVerdict};
use super::motion_scratch::MotionWorkspace;
use crate::pairs::CheckedPairs;

/// Resolution of the result: motion (m) below which intervals are not refined.
const RESOLUTION: f64 = 2e-3;

/// Maximum number of evaluations, plus a number per pair: extreme velocities must not take seconds.
const EVALUATIONS: u64 = 1000;
const EVALUATIONS_PER_PAIR: u64 = 20;

/// Result of a look-ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAhead {
    /// No pair touches before this time (s).
    pub free_for: f64,
    /// The pair that may touch then; `None` if none can before the horizon, or if the evaluation limit was reached.
    pub first: Option<(BodyId, BodyId)>,
}

/// Joint state that a look-ahead starts from; all slices have one value per position.
#[derive(Clone, Copy, Debug)]
pub struct LookAheadState<'s> {
    /// Present configuration.
    pub q: &'s Configuration,
    /// Present velocities (rad/s, m/s).
    pub velocities: &'s [f64],
    /// Maximum accelerations (rad/s², m/s²).
    pub accelerations: &'s [f64],
    /// Known motions of obstacles from this state to the horizon.
    pub moving_obstacles: &'s [MovingObstacle],
    /// How fast obstacles may move, beyond their known motions; `None` if they do not.
    pub obstacle_limits: Option<&'s Arc<ObstacleLimits>>,
    /// Time (s) that has passed since the obstacles had their poses.
    pub obstacle_latency: f64,
    /// Whether only the pairs of obstacles with known motions count.
    pub only_moving_obstacles: bool,
}

/// Time (s) before which no pair can touch, up to `horizon` (s). Floating joints must be at rest.
pub fn look_ahead(
    pairs: &CheckedPairs,
    state: LookAheadState,
    horizon: f64,
    workspace: MotionWorkspace,
) -> Result<LookAhead, SegmentError> {
    let segment = widening_segment(pairs.robot().model(), state, horizon)?;
    let segment = with_moving_obstacles(segment, state, horizon)?;
    let budget = EVALUATIONS + EVALUATIONS_PER_PAIR * pairs.count() as u64;
    let options = MotionOptions { tolerance: RESOLUTION, budget, ..MotionOptions::default() };
    let mut check = MotionCheck::new(pairs, &options, workspace);
    let verdict = if state.only_moving_obstacles {
        check.prove_for_movers(&segment)
    } else {
        check.prove(&segment, false).0.verdict
    };
    Ok(match verdict {
        MotionVerdict::Free => LookAhead { free_for: horizon, first: None },
        MotionVerdict::Contact { t, pair, .. } => LookAhead { free_for: t[0] * horizon, first: Some(pair) },
        MotionVerdict::Undecided { t, pair, .. } => LookAhead { free_for: t[0] * horizon, first: pair },
    })
}

/// The motion at constant velocity, with a tube that holds all motions within the acceleration limits.
fn widening_segment(
    robot: &RobotModel,
    LookAheadState { q, velocities, accelerations, .. }: LookAheadState,
    horizon: f64,
) -> Result<MotionSegment, SegmentError> {
    let expected = q.positions().len();
    for given in [velocities.len(), accelerations.len()] {
        if given != expected {
            return Err(SegmentError::WrongLength { given, expected });
        }
    }
    if !horizon.is_finite() || horizon < 0.0 {
        return Err(SegmentError::Horizon(horizon));
    }
    for (joint, first) in floating(robot) {
        if accelerations[first..first + 7].iter().any(|a| *a != 0.0) {
            return Err(SegmentError::FloatingTube(joint.to_owned()));
        }
    }
    let way = |(q, v): (&f64, &f64)| [*q, v * horizon, 0.0, 0.0, 0.0, 0.0];
    let lines = q.positions().iter().zip(velocities).map(way).collect();
    let segment = MotionSegment::polynomial(robot, lines)?;
    let spread: Vec<f64> = accelerations.iter().map(|a| a.abs() * horizon * horizon).collect();
    if let Some(bad) = spread.iter().position(|a| !a.is_finite()) {
        return Err(SegmentError::NotFinite(robot.position_names()[bad].clone()));
    }
    Ok(segment.with_spread(spread))
}

/// The same, with obstacles that move as known and within their limits.
fn with_moving_obstacles(
    segment: MotionSegment,
    LookAheadState { moving_obstacles, obstacle_limits, obstacle_latency, .. }: LookAheadState,
    horizon: f64,
) -> Result<MotionSegment, SegmentError> {
    let segment = segment.with_movers(moving_obstacles.to_vec())?;
    let Some(limits) = obstacle_limits else { return Ok(segment) };
    let time = [obstacle_latency, obstacle_latency + horizon];
    Ok(segment.with_uncertainty(ObstacleUncertainty::new(Arc::clone(limits), time)?))
}

#[cfg(test)]
mod tests;
