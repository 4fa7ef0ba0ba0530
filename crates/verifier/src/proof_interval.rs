//! Interval of a proof, by its middle and half width.

use clearance_geometry::math::Extremes;

/// A part of a segment, in t from 0 to 1; contains the interval that it was made from despite rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ProofInterval {
    pub middle: f64,
    pub half_width: f64,
}

impl ProofInterval {
    pub fn new(from: f64, to: f64) -> Self {
        let middle = 0.5 * (from + to);
        Self { middle, half_width: (to - middle).greater(middle - from) }
    }
}
