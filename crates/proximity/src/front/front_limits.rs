//! Limits of a front: largest distance of its pairs, and largest cost of collecting them.

/// Limits of the pairs that a front collects.
#[derive(Clone, Copy, Debug)]
pub struct FrontLimits {
    /// Largest distance (m) of the elements of a pair.
    pub beyond: f64,
    /// Largest cost of collecting them ([`Work::cost`](crate::Work::cost)).
    pub most_work: u64,
}
