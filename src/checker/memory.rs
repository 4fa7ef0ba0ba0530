//! What is remembered of a pair of bodies from state to state.
//!
//! A distance that it certainly had at some pose: at another it has lost at most what one body has moved in the frame
//! of the other, which is the largest displacement of the body's sphere. Points of the bodies that were nearest bound the
//! distance from above, and of a pair that stays near, the elements that may be nearest are kept.
//!
//! None of this changes an exact answer: a distance that is found depends neither on the limit of the search, as long as that is not
//! below it, nor on the order in which elements are met. (Which common point of touching bodies is found does; reports have
//! that of a search of its own.)

mod tolerant;

use super::pair::{Pair, Roughly};
use crate::constants::CONTACT_DISTANCE;
use crate::geometry::PointPair;
use crate::math::{Extremes, MatrixPose};
use crate::query::{Effort, Front, Scratch, Separation};

/// How far (m) beyond what was asked a pair's distance is looked for, to know it for some states to come.
const LOOK_AHEAD: f64 = 0.03;

/// How much farther (m) than the nearest triangles others are kept that may become the nearest.
const FRONT: f64 = 0.015;

/// States for which a front must be enough to have been worth collecting.
const WORTH: u32 = 8;

/// States after which collecting is tried once more where it was never worth it.
const LONGEST_PAUSE: u32 = 1024;

/// Rounding (relative to the coordinates that enter) granted to remembered points.
const ROUNDING: f64 = 1e-13;

/// What is known about a pair; distances are those of the bodies, no padding taken off.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    pose_ab: MatrixPose,
    /// The bodies were not nearer than this (m) at that pose.
    lower: f64,
    /// The answer at that pose, if one was looked for.
    found: Option<Separation>,
    /// Points of the bodies that were near each other at that pose.
    near_points: Option<PointPair>,
    /// How much (m) of a tolerance was left at the last state, and whether that hardly lasts for the next.
    left: f64,
    is_due: bool,
    front: Front,
    /// States for which the front has been enough.
    served: u32,
    /// States until the next front is collected, and how many they were the last time.
    pause: u32,
    last_pause: u32,
    /// States until the exact distance is tried for again, and how many they were the last time.
    given_up: u32,
    last_given_up: u32,
}

impl Memory {
    /// What was found at the pair's pose when it was looked for up to `limit` (m).
    fn new(pair: &Pair, limit: f64, found: Option<Separation>) -> Self {
        let lower = found.map_or(limit, |f| f.distance);
        let near_points = found.map(|f| f.witness_points);
        Self {
            pose_ab: pair.pose_ab,
            lower,
            found,
            near_points,
            left: f64::INFINITY,
            is_due: false,
            front: Front::default(),
            served: 0,
            pause: 0,
            last_pause: WORTH,
            given_up: 0,
            last_given_up: 0,
        }
    }

    /// Whether it is time to try for the exact distance, which cost too much the last times; asked once a state.
    pub fn tries_exactly(&mut self) -> bool {
        let tries = self.given_up == 0;
        self.given_up = self.given_up.saturating_sub(1);
        tries
    }

    /// Notes what was found within a tolerance because the exact distance cost too much. It is tried for again after a pause, each
    /// twice as long as the last.
    fn give_up(&mut self, pair: &Pair, found: &Roughly) {
        self.renew(pair, found.lower, None);
        self.near_points = Some(found.upper.witness_points);
        (self.left, self.is_due) = (f64::INFINITY, false);
        self.last_given_up = (2 * self.last_given_up).clamp(1, LONGEST_PAUSE);
        self.given_up = self.last_given_up;
    }

    /// As [`Self::new`], but keeps the front, and points that were near where no nearer ones were found.
    fn renew(&mut self, pair: &Pair, limit: f64, found: Option<Separation>) {
        let near = found.or_else(|| self.near_points_at(&pair.pose_ab));
        self.near_points = near.map(|near| near.witness_points);
        self.pose_ab = pair.pose_ab;
        self.lower = found.map_or(limit, |f| f.distance);
        self.found = found;
    }

    /// Lets a front go that was not enough. If it was for few states, others would be too: where bodies move fast, or much of them
    /// is about equally near. The next one is collected after a pause, each twice as long as the last.
    fn drop_front(&mut self) {
        if !self.front.is_collected() {
            return;
        }
        self.front.clear();
        self.last_pause = if self.served < WORTH { (2 * self.last_pause).min(LONGEST_PAUSE) } else { WORTH };
        self.pause = if self.served < WORTH { self.last_pause } else { 0 };
    }

    /// Collects a front, unless the last ones were for nothing.
    fn collect_if_worth(&mut self, pair: &Pair, found: &Separation, scratch: &mut Scratch) {
        if self.pause > 0 {
            self.pause -= 1;
            return;
        }
        self.served = 0;
        self.front.collect(pair.bodies, &pair.pose_ab, found, found.distance + FRONT, scratch);
    }

