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
    Distance {
        /// Larger distances (m) are not reported.
        limit: f64,
    },
    /// All colliding pairs, and the distance of every pair not farther apart than `limit` (m).
    PairDistances {
        /// Larger distances (m) are not reported.
        limit: f64,
    },
    /// Query of a monitor: as [`Self::PairDistances`] up to `influence_distance` (m), and the least distance even if it
    /// is larger, up to `limit` (m).
    Survey {
        /// Up to this distance (m), the distance of every pair is reported.
        influence_distance: f64,
        /// A least distance larger than this (m) is not reported.
        limit: f64,
    },
}

/// Distance of two bodies (m, padding subtracted) and their witness points (root frame, first on `a`).
///
/// Colliding bodies have distance 0 and the same witness point twice, if a common point is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairDistance {
    /// The first body: a link or an attached object.
    pub a: BodyId,
    /// The second body.
    pub b: BodyId,
    /// Distance (m), padding subtracted; 0 for colliding bodies.
    pub distance: f64,
    /// Lower bound (m) on the distance: equal to `distance`, unless tolerances allowed a smaller one.
    pub lower: f64,
    /// Nearest points of the two bodies (m, root frame), without padding.
    pub witness_points: [Point; 2],
}

/// Two bodies left undecided at the deadline: their distance (m, padding subtracted) is between these numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UndecidedPair {
    /// The first body: a link or an attached object.
    pub a: BodyId,
    /// The second body.
    pub b: BodyId,
    /// Lower bound (m) on the distance.
    pub lower: f64,
    /// Upper bound (m) on the distance; infinite where no near points were found.
    pub upper: f64,
}

/// Result of a query on one state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollisionReport {
    /// True if two bodies of the robot collide.
    pub self_collision: bool,
    /// True if a body of the robot collides with an obstacle.
    pub world_collision: bool,
    /// Colliding pairs: all of them, or for [`Question::Free`] and [`Question::Distance`] the first of each kind.
    pub colliding_pairs: Vec<(BodyId, BodyId)>,
    /// The least distance, if the query includes distances and something is within its limit.
    pub nearest: Option<PairDistance>,
    /// For [`Question::PairDistances`] and [`Question::Survey`]: every pair within the limit, in the order of the pair
    /// list.
    pub pair_distances: Vec<PairDistance>,
    /// Pairs left undecided at the deadline; one pair may occur twice. Empty without a deadline.
    pub undecided: Vec<UndecidedPair>,
    /// Volume tests and primitive tests that the query took.
    pub work: Work,
}

impl CollisionReport {
    /// True only if every pair that had to be checked is proven apart.
    #[must_use]
    pub fn is_free(&self) -> bool {
        let apart = self.undecided.iter().all(|pair| pair.lower > CONTACT_DISTANCE);
        !self.self_collision && !self.world_collision && apart
    }

    /// Replaces the distance of every decided pair by its certain lower bound. Where tolerances left a gap, reported
    /// distances become smaller than those of the witness points, and are never larger than the true ones.
    pub fn use_lower_bounds(&mut self) {
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

    /// True if a collision with the same kind of body as `other` was already found.
    fn has_collision_like(&self, other: BodyId) -> bool {
        match other {
            BodyId::Link(_) | BodyId::Attached(_) => self.self_collision,
            BodyId::Obstacle(_) => self.world_collision,
        }
    }

    /// Where two methods could differ, contact takes precedence: adds the nearest pair to the colliding pairs if its
    /// distance is zero.
    pub(crate) fn include_contact_of_nearest(&mut self) {
        if let Some(touching) = self.nearest.filter(|n| n.distance == 0.0)
            && !self.has_collision_like(touching.b)
        {
            self.add_collision((touching.a, touching.b));
        }
    }

    /// Records a lower bound (m) on the distances of free pairs, for what tolerances left open.
    pub(crate) fn raise_nearest_lower_bound(&mut self, beyond: f64) {
        let is_free = self.is_free();
        if let Some(nearest) = self.nearest.as_mut().filter(|_| is_free) {
            let least = beyond.greater(f64::MIN_POSITIVE).lesser(nearest.distance);
            nearest.lower = nearest.lower.greater(least);
        }
    }

    /// Adds a colliding pair.
    pub(crate) fn add_collision(&mut self, pair: (BodyId, BodyId)) {
        match pair.1 {
            BodyId::Link(_) | BodyId::Attached(_) => self.self_collision = true,
            BodyId::Obstacle(_) => self.world_collision = true,
        }
        self.colliding_pairs.push(pair);
    }
}
