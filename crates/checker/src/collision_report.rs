//! Result of a query on one state: colliding pairs, distances of pairs, nearest pairs, and undecided pairs.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, Point};
use clearance_proximity::Work;
use clearance_scene::BodyId;

use crate::pair_kind::{PairKind, SearchedPairs};

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

impl PairDistance {
    /// Whether this is a self pair or a world pair.
    #[must_use]
    pub fn kind(&self) -> PairKind {
        PairKind::of_second(self.b)
    }
}

impl UndecidedPair {
    /// Whether this is a self pair or a world pair.
    #[must_use]
    pub fn kind(&self) -> PairKind {
        PairKind::of_second(self.b)
    }
}

/// Result of a query on one state.
///
/// Without tolerances and deadline, the results for self pairs (`self_collision`, `nearest_self`) are, bit for bit, those
/// of a checker with `Settings::check_world` off, and the results for world pairs those of a checker with
/// `Settings::check_self` off. `nearest` is the nearer of the two, the self pair if they are equally near.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollisionReport {
    /// True if two bodies of the robot collide.
    pub self_collision: bool,
    /// True if a body of the robot collides with an obstacle.
    pub world_collision: bool,
    /// Colliding pairs: all of them, or for [`Free`](crate::Question::Free), [`Distance`](crate::Question::Distance) and
    /// [`SelfAndWorldDistance`](crate::Question::SelfAndWorldDistance) the first of each kind.
    pub colliding_pairs: Vec<(BodyId, BodyId)>,
    /// The least distance, if the query includes distances and something is within its limit.
    pub nearest: Option<PairDistance>,
    /// The least distance between two bodies of the robot, if some are within the limit and the deadline did not leave it
    /// open ([`Self::is_nearest_certain`]). Not part of [`Distance`](crate::Question::Distance).
    pub nearest_self: Option<PairDistance>,
    /// The same between a body of the robot and an obstacle.
    pub nearest_world: Option<PairDistance>,
    /// For [`PairDistances`](crate::Question::PairDistances) and [`Survey`](crate::Question::Survey): every pair within
    /// the limit, in the order of the pair list.
    pub pair_distances: Vec<PairDistance>,
    /// Pairs left undecided at the deadline; one pair may occur twice. Empty without a deadline.
    pub undecided: Vec<UndecidedPair>,
    /// For [`Survey`](crate::Question::Survey) with a deadline: the kind of pairs whose least distance beyond the influence
    /// distance the deadline left open. This makes neither the state nor `nearest` uncertain.
    pub unfinished: Option<PairKind>,
    /// Volume tests and primitive tests that the query took.
    pub work: Work,
}

