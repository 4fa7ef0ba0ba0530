//! Parts of the segments of a trajectory, into which moving obstacles split them, and where they were in the original.

use super::Trajectory;
use crate::MotionSegment;

/// Part of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    pub segment: usize,
    pub t: [f64; 2],
}

impl Trajectory {
    /// The same trajectory, split at additional times.
    pub(crate) fn cut(self, segments: Vec<MotionSegment>, parts: Vec<Part>, times: Vec<f64>) -> Self {
        let times = if self.times.is_empty() { Vec::new() } else { times };
        Self { segments, times, parts }
    }

    /// Original segment, and fraction of it, of a fraction of a segment that was split for moving obstacles.
    #[must_use]
    pub fn origin(&self, segment: usize, t: f64) -> (usize, f64) {
        match self.parts.get(segment) {
            None => (segment, t),
            Some(Part { segment, t: [from, to] }) => (*segment, (from + t * (to - from)).clamp(0.0, 1.0)),
        }
    }

    /// Whether two segments are parts of one original segment; true if they are the same.
    #[must_use]
    pub fn are_of_one_segment(&self, a: usize, b: usize) -> bool {
        self.origin(a, 0.0).0 == self.origin(b, 0.0).0
    }

    /// Where a fraction of `segment` is in `part`, as a fraction of that: below 0 or above 1, if it is in another part of one original
    /// segment. It is exact up to rounding.
    #[must_use]
    pub fn fraction_in(&self, part: usize, (segment, t): (usize, f64)) -> f64 {
        match self.parts.get(part) {
            Some(Part { t: [from, to], .. }) if segment != part => {
                (self.origin(segment, t).1 - from) / (to - from)
            }
            _ => t,
        }
    }
}
