//! Results that are the same in all states, computed once: parts in reach of obstacles, nearest obstacle to fixed parts

use std::sync::OnceLock;

use super::measured_pair::MeasuredPair;
use crate::world::BodiesInReach;

/// Results for the parts that no joint moves, and for the reach of the others. Two threads may both compute a result,
/// with the same value; neither waits for the other.
#[derive(Clone, Debug, Default)]
pub struct StateIndependent {
    /// Parts that are to be tested against obstacles.
    pub bodies_in_reach: OnceLock<BodiesInReach>,
    /// Nearest obstacle to the parts that no joint moves.
    pub nearest_to_fixed: OnceLock<NearestToFixed>,
}

/// The nearest obstacle to the parts that no joint moves.
#[derive(Clone, Copy, Debug)]
pub enum NearestToFixed {
    /// There is no obstacle, or no part that no joint moves.
    Nothing,
    /// An obstacle touches such a part, padding included. If several touch, the reported one depends on the search
    /// order, so these parts are searched in every state.
    Touching,
    Apart(MeasuredPair),
}