impl CollisionReport {
    /// True only if every pair that had to be checked is proven apart.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.are_free(SearchedPairs::All)
    }

    /// As [`Self::is_free`], for some of the pairs.
    fn are_free(&self, pairs: SearchedPairs) -> bool {
        let mut kinds = PairKind::ALL.into_iter().filter(|kind| pairs.include(*kind));
        let mut open = self.undecided.iter().filter(|pair| pairs.include(pair.kind()));
        !kinds.any(|kind| self.has_collision(kind)) && open.all(|pair| pair.lower > CONTACT_DISTANCE)
    }

    /// True if pairs of this kind collide.
    #[must_use]
    pub fn has_collision(&self, kind: PairKind) -> bool {
        match kind {
            PairKind::SelfPair => self.self_collision,
            PairKind::WorldPair => self.world_collision,
        }
    }

    /// The least distance of the pairs of one kind: `nearest_self` or `nearest_world`.
    #[must_use]
    pub fn nearest_of(&self, kind: PairKind) -> Option<&PairDistance> {
        match kind {
            PairKind::SelfPair => self.nearest_self.as_ref(),
            PairKind::WorldPair => self.nearest_world.as_ref(),
        }
    }

    /// False if the deadline left pairs of this kind undecided, of which one may be the nearest.
    #[must_use]
    pub fn is_nearest_certain(&self, kind: PairKind) -> bool {
        self.unfinished != Some(kind) && self.undecided.iter().all(|pair| pair.kind() != kind)
    }

    /// The least distance (m) of the pairs of one kind: 0 if some collide, infinite if none is within the limit, NaN if
    /// the deadline left it open.
    #[must_use]
    pub fn distance_of(&self, kind: PairKind) -> f64 {
        match self.known_nearest_of(kind) {
            _ if self.has_collision(kind) => 0.0,
            Some(nearest) => nearest.distance,
            None if self.is_nearest_certain(kind) => f64::INFINITY,
            None => f64::NAN,
        }
    }

    /// As [`Self::nearest_of`], unless the deadline left open whether another pair is nearer.
    #[must_use]
    pub fn known_nearest_of(&self, kind: PairKind) -> Option<&PairDistance> {
        let is_known = |nearest: &&PairDistance| nearest.distance == 0.0 || self.is_nearest_certain(kind);
        self.nearest_of(kind).filter(is_known)
    }

    /// Replaces the distance of every decided pair by its certain lower bound. Where tolerances left a gap, reported
    /// distances become smaller than those of the witness points, and are never larger than the true ones.
    pub fn use_lower_bounds(&mut self) {
        let is_open =
            |pair: &PairDistance| self.undecided.iter().any(|open| (open.a, open.b) == (pair.a, pair.b));
        let least = [&mut self.nearest, &mut self.nearest_self, &mut self.nearest_world];
        let pairs = self.pair_distances.iter_mut().chain(least.into_iter().flatten());
        for pair in pairs.filter(|pair| !is_open(pair)) {
            pair.distance = pair.lower;
        }
        for kind in PairKind::ALL {
            let of_kind = self.pair_distances.iter().filter(|pair| pair.kind() == kind);
            if let Some(nearest) = nearest_among(of_kind) {
                *self.nearest_mut(SearchedPairs::Only(kind)) = Some(nearest);
            }
        }
        let of_both_kinds = self.nearest_self.iter().chain(&self.nearest_world);
        let nearest = nearest_among(self.pair_distances.iter()).or(nearest_among(of_both_kinds));
        self.nearest = nearest.or(self.nearest);
    }

    /// True if every distance is exact: no reported distance may be too large, and the deadline left nothing open.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        let is_exact = |pair: &PairDistance| pair.lower == pair.distance;
        self.undecided.is_empty() && self.unfinished.is_none() && self.distances().all(is_exact)
    }

    /// Lower bound (m) on the distances of all pairs within the query's limit; infinite if there are none.
    #[must_use]
    pub fn least_distance_lower(&self) -> f64 {
        let of_undecided = self.undecided.iter().map(|pair| pair.lower);
        of_undecided.chain(self.distances().map(|pair| pair.lower)).fold(f64::INFINITY, f64::lesser)
    }

    /// All reported distances; some of them more than once.
    fn distances(&self) -> impl Iterator<Item = &PairDistance> {
        let least = self.nearest.iter().chain(&self.nearest_self).chain(&self.nearest_world);
        least.chain(&self.pair_distances)
    }

    /// The least distance of some of the pairs.
    pub(crate) fn nearest_mut(&mut self, pairs: SearchedPairs) -> &mut Option<PairDistance> {
        match pairs {
            SearchedPairs::All => &mut self.nearest,
            SearchedPairs::Only(PairKind::SelfPair) => &mut self.nearest_self,
            SearchedPairs::Only(PairKind::WorldPair) => &mut self.nearest_world,
        }
    }

    /// Sets `nearest` to the nearer of `nearest_self` and `nearest_world`, with a lower bound on the distances of both.
    pub(crate) fn set_nearest_of_both_kinds(&mut self) {
        let both = || self.nearest_self.iter().chain(&self.nearest_world);
        let lower = both().map(|pair| pair.lower).fold(f64::INFINITY, f64::lesser);
        self.nearest = nearest_among(both()).map(|nearest| PairDistance { lower, ..nearest });
    }

    /// Records a pair that is the first one, or nearer than those before it.
    pub(crate) fn note_distance(&mut self, found: &PairDistance) {
        for pairs in [SearchedPairs::All, SearchedPairs::Only(found.kind())] {
            let nearest = self.nearest_mut(pairs);
            if nearest.is_none_or(|nearest| found.distance < nearest.distance) {
                *nearest = Some(*found);
            }
        }
    }

    /// Where two methods could differ, contact takes precedence: adds the nearest of some pairs to the colliding pairs if
    /// its distance is zero.
    pub(crate) fn include_contact_of_nearest(&mut self, pairs: SearchedPairs) {
        if let Some(touching) = self.nearest_mut(pairs).filter(|n| n.distance == 0.0)
            && !self.has_collision(touching.kind())
        {
            self.add_collision((touching.a, touching.b));
        }
    }

    /// Records a lower bound (m) on the distances of some pairs, if they are free, for what tolerances left open.
    pub(crate) fn raise_nearest_lower_bound(&mut self, pairs: SearchedPairs, beyond: f64) {
        let are_free = self.are_free(pairs);
        if let Some(nearest) = self.nearest_mut(pairs).as_mut().filter(|_| are_free) {
            let least = beyond.greater(f64::MIN_POSITIVE).lesser(nearest.distance);
            nearest.lower = nearest.lower.greater(least);
        }
    }

    /// Adds a colliding pair.
    pub(crate) fn add_collision(&mut self, pair: (BodyId, BodyId)) {
        match PairKind::of_second(pair.1) {
            PairKind::SelfPair => self.self_collision = true,
            PairKind::WorldPair => self.world_collision = true,
        }
        self.colliding_pairs.push(pair);
    }
}

/// The nearest pair; the first of equally near ones.
fn nearest_among<'p>(pairs: impl Iterator<Item = &'p PairDistance>) -> Option<PairDistance> {
    pairs.min_by(|a, b| a.distance.total_cmp(&b.distance)).copied()
}
