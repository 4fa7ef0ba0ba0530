//! Distances within a tolerance from what is remembered: what was certain about a pair stays so, less what its bodies have
//! moved, and points that were near still bound its distance from above. Only where the two are too far apart, it is searched.
//!
//! Such a search does not look for the nearest points, it proves that nothing is nearer than the known ones by more than half of
//! the tolerance; the other half is for the states to come. How much of it is left, and how fast it goes, tells which pairs the
//! next state will have to search, if nobody does so before it comes.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_proximity::{DistanceBounds, Effort, Scratch};

use super::{LOOK_AHEAD, Memory};
use crate::pair::Pair;

/// The share of a tolerance that a search may use up.
const SEARCHED: f64 = 0.5;

/// For how many states like the last one a tolerance has to last, for a pair not to be due.
const STATES_AHEAD: f64 = 2.0;

impl Pair<'_> {
    /// As [`Pair::separation_bounds`], with what is remembered, of a distance that is certainly not below `certain` (m), up to a
    /// limit that what touches is within; `upper` may be beyond it where `lower` is not.
    pub fn separation_bounds_remembering(
        &self,
        (certain, limit): (f64, f64),
        effort: &Effort,
        memory: &mut Option<Memory>,
        scratch: &mut Scratch,
    ) -> DistanceBounds {
        let known = memory.as_ref().map_or(UNKNOWN, |memory| memory.bounds_at(self));
        let known = DistanceBounds { lower: known.lower.greater(certain), ..known };
        let left = self.left_of_tolerance(&known, limit, effort);
        if left > 0.0 {
            if let Some(memory) = memory {
                memory.note_left(left);
            }
            return known;
        }
        self.search_anew(&known, limit, effort, memory, scratch)
    }

    /// Renews what is known of a pair that is due, where it is now.
    pub(super) fn renew_bounds(
        &self,
        limit: f64,
        effort: &Effort,
        memory: &mut Option<Memory>,
        scratch: &mut Scratch,
    ) {
        if let Some(known) = memory.as_ref().map(|memory| memory.bounds_at(self)) {
            self.search_anew(&known, limit, effort, memory, scratch);
        }
    }

    fn search_anew(
        &self,
        known: &DistanceBounds,
        limit: f64,
        effort: &Effort,
        memory: &mut Option<Memory>,
        scratch: &mut Scratch,
    ) -> DistanceBounds {
        let found = self.search_around(known, limit, effort, scratch);
        let found = DistanceBounds { lower: found.lower.greater(known.lower), ..found };
        let memory = memory.get_or_insert_with(|| Memory::new(self, f64::NEG_INFINITY, None));
        memory.renew(self, found.lower, None);
        memory.near_points = found.upper.map(|upper| upper.witness_points);
        memory.left = self.left_of_tolerance(&found, limit, effort);
        memory.is_due = false;
        found
    }

    /// How much (m) a lower bound may still lose: more than nothing if it proves the pair beyond the limit, or is within the
    /// tolerance and leaves no doubt about contact.
    fn left_of_tolerance(&self, known: &DistanceBounds, limit: f64, effort: &Effort) -> f64 {
        let apart = self.info.padding + CONTACT_DISTANCE;
        let needed =
            known.upper.map_or(limit, |upper| effort.lower(upper.distance).greater(apart).lesser(limit));
        known.lower - needed
    }

    /// Searches what is certain from points that are known to be near, if there are any, and a little beyond the limit,
    /// for else it would run out in the next state.
    fn search_around(
        &self,
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
        let Some(near) = known.upper else { return self.separation_bounds(farther, &rough, scratch) };
        // next to contact, and to where distances are exact, a proof of half the gap is for more states than one of no gap
        let apart = (self.info.padding + 2.0 * CONTACT_DISTANCE).greater(effort.exact_within);
        let half_way = apart + 0.5 * (near.distance - apart).greater(0.0);
        let aim = rough.lower(near.distance).greater(half_way).lesser(farther);
        let found = self.separation_bounds(aim, &rough, scratch);
        if found.upper.is_none() && near.distance <= aim {
            // what touched does no longer
            return self.separation_bounds(farther, &rough, scratch);
        }
        DistanceBounds { upper: found.upper.or(Some(near)), ..found }
    }
}

/// What is certain about any pair.
const UNKNOWN: DistanceBounds = DistanceBounds { lower: f64::NEG_INFINITY, upper: None, interrupted: false };

impl Memory {
    /// Notes what is left of the tolerance in one more state.
    fn note_left(&mut self, left: f64) {
        self.is_due = left < STATES_AHEAD * (self.left - left);
        self.left = left;
    }

    /// What is certain about a pair's distance at another pose.
    fn bounds_at(&self, pair: &Pair) -> DistanceBounds {
        let upper = self.near_points_at(&pair.pose_ab);
        DistanceBounds { lower: self.lower_at(pair), upper, interrupted: false }
    }
}
