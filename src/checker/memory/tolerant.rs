//! Distances within a tolerance from what is remembered: what was certain about a pair stays so, less what its bodies have
//! moved, and points that were near still bound its distance from above. Only where the two are too far apart, it is searched.
//!
//! Such a search does not look for the nearest points, it proves that nothing is nearer than the known ones by more than half of
//! the tolerance; the other half is for the states to come.

use super::{LOOK_AHEAD, Memory};
use crate::checker::pair::Pair;
use crate::constants::CONTACT_DISTANCE;
use crate::math::{Extremes, MatrixPose};
use crate::query::{DistanceBounds, Effort, Scratch, Separation};

/// The share of a tolerance that a search may use up.
const SEARCHED: f64 = 0.5;

impl Pair<'_> {
    /// As [`Pair::separation_bounds`], with what is remembered, of a distance that is certainly not below `certain` (m); `upper` may
    /// be beyond `limit` where `lower` is not.
    pub fn separation_bounds_remembering(
        &self,
        (certain, limit): (f64, f64),
        effort: &Effort,
        memory: &mut Option<Memory>,
        scratch: &mut Scratch,
    ) -> DistanceBounds {
        let limit = limit.greater(CONTACT_DISTANCE);
        let known = memory.as_ref().map_or(UNKNOWN, |memory| memory.bounds_at(self));
        let known = DistanceBounds { lower: known.lower.greater(certain), ..known };
        if known.lower > limit || self.suffices(&known, effort) {
            return known;
        }
        let found = self.search_around(&known, limit, effort, scratch);
        let found = DistanceBounds { lower: found.lower.greater(known.lower), ..found };
        match memory {
            Some(memory) => memory.renew_bounds(self, &found),
            None => *memory = Some(Memory::of_bounds(self, &found)),
        }
        found
    }

    /// Whether bounds are within the tolerance, and leave no doubt about contact.
    fn suffices(&self, known: &DistanceBounds, effort: &Effort) -> bool {
        let proven = known.lower > self.info.padding + CONTACT_DISTANCE;
        known.upper.is_some_and(|upper| proven && known.lower >= effort.lower(upper.distance))
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
        // next to contact, a proof of half the gap is for more states than one of contact alone
        let apart = self.info.padding + 2.0 * CONTACT_DISTANCE;
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
    fn of_bounds(pair: &Pair, found: &DistanceBounds) -> Self {
        let mut memory = Self::new(pair, f64::NEG_INFINITY, None);
        memory.renew_bounds(pair, found);
        memory
    }

    fn renew_bounds(&mut self, pair: &Pair, found: &DistanceBounds) {
        self.renew(pair, found.lower, None);
        self.near_points = found.upper.map(|upper| upper.witness_points);
    }

    /// What is certain about a pair's distance at another pose.
    fn bounds_at(&self, pair: &Pair) -> DistanceBounds {
        let upper = self.near_points_at(&pair.pose_ab);
        DistanceBounds { lower: self.lower_at(pair), upper, interrupted: false }
    }

    /// How far apart points are now that were near, in the frame of a.
    fn near_points_at(&self, pose_ab: &MatrixPose) -> Option<Separation> {
        let [on_a, on_b] = self.near_points?;
        let moved = pose_ab * (&self.pose_ab.inverse() * on_b);
        Some(Separation { distance: nalgebra::distance(&on_a, &moved), witness_points: [on_a, moved] })
    }
}
