//! Options and results of the search for the least distance along a motion.

use std::time::Instant;

use clearance_geometry::math::Extremes;
use clearance_proximity::Work;

use super::motion_report::{UndecidedReason, is_over};
use super::watch::Watch;
use crate::collision_report::PairDistance;
use crate::pair_kind::PairKind;

/// Smallest tolerance (m): about the rounding of distances and of bounds on motions, with a factor for safety.
const LEAST_TOLERANCE: f64 = 1e-7;

/// Distances below this (m) are not refined further, where it is not known whether the bodies touch.
const CONTACT_RESOLUTION: f64 = 1e-5;

/// Share of a small distance that its tolerance must not exceed: the lower bound of a free motion is then more than zero.
const SHARE_OF_SMALL_DISTANCE: f64 = 0.5;

/// Options of a search for the least distance along a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionClearanceOptions {
    /// The search ends when upper and lower bound differ by at most this (m).
    pub absolute_tolerance: f64,
    /// As `absolute_tolerance`, relative to the upper bound; the larger of the two applies.
    pub relative_tolerance: f64,
    /// Distances larger than this (m) do not matter: the search ends when the lower bound has reached it.
    pub limit: f64,
    /// Time at which the search stops. What it has not searched may be at any distance: `lower` is then 0.
    pub deadline: Option<Instant>,
    /// Number of pair evaluations after which the search stops; each takes some microseconds. It also stops when a million
    /// intervals wait for their evaluation.
    pub budget: u64,
    /// Handle by which another thread stops the search.
    pub watch: Option<Watch>,
}

impl Default for MotionClearanceOptions {
    fn default() -> Self {
        Self {
            absolute_tolerance: 1e-3,
            relative_tolerance: 0.01,
            limit: f64::INFINITY,
            deadline: None,
            budget: 10_000_000,
            watch: None,
        }
    }
}

impl MotionClearanceOptions {
    /// Allowed difference (m) of the bounds, for this upper bound. Small distances get a smaller tolerance, so that
    /// contact is found or excluded down to [`CONTACT_RESOLUTION`]. While no distance is known, nothing is relative to it.
    pub(super) fn tolerance(&self, upper: f64) -> f64 {
        let relative = if upper.is_finite() { self.relative_tolerance * upper } else { 0.0 };
        let given = self.absolute_tolerance.greater(relative).greater(LEAST_TOLERANCE);
        given.lesser((SHARE_OF_SMALL_DISTANCE * upper).greater(CONTACT_RESOLUTION))
    }

    /// The reason to stop now, if the watching thread has stopped the search or the deadline has passed.
    pub(super) fn stopped_by(&self) -> Option<UndecidedReason> {
        is_over(self.watch.as_ref(), self.deadline)
    }
}

/// Bounds on the least distance (m, padding subtracted) of self pairs or of world pairs along a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastClearance {
    /// Proven: no pair is nearer than this (m) at any time; 0 if some pair touches, or if nothing is proven.
    pub lower: f64,
    /// Distance (m) of a pair at one time, `nearest`: the least distance is not larger. Infinite if nothing was measured, or
    /// nothing is within the limit.
    pub upper: f64,
    /// Where `upper` is attained.
    pub nearest: Option<NearestMoment>,
}

/// A pair at one time of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestMoment {
    /// Index of the trajectory's segment; 0 for a single motion.
    pub segment: usize,
    /// Fraction of the segment, from 0 to 1.
    pub t: f64,
    /// Time (s) from the start of the trajectory, if it has times.
    pub time: Option<f64>,
    /// The pair at this time, with its exact distance and witness points.
    pub pair: PairDistance,
}

/// The least distances along a motion or trajectory.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionClearance {
    /// The least distance of two bodies of the robot; `None` if no such pairs are checked.
    pub nearest_self: Option<LeastClearance>,
    /// The least distance of a body of the robot and an obstacle; `None` if no such pairs are checked.
    pub nearest_world: Option<LeastClearance>,
    /// Why the bounds differ by more than the tolerance; `None` if they do not.
    pub unfinished: Option<UndecidedReason>,
    /// Number of evaluations of a pair in one interval.
    pub evaluations: u64,
    /// Volume tests and primitive tests that the search took.
    pub work: Work,
}

impl MotionClearance {
    /// The least distance of the pairs of one kind: `nearest_self` or `nearest_world`.
    #[must_use]
    pub fn nearest_of(&self, kind: PairKind) -> Option<&LeastClearance> {
        match kind {
            PairKind::SelfPair => self.nearest_self.as_ref(),
            PairKind::WorldPair => self.nearest_world.as_ref(),
        }
    }

    /// Proven: no pair is nearer than this (m) at any time; infinite if no pairs are checked, zero for a motion of another robot or world.
    #[must_use]
    pub fn lower(&self) -> f64 {
        if self.unfinished == Some(UndecidedReason::Mismatch) {
            return 0.0;
        }
        self.of_both().map(|least| least.lower).fold(f64::INFINITY, f64::lesser)
    }

    /// Upper bound (m) on the least distance of all pairs; infinite if nothing was measured.
    #[must_use]
    pub fn upper(&self) -> f64 {
        self.of_both().map(|least| least.upper).fold(f64::INFINITY, f64::lesser)
    }

    /// True only if the motion is proven free.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.lower() > 0.0
    }

    fn of_both(&self) -> impl Iterator<Item = &LeastClearance> {
        self.nearest_self.iter().chain(&self.nearest_world)
    }
}
