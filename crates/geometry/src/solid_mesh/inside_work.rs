//! Work counters of inside tests.

/// Number of elementary steps of inside tests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InsideWork {
    /// Visited boxes and triangles.
    pub visited: u64,
    /// Points of which the winding number of a surface was needed.
    pub winding_numbers: u64,
}
