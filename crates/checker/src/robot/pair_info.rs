//! Data types: constants of a pair of bodies, and candidate pair for the narrow phase.

use clearance_scene::BodyId;

/// The constants of a pair.
#[derive(Clone, Copy, Debug)]
pub struct PairInfo {
    pub ids: (BodyId, BodyId),
    /// The index of the robot part, and the index of the other part or the place of the obstacle.
    pub bodies: (usize, usize),
    /// Safety distance (m) that is subtracted from the distance of the bodies.
    pub padding: f64,
}

/// A pair that the narrow phase is to test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidatePair {
    /// Lower bound (m) on its padded distance.
    pub lower: f64,
    /// Number of the pair.
    pub index: usize,
}
