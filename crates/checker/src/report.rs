//! What is asked of a state, and what is answered.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, Point};
use clearance_proximity::Work;
use clearance_scene::BodyId;

/// How much to find out about a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Question {
    /// Whether the robot hits itself and whether it hits the world; each stops at its first hit.
    Free,
    /// All colliding pairs.
    Pairs,
    /// As [`Self::Free`], and the least distance with its pair and witness points, unless it exceeds `limit` (m).
    Distance { limit: f64 },
    /// All colliding pairs, and the distance of every pair not farther apart than `limit` (m).
    PairDistances { limit: f64 },
    /// What a monitor tells: as [`Self::PairDistances`] up to `influence_distance` (m), and the least distance even if
    /// it is farther, up to `limit` (m).
    Survey { influence_distance: f64, limit: f64 },
}

/// Two bodies, how far they are apart (m, padding taken off), and where they are nearest (root frame, first on `a`).
///
/// Colliding bodies have distance 0 and one common witness point twice, if one is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairDistance {
    pub a: BodyId,
    pub b: BodyId,
    pub distance: f64,
    /// The distance is not less than this (m): as much, unless tolerances allowed less.
    pub lower: f64,
    pub witness_points: [Point; 2],
}

/// Two bodies about which the deadline left something open: their distance (m, padding taken off) is between these numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UndecidedPair {
    pub a: BodyId,
    pub b: BodyId,
    pub lower: f64,
    /// Infinite where no near points were found.
    pub upper: f64,
}

/// The answer about one state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollisionReport {
    pub self_collision: bool,
    pub world_collision: bool,
    /// Colliding pairs: all of them, or for [`Question::Free`] and [`Question::Distance`] the first of each kind.
    pub colliding_pairs: Vec<(BodyId, BodyId)>,
    /// The least distance, if the question was for distances and something is within its limit.
    pub nearest: Option<PairDistance>,
    /// For [`Question::PairDistances`] and [`Question::Survey`]: every pair within the limit, in the order of the pair list.
    pub pair_distances: Vec<PairDistance>,
    /// Pairs that the deadline left open, of which one may be told twice; none without a deadline.
    pub undecided: Vec<UndecidedPair>,
    /// Volume tests and primitive tests that the answer took.
    pub work: Work,
}

impl CollisionReport {
    /// True only if every pair that had to be checked was found apart.
    #[must_use]
    pub fn is_free(&self) -> bool {
        let apart = self.undecided.iter().all(|pair| pair.lower > CONTACT_DISTANCE);
        !self.self_collision && !self.world_collision && apart
    }

    /// Tells of every pair that was decided the distance that is certain, in place of that of its witness points: what
    /// tolerances left open makes distances smaller then, and never larger than they are.
    pub fn tell_certain_distances(&mut self) {
        let is_open =
            |pair: &PairDistance| self.undecided.iter().any(|open| (open.a, open.b) == (pair.a, pair.b));
        for pair in self.pair_distances.iter_mut().chain(&mut self.nearest).filter(|pair| !is_open(pair)) {
            pair.distance = pair.lower;
        }
        let nearest = self.pair_distances.iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
        self.nearest = nearest.copied().or(self.nearest);
    }

    /// Whether every distance is exact: none is told that may be smaller, and the deadline left nothing open.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        let is_exact = |pair: &PairDistance| pair.lower == pair.distance;
        self.undecided.is_empty() && self.pair_distances.iter().chain(&self.nearest).all(is_exact)
    }

    /// A number (m) that no pair's distance is below, of those within the question's limit; infinite if there are none.
    #[must_use]
    pub fn least_distance_lower(&self) -> f64 {
        let of_undecided = self.undecided.iter().map(|pair| pair.lower);
        let of_decided = self.nearest.iter().chain(&self.pair_distances).map(|pair| pair.lower);
        of_undecided.chain(of_decided).fold(f64::INFINITY, f64::lesser)
    }
}
