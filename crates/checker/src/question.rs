//! Kinds of query on one state: free or not, colliding pairs, least distance, distances of pairs.

/// Kind of query on one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Question {
    /// Whether the robot collides with itself and with the world; each search stops at its first collision.
    Free,
    /// All colliding pairs.
    Pairs,
    /// As [`Self::Free`], and the least distance with its pair and witness points, unless it exceeds `limit` (m).
    Distance {
        /// Larger distances (m) are not reported.
        limit: f64,
    },
    /// As [`Self::Distance`], with the least distance of self pairs and that of world pairs: two searches. A work budget
    /// ([`Effort::exact_cost`](clearance_proximity::Effort::exact_cost)) or a deadline serves the self pairs first.
    SelfAndWorldDistance {
        /// Larger distances (m) are not reported.
        limit: f64,
    },
    /// All colliding pairs, and the distance of every pair not farther apart than `limit` (m).
    PairDistances {
        /// Larger distances (m) are not reported.
        limit: f64,
    },
    /// Query of a monitor: as [`Self::PairDistances`] up to `influence_distance` (m), and the least distances of self
    /// pairs and of world pairs even if they are larger, up to `limit` (m).
    Survey {
        /// Up to this distance (m), the distance of every pair is reported.
        influence_distance: f64,
        /// A least distance larger than this (m) is not reported.
        limit: f64,
    },
}
