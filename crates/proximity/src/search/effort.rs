//! Tolerances and time limit of a search.

use std::time::Instant;

use clearance_geometry::math::Extremes;

use super::work::Work;

/// Search options: tolerances and time limit of a distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Allowed relative error by which the result may be too large (relative to the bodies' distance, where a padding is subtracted).
    pub relative_tolerance: f64,
    /// Allowed absolute error (m); the larger of the two applies.
    pub absolute_tolerance: f64,
    /// Distances up to this (m) are exact nevertheless.
    pub exact_within: f64,
    /// The distances of a state are exact until it has cost this much ([`Work::cost`]).
    pub exact_cost: u64,
    /// Time at which the search stops with its results so far.
    pub deadline: Option<Instant>,
}

impl Effort {
    /// True if the result must be exact, without a time limit.
    #[must_use]
    #[inline]
    pub fn is_exact(&self) -> bool {
        let is_tolerant = self.relative_tolerance > 0.0 || self.absolute_tolerance > 0.0;
        !is_tolerant && self.deadline.is_none()
    }

    /// Whether the deadline has passed.
    #[must_use]
    #[inline]
    pub fn is_over(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Lower bound on a distance that is reported as `upper`; tolerances below zero count as zero.
    #[must_use]
    #[inline]
    pub fn lower(&self, upper: f64) -> f64 {
        let within = upper - self.absolute_tolerance.greater(self.relative_tolerance * upper).greater(0.0);
        if self.exact_within > 0.0 { within.greater(self.exact_within.lesser(upper)) } else { within }
    }

    /// As [`Self::lower`], after the given amount of work.
    #[inline]
    pub fn lower_after(&self, work: &Work, upper: f64) -> f64 {
        if self.exact_cost > 0 && work.cost() < self.exact_cost { upper } else { self.lower(upper) }
    }
}
