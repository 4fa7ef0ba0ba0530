//! Distances within a tolerance, from the memory of a pair. The known lower bound, reduced by the motion of the bodies,
//! stays valid, and known near points still give an upper bound. The pair is searched only where these bounds are too
//! far apart.
//!
//! Such a search does not look for the nearest points. It proves that nothing is nearer than the known points by more
//! than half of the tolerance; the other half is left for the next states. The remaining tolerance and the rate of its
//! decrease predict which pairs the next state will have to search, unless they are renewed in the idle time before it.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_proximity::{DistanceBounds, Effort, Scratch};

use super::{LOOK_AHEAD, PairMemory, RememberedPair};
use crate::pairs::posed_pair::PosedPair;

/// Fraction of a tolerance that a search may use up.
const SEARCHED: f64 = 0.5;

/// Number of states like the last one that a tolerance must last for, or else the pair is due.
const STATES_AHEAD: f64 = 2.0;

impl RememberedPair<'_, '_> {
    /// As [`PosedPair::separation_bounds`], using the memory. `certain` (m) is a known lower bound on the distance. The
    /// limit must not be less than the distance of touching bodies; `upper` may exceed the limit where `lower` does
    /// not.
    pub fn separation_bounds(
        &mut self,
        certain: f64,
        limit: f64,
        effort: &Effort,
        scratch: &mut Scratch,
    ) -> DistanceBounds {
        let known = self.memory.as_ref().map_or(UNKNOWN, |memory| memory.bounds_at(self.pair));
        let known = DistanceBounds { lower: known.lower.greater(certain), ..known };
        let left = left_of_tolerance(self.pair, &known, limit, effort);
        if left > 0.0 {
            if let Some(memory) = &mut *self.memory {
                memory.note_left(left);
            }
            return known;
        }
        self.search_again(&known, limit, effort, scratch)
    }

    /// Renews the bounds of a pair that is due, at its present pose.
    pub(super) fn renew_bounds(&mut self, limit: f64, effort: &Effort, scratch: &mut Scratch) {
        if let Some(known) = self.memory.as_ref().map(|memory| memory.bounds_at(self.pair)) {
            self.search_again(&known, limit, effort, scratch);
        }
    }

    fn search_again(
        &mut self,
        known: &DistanceBounds,
        limit: f64,
        effort: &Effort,
        scratch: &mut Scratch,
    ) -> DistanceBounds {
        let pair = self.pair;
        let found = search_around(pair, known, limit, effort, scratch);
        let found = DistanceBounds { lower: found.lower.greater(known.lower), ..found };
        let memory = self.memory.get_or_insert_with(|| PairMemory::new(pair, f64::NEG_INFINITY, None));
        memory.renew(pair, found.lower, None);
        memory.near_points = found.upper.map(|upper| upper.witness_points);
        memory.tolerance_left = left_of_tolerance(pair, &found, limit, effort);
        memory.is_due = false;
        found
    }
}

/// Amount (m) that a lower bound may still lose. It is positive if the bound proves the pair beyond the limit, or is
/// within the tolerance and decides contact.
fn left_of_tolerance(pair: &PosedPair, known: &DistanceBounds, limit: f64, effort: &Effort) -> f64 {
    let apart = pair.info.padding + CONTACT_DISTANCE;
    let needed = known.upper.map_or(limit, |upper| effort.lower(upper.distance).greater(apart).lesser(limit));
    known.lower - needed
}

/// Searches for bounds, starting from known near points if there are any, up to a little beyond the limit: a bound
/// equal to the limit would not last for the next state.
fn search_around(
    pair: &PosedPair,
    known: &DistanceBounds,
    limit: f64,
    effort: &Effort,
    scratch: &mut Scratch,
) -> DistanceBounds {
    let rough = Effort {
        relative_tolerance: SEARCHED * effort.relative_tolerance,
        absolute_tolerance: SEARCHED * effort.absolute_tolerance,
        ..*effort
    };
    let farther = limit + LOOK_AHEAD;
    let Some(near) = known.upper else { return pair.separation_bounds(farther, &rough, scratch) };
    // near contact, and near the range of exact distances, proving half of the gap lasts for more states than proving
    // none
    let apart = (pair.info.padding + 2.0 * CONTACT_DISTANCE).greater(effort.exact_within);
    let half_way = apart + 0.5 * (near.distance - apart).greater(0.0);
    let aim = rough.lower(near.distance).greater(half_way).lesser(farther);
    let found = pair.separation_bounds(aim, &rough, scratch);
    if found.upper.is_none() && near.distance <= aim {
        // the pair touched, but no longer does
        return pair.separation_bounds(farther, &rough, scratch);
    }
    DistanceBounds { upper: found.upper.or(Some(near)), ..found }
}

/// Bounds that hold for every pair.
const UNKNOWN: DistanceBounds = DistanceBounds { lower: f64::NEG_INFINITY, upper: None, interrupted: false };

impl PairMemory {
    /// Records the tolerance that is left after one more state.
    fn note_left(&mut self, left: f64) {
        self.is_due = left < STATES_AHEAD * (self.tolerance_left - left);
        self.tolerance_left = left;
    }

    /// Bounds on a pair's distance at another pose.
    fn bounds_at(&self, pair: &PosedPair) -> DistanceBounds {
        let upper = self.near_points_at(&pair.pose_ab);
        DistanceBounds { lower: self.lower_at(pair), upper, interrupted: false }
    }
}
