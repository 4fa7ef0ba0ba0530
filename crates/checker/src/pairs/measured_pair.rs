//! Candidates for the nearest pair, and their measured distances.

use clearance_proximity::{DistanceCandidate, ElementPair, Separation};

/// A candidate for the nearest elements, to be measured at the end of a search, and its pair.
#[derive(Clone, Copy, Debug)]
pub struct PostponedPair {
    /// Lower bound (m) on its padded distance.
    pub lower: f64,
    /// Number of candidates bounded before the one that found it.
    pub order: usize,
    /// Number of its pair.
    pub index: usize,
    pub elements: DistanceCandidate,
}

/// A measured candidate, and its pair.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredPair {
    /// The padded distance (m).
    pub padded: f64,
    pub padding: f64,
    pub raw: Separation,
    pub elements: Option<ElementPair>,
    /// Number of its pair.
    pub index: usize,
    /// Number of candidates bounded before the one that found it.
    pub order: usize,
}

impl MeasuredPair {
    /// Order of preference for the report: the nearer first. Of equally near pairs the first is preferred, and of
    /// touching pairs the one that was found first. Within one pair the order of [`clearance_proximity`] applies.
    pub fn is_before(&self, other: &Self) -> bool {
        if self.index == other.index {
            return (self.raw.distance, self.elements) < (other.raw.distance, other.elements);
        }
        if self.padded == 0.0 && other.padded == 0.0 {
            return self.order < other.order;
        }
        (self.padded, self.index) < (other.padded, other.index)
    }

    /// True if it is within a limit (m), with the same rounding as in the other queries.
    pub fn is_within(&self, limit: f64) -> bool {
        self.raw.distance <= (limit + self.padding).next_up()
    }
}
