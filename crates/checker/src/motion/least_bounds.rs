//! Bounds on the least distance of one kind of pairs along a motion, so far.

use clearance_geometry::math::Extremes;

use super::motion_clearance::{LeastClearance, MotionClearanceOptions, NearestMoment};
use crate::collision_report::PairDistance;

/// The nearest pair so far.
#[derive(Clone, Copy, Debug)]
pub struct NearestSoFar {
    pub segment: usize,
    pub t: f64,
    /// Number of the pair.
    pub index: usize,
    pub pair: PairDistance,
    /// False if a tolerance allowed a distance that is too large, and the witness points are not in the root frame.
    pub is_exact: bool,
}

/// Bounds on the least distance of one kind of pairs.
#[derive(Clone, Copy, Debug)]
pub struct LeastBounds {
    /// Lower bound (m) for all parts of the motion that the search is done with.
    lower: f64,
    /// The least lower bound (m) of a part that cannot be refined: no other part has to be better.
    floor: f64,
    nearest: Option<NearestSoFar>,
}

impl LeastBounds {
    pub fn new() -> Self {
        Self { lower: f64::INFINITY, floor: f64::INFINITY, nearest: None }
    }

    /// The least distance (m) found so far.
    pub fn upper(&self) -> f64 {
        self.nearest.map_or(f64::INFINITY, |nearest| nearest.pair.distance)
    }

    pub fn nearest(&self) -> Option<NearestSoFar> {
        self.nearest
    }

    /// Lower bound (m) that suffices for every part of the motion: below zero if a contact is known.
    pub fn target(&self, options: &MotionClearanceOptions) -> f64 {
        let upper = self.upper();
        let within = if upper.is_finite() { upper - options.tolerance(upper) } else { upper };
        let within = if upper > 0.0 { within } else { f64::NEG_INFINITY };
        within.lesser(options.limit).lesser(self.floor)
    }

    /// Records a pair, if it is the nearest so far.
    pub fn offer(&mut self, found: NearestSoFar) {
        if found.pair.distance < self.upper() {
            self.nearest = Some(found);
        }
    }

    /// Replaces the nearest pair by its exact distance.
    pub fn set_exact(&mut self, exact: NearestSoFar) {
        if exact.pair.distance <= self.upper() {
            self.nearest = Some(exact);
        }
    }

    /// Records the lower bound (m) of a part of the motion.
    pub fn prove(&mut self, lower: f64) {
        self.lower = self.lower.lesser(lower);
    }

    /// Records the lower bound (m) of a part that cannot be refined.
    pub fn leave(&mut self, lower: f64) {
        let lower = lower.greater(0.0);
        self.prove(lower);
        self.floor = self.floor.lesser(lower);
    }

    /// The result, with the time of a fraction of a segment; and whether the bounds are within the tolerance.
    pub fn result(
        &self,
        options: &MotionClearanceOptions,
        time: impl Fn(usize, f64) -> Option<f64>,
    ) -> (LeastClearance, bool) {
        let upper = self.upper();
        let lower = self.lower.lesser(upper).greater(0.0);
        let nearest = self.nearest.map(|NearestSoFar { segment, t, pair, .. }| NearestMoment {
            segment,
            t,
            time: time(segment, t),
            pair: PairDistance { lower: pair.distance, ..pair },
        });
        let is_within = upper.is_finite() && upper - lower <= options.tolerance(upper) * (1.0 + 1e-9);
        (LeastClearance { lower, upper, nearest }, is_within || lower == upper || lower >= options.limit)
    }
}