    /// A number never larger than the bodies' distance (m) at another pose: by either's motion in the frame of the other.
    pub fn lower_at(&self, pair: &Pair) -> f64 {
        let (from, to) = (&self.pose_ab, &pair.pose_ab);
        let of_b = pair.bodies.1.bounding_sphere().displacement(from, to);
        let of_a = pair.bodies.0.bounding_sphere().displacement(&from.inverse(), &to.inverse());
        self.lower - of_a.lesser(of_b) - CONTACT_DISTANCE
    }

    /// Whether the nearest points were found.
    pub fn was_near(&self) -> bool {
        self.found.is_some()
    }

    /// What the bodies' distance (m) at another pose is hardly larger than: nearest points told next to contact may lie a
    /// little off their bodies, so a search within this may find nothing.
    fn upper_at(&self, pose_ab: &MatrixPose) -> f64 {
        self.near_points_at(pose_ab).map_or(f64::INFINITY, |near| {
            let reach: f64 = near.witness_points.iter().map(|point| point.coords.abs().sum()).sum();
            near.distance + ROUNDING * reach + CONTACT_DISTANCE
        })
    }

    /// How far apart points are at another pose that were near, in the frame of a.
    fn near_points_at(&self, pose_ab: &MatrixPose) -> Option<Separation> {
        let [on_a, on_b] = self.near_points?;
        let moved = pose_ab * (&self.pose_ab.inverse() * on_b);
        Some(Separation { distance: nalgebra::distance(&on_a, &moved), witness_points: [on_a, moved] })
    }
}

impl Pair<'_> {
    /// As [`Pair::touches`], with what is remembered.
    pub fn touches_remembering(&self, memory: &mut Option<Memory>, scratch: &mut Scratch) -> bool {
        let padding = self.info.padding;
        match memory {
            Some(known) if known.lower_at(self) > padding => return false,
            // what touched probably touches still, and to look further would be for nothing
            Some(known) if known.lower > padding => {}
            _ => {
                let touches = self.touches(scratch);
                if touches || memory.is_none() {
                    *memory = Some(Memory::new(self, if touches { 0.0 } else { padding }, None));
                    return touches;
                }
            }
        }
        let found = self.separation_remembering(padding, memory, scratch);
        found.is_some_and(|found| found.distance <= padding)
    }

    /// As [`Pair::separation`], with what is remembered.
    pub fn separation_remembering(
        &self,
        limit: f64,
        memory: &mut Option<Memory>,
        scratch: &mut Scratch,
    ) -> Option<Separation> {
        let found = self.separation_remembering_while(limit, &Effort::default(), memory, scratch);
        // with no tolerance nothing is told roughly
        found.unwrap_or_else(|_| self.separation(limit, scratch))
    }

    /// As [`Pair::separation_while`], with what is remembered.
    pub fn separation_remembering_while(
        &self,
        limit: f64,
        effort: &Effort,
        memory: &mut Option<Memory>,
        scratch: &mut Scratch,
    ) -> Result<Option<Separation>, Roughly> {
        let limit = limit.greater(CONTACT_DISTANCE);
        let Some(known) = memory else {
            let found = self.separation_while(limit, effort, scratch);
            let known = memory.insert(Memory::new(self, limit, found.ok().flatten()));
            return found.inspect_err(|roughly| known.give_up(self, roughly));
        };
        if known.lower_at(self) > limit {
            return Ok(None);
        }
        if known.pose_ab == self.pose_ab
            && let Some(found) = known.found
        {
            return Ok((found.distance <= limit).then_some(found));
        }
        if let Some(found) = known.front.distance(self.bodies, &self.pose_ab, limit, scratch) {
            known.renew(self, limit, found);
            known.served = known.served.saturating_add(1);
            return Ok(found);
        }
        known.drop_front();
        let mut tight = known.upper_at(&self.pose_ab);
        if tight > limit {
            // a bound that is no more than was asked would run out in the next state
            let farther = limit + LOOK_AHEAD;
            let roughly = Effort { absolute_tolerance: LOOK_AHEAD / 2.0, ..Effort::default() };
            let far = self.separation_bounds(farther, &roughly, scratch);
            if far.lower > limit {
                known.renew(self, far.lower, None);
                known.near_points = far.upper.map(|upper| upper.witness_points).or(known.near_points);
                return Ok(None);
            }
            tight = far.upper.map_or(farther, |upper| upper.distance).lesser(tight);
        }
        let found = match self.separation_while(tight, effort, scratch) {
            Ok(None) => self.separation_while(limit, effort, scratch),
            found => found,
        };
        let found = found.inspect_err(|roughly| known.give_up(self, roughly))?;
        known.renew(self, limit, found);
        known.last_given_up = 0;
        let Some(found) = found.filter(|found| found.distance <= limit) else { return Ok(None) };
        if found.distance > 0.0 {
            known.collect_if_worth(self, &found, scratch);
        }
        Ok(Some(found))
    }
}
