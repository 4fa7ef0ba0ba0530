//! Time before which nothing can touch, whatever motion follows within the acceleration limits.
//!
//! From a state with joint velocities, a robot with limited joint accelerations a is, after a time τ, within ½ a τ² of where its
//! velocities alone would bring it. This is a tube around a straight motion that widens with time (Hubbard 1995, *Collision detection for
//! interactive graphics applications*, calls such bounds space-time bounds).

use clearance_motion::{MotionSegment, SegmentError, floating};
use clearance_robot::Configuration;

use super::report::{MotionOptions, MotionVerdict};
use crate::collision_checker::CollisionChecker;
use crate::workspace::Workspace;
use clearance_scene::BodyId;

/// Resolution of the result: motion (m) below which intervals are not refined.
const RESOLUTION: f64 = 2e-3;

/// Maximum number of evaluations, plus a number per pair: extreme velocities must not take seconds.
const LOOKS: u64 = 1000;
const LOOKS_A_PAIR: u64 = 20;

/// Result of a look-ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAhead {
    /// No pair touches before this time (s).
    pub free_for: f64,
    /// The pair that may touch then; `None` if none can before the horizon, or if the evaluation limit was reached.
    pub first: Option<(BodyId, BodyId)>,
}

impl CollisionChecker {
    /// Time (s) before which no pair can touch, up to `horizon` (s). The robot now moves with `velocities` (rad/s, m/s, one per
    /// position), and no position accelerates by more than `accelerations` (rad/s², m/s²). Floating joints must be at rest.
    pub fn look_ahead(
        &self,
        q: &Configuration,
        velocities: &[f64],
        accelerations: &[f64],
        horizon: f64,
        workspace: &mut Workspace,
    ) -> Result<LookAhead, SegmentError> {
        let expected = q.positions().len();
        for given in [velocities.len(), accelerations.len()] {
            if given != expected {
                return Err(SegmentError::WrongLength { given, expected });
            }
        }
        if !horizon.is_finite() || horizon < 0.0 {
            return Err(SegmentError::Horizon(horizon));
        }
        for (joint, first) in floating(self.robot()) {
            if accelerations[first..first + 7].iter().any(|a| *a != 0.0) {
                return Err(SegmentError::FloatingTube(joint.to_owned()));
            }
        }
        let way = |(q, v): (&f64, &f64)| [*q, v * horizon, 0.0, 0.0, 0.0, 0.0];
        let lines = q.positions().iter().zip(velocities).map(way).collect();
        let segment = MotionSegment::polynomial(self.robot(), lines)?;
        let spread: Vec<f64> = accelerations.iter().map(|a| a.abs() * horizon * horizon).collect();
        if let Some(bad) = spread.iter().position(|a| !a.is_finite()) {
            return Err(SegmentError::NotFinite(self.robot().position_names()[bad].clone()));
        }
        let budget = LOOKS + LOOKS_A_PAIR * self.pairs().len() as u64;
        let options = MotionOptions { tolerance: RESOLUTION, budget, ..MotionOptions::default() };
        let (report, _) = self.prove(&segment.with_spread(spread), &options, workspace, false);
        Ok(match report.verdict {
            MotionVerdict::Free => LookAhead { free_for: horizon, first: None },
            MotionVerdict::Contact { t, pair, .. } => {
                LookAhead { free_for: t[0] * horizon, first: Some(pair) }
            }
            MotionVerdict::Undecided { t, pair, .. } => LookAhead { free_for: t[0] * horizon, first: pair },
        })
    }
}
