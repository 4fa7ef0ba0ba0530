//! Queries on one state, and their results.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, Point};
use clearance_proximity::Work;
use clearance_scene::BodyId;

/// Extent of a query on one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Question {
    /// Whether the robot collides with itself and with the world; each search stops at its first collision.
    Free,
    /// All colliding pairs.
    Pairs,
    /// As [`Self::Free`], and the least distance with its pair and witness points, unless it exceeds `limit` (m).
    Distance { limit: f64 },
    /// All colliding pairs, and the distance of every pair not farther apart than `limit` (m).
    PairDistances { limit: f64 },
    /// Query of a monitor: as [`Self::PairDistances`] up to `influence_distance` (m), and the least distance even if it is larger, up to
    /// `limit` (m).
    Survey { influence_distance: f64, limit: f64 },
}

/// Distance of two bodies (m, padding subtracted) and their witness points (root frame, first on `a`).
///
/// Colliding bodies have distance 0 and the same witness point twice, if a common point is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairDistance {
    pub a: BodyId,
    pub b: BodyId,
    pub distance: f64,
    /// Lower bound (m) on the distance: equal to `distance`, unless tolerances allowed a smaller one.
    pub lower: f64,
    pub witness_points: [Point; 2],
}

/// Two bodies left undecided at the deadline: their distance (m, padding subtracted) is between these numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UndecidedPair {
    pub a: BodyId,
    pub b: BodyId,
    pub lower: f64,
    /// Infinite where no near points were found.
    pub upper: f64,
}

/// Result of a query on one state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollisionReport {
    pub self_collision: bool,
    pub world_collision: bool,
    /// Colliding pairs: all of them, or for [`Question::Free`] and [`Question::Distance`] the first of each kind.
    pub colliding_pairs: Vec<(BodyId, BodyId)>,
    /// The least distance, if the query includes distances and something is within its limit.
    pub nearest: Option<PairDistance>,
    /// For [`Question::PairDistances`] and [`Question::Survey`]: every pair within the limit, in the order of the pair list.
    pub pair_distances: Vec<PairDistance>,
    /// Pairs left undecided at the deadline; one pair may occur twice. Empty without a deadline.
    pub undecided: Vec<UndecidedPair>,
    /// Volume tests and primitive tests that the answer took.
    pub work: Work,
}

impl CollisionReport {
    /// True only if every pair that had to be checked is proven apart.
    #[must_use]
    pub fn is_free(&self) -> bool {
        let apart = self.undecided.iter().all(|pair| pair.lower > CONTACT_DISTANCE);
        !self.self_collision && !self.world_collision && apart
    }

    /// Replaces the distance of every decided pair by its certain lower bound. Where tolerances left a gap, reported distances become
    /// smaller than those of the witness points, and are never larger than the true ones.
    pub fn tell_certain_distances(&mut self) {
        let is_open =
            |pair: &PairDistance| self.undecided.iter().any(|open| (open.a, open.b) == (pair.a, pair.b));
        for pair in self.pair_distances.iter_mut().chain(&mut self.nearest).filter(|pair| !is_open(pair)) {
            pair.distance = pair.lower;
        }
        let nearest = self.pair_distances.iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
        self.nearest = nearest.copied().or(self.nearest);
    }

    /// True if every distance is exact: no reported distance may be too large, and the deadline left nothing undecided.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        let is_exact = |pair: &PairDistance| pair.lower == pair.distance;
        self.undecided.is_empty() && self.pair_distances.iter().chain(&self.nearest).all(is_exact)
    }

    /// Lower bound (m) on the distances of all pairs within the query's limit; infinite if there are none.
    #[must_use]
    pub fn least_distance_lower(&self) -> f64 {
        let of_undecided = self.undecided.iter().map(|pair| pair.lower);
        let of_decided = self.nearest.iter().chain(&self.pair_distances).map(|pair| pair.lower);
        of_undecided.chain(of_decided).fold(f64::INFINITY, f64::lesser)
    }
}
