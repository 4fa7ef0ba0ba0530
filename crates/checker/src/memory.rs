//! Memory of one pair of bodies, from state to state.
//!
//! It holds a lower bound on the distance at an earlier pose. At another pose this bound is reduced by the motion of one body in the
//! frame of the other, which is at most the largest displacement of the body's bounding sphere. Earlier witness points give an upper
//! bound on the distance. For a pair that stays near, the elements that may be nearest are kept, too.
//!
//! This changes no exact result: the distance found depends neither on the search limit, as long as the limit is not smaller, nor on the
//! order in which elements are visited. (The common point of touching bodies does depend on them; for reports it comes from a separate
//! search.)

mod tolerant;

use clearance_geometry::PointPair;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_proximity::{Effort, Front, FrontLimits, Scratch, Separation};

use super::pair::{Pair, Roughly};

/// Distance (m) beyond the requested limit up to which a pair is searched, so that the result lasts for some further states.
const LOOK_AHEAD: f64 = 0.03;

/// Margin (m) beyond the nearest triangles within which other triangles are kept, since they may become the nearest.
const FRONT: f64 = 0.015;

/// Number of states for which a front must last to be worth its cost.
const WORTH: u32 = 8;

/// Maximum pause, in states, before a front is collected again where this was never worth its cost.
const LONGEST_PAUSE: u32 = 1024;

/// Rounding error (relative to the coordinates used) allowed for remembered points.
const ROUNDING: f64 = 1e-13;

/// Memory of a pair; distances are between the bodies, without padding.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    pose_ab: MatrixPose,
    /// Lower bound (m) on the distance at that pose.
    lower: f64,
    /// The result at that pose, if it was searched.
    found: Option<Separation>,
    /// Points of the bodies that were near each other at that pose.
    near_points: Option<PointPair>,
    /// Remaining tolerance (m) at the last state, and whether it will probably not last for the next state.
    left: f64,
    is_due: bool,
    front: Front,
    /// Number of states that the front has served.
    served: u32,
    /// States until the next front is collected, and the length of the last such pause.
    pause: u32,
    last_pause: u32,
    /// Cost of searches since the last front was collected, and the cost of collecting it.
    searching: u64,
    collecting: u64,
    /// True if a front is to be collected in the idle time until the next state.
    awaits_front: bool,
    /// States until the exact distance is tried again, and the length of the last such pause.
    given_up: u32,
    last_given_up: u32,
}

impl Memory {
    /// Memory of a search at the pair's pose up to `limit` (m).
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
            searching: 0,
            collecting: 0,
            awaits_front: false,
            given_up: 0,
            last_given_up: 0,
        }
    }

    /// True if the exact distance, which cost too much the last times, is to be tried again; called once per state.
    pub fn tries_exactly(&mut self) -> bool {
        let tries = self.given_up == 0;
        self.given_up = self.given_up.saturating_sub(1);
        tries
    }

    /// Records bounds within a tolerance, after the exact distance cost too much. The exact distance is tried again after a pause; each
    /// pause is twice as long as the last.
    fn give_up(&mut self, pair: &Pair, found: &Roughly) {
        self.renew(pair, found.lower, None);
        self.near_points = Some(found.upper.witness_points);
        (self.left, self.is_due) = (f64::INFINITY, false);
        self.last_given_up = (2 * self.last_given_up).clamp(1, LONGEST_PAUSE);
        self.given_up = self.last_given_up;
    }

    /// As [`Self::new`], but keeps the front, and keeps the earlier near points where no nearer ones were found.
    fn renew(&mut self, pair: &Pair, limit: f64, found: Option<Separation>) {
        let near = found.or_else(|| self.near_points_at(&pair.pose_ab));
        self.near_points = near.map(|near| near.witness_points);
        self.pose_ab = pair.pose_ab;
        self.lower = found.map_or(limit, |f| f.distance);
        self.found = found;
    }

    /// Discards a front that did not suffice. If it served few states, later fronts would not last either: bodies move fast, or large
    /// parts of them are about equally near. Then the next front is collected after a pause; each pause is twice as long as the last.
    fn drop_front(&mut self) {
        if !self.front.is_collected() {
            return;
        }
        self.front.clear();
        self.last_pause = if self.served < WORTH { (2 * self.last_pause).min(LONGEST_PAUSE) } else { WORTH };
        self.pause = if self.served < WORTH { self.last_pause } else { 0 };
    }

    /// Requests a front to be collected before the next state, unless the last ones were useless, or searches since then have cost less
    /// than collecting the last front.
    fn wish_for_front(&mut self, pair: &Pair, effort: &Effort, scratch: &mut Scratch) {
        if self.awaits_front {
            // there was no idle time
            if effort.exact_cost == 0 {
                self.collect_awaited(pair, u64::MAX, scratch);
            }
        } else if self.pause > 0 {
            self.pause -= 1;
        } else {
            self.awaits_front = self.searching >= self.collecting;
        }
    }

    /// Collects a requested front, if there is one, at the pose where the pair was found, unless it costs more than `most`.
    fn collect_awaited(&mut self, pair: &Pair, most: u64, scratch: &mut Scratch) {
        let found = self.found.filter(|_| self.awaits_front && self.pose_ab == pair.pose_ab);
        let Some(found) = found else { return };
        let before = scratch.work.cost();
        let limits = FrontLimits { beyond: found.distance + FRONT, most_work: most };
        self.front.collect(pair.posed_bodies(), &found, limits, scratch);
        self.collecting = scratch.work.cost() - before;
        (self.searching, self.served, self.awaits_front) = (0, 0, false);
    }

    /// True if the idle time until the next state should be spent on this pair.
    pub fn is_due(&self) -> bool {
        self.is_due || self.awaits_front
    }

    /// Lower bound (m) on the bodies' distance at another pose, from the motion of either body in the frame of the other.
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

    /// Distance of the remembered near points at another pose, in the frame of a.
    fn near_points_at(&self, pose_ab: &MatrixPose) -> Option<Separation> {
        let [on_a, on_b] = self.near_points?;
        let moved = pose_ab * (&self.pose_ab.inverse() * on_b);
        Some(Separation { distance: nalgebra::distance(&on_a, &moved), witness_points: [on_a, moved] })
    }

    /// Near points of the bodies from which a search may start; `None` if the bodies are proven farther apart than `limit` (m), which is
    /// recorded.
    fn near_points_within(&mut self, limit: f64, pair: &Pair, scratch: &mut Scratch) -> Option<Separation> {
        let known = self.near_points_at(&pair.pose_ab);
        if let Some(near) = known.filter(|near| hardly_less_than(near) <= limit) {
            return Some(near);
        }
        // a bound equal to the requested limit would not last for the next state
        let farther = limit + LOOK_AHEAD;
        let roughly = Effort { absolute_tolerance: LOOK_AHEAD / 2.0, ..Effort::default() };
        let far = pair.separation_bounds(farther, &roughly, scratch);
        if far.lower <= limit {
            return far.upper;
        }
        self.renew(pair, far.lower, None);
        self.near_points = far.upper.map(|upper| upper.witness_points).or(self.near_points);
        None
    }
}

/// Search limit (m) that the bodies' distance hardly exceeds, from points at the distance `near`. Points reported next to contact may lie
/// slightly off their bodies, so a search within this limit may find nothing.
fn hardly_less_than(near: &Separation) -> f64 {
    let reach: f64 = near.witness_points.iter().map(|point| point.coords.abs().sum()).sum();
    near.distance + ROUNDING * reach + CONTACT_DISTANCE
}

impl Pair<'_> {
    /// Prepares the next state in the idle time before it, at the present pose; a front may cost as much as `most`.
    pub fn prepare(
        &self,
        limit: f64,
        (effort, most): (&Effort, u64),
        memory: &mut Option<Memory>,
        scratch: &mut Scratch,
    ) {
        if let Some(known) = memory.as_mut().filter(|_| most > 0) {
            known.collect_awaited(self, most, scratch);
        }
        if !effort.is_exact() && memory.as_ref().is_some_and(|known| known.is_due) {
            let effort = &Effort { exact_cost: 0, ..*effort };
            self.renew_bounds(limit, effort, memory, scratch);
        }
    }

    /// As [`Pair::touches`], using the memory.
    pub fn touches_remembering(&self, memory: &mut Option<Memory>, scratch: &mut Scratch) -> bool {
        let padding = self.info.padding;
        match memory {
            Some(known) if known.lower_at(self) > padding => return false,
            // a pair that touched probably still touches, and a search beyond the padding would be useless
            Some(known) if known.lower > padding => {}
            _ => {
                let touches = self.touches(scratch);
                if touches || memory.is_none() {
                    *memory = Some(Memory::new(self, if touches { 0.0 } else { padding }, None));
                    return touches;
                }
            }
        }
        let found = self.separation_remembering((padding, 0), memory, scratch);
        found.is_some_and(|found| found.distance <= padding)
    }

    /// As [`Pair::separation`], using the memory; distances are exact until the state has cost the given amount, if not 0.
    pub fn separation_remembering(
        &self,
        (limit, exact_cost): (f64, u64),
        memory: &mut Option<Memory>,
        scratch: &mut Scratch,
    ) -> Option<Separation> {
        let exactly = Effort { exact_cost, ..Effort::default() };
        let found = self.separation_remembering_while(limit, &exactly, memory, scratch);
        // without tolerances all distances are exact
        found.unwrap_or_else(|_| self.separation(limit, scratch))
    }

    /// As [`Pair::separation_while`], using the memory.
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
        if let Some(found) = known.front.distance(self.posed_bodies(), limit, scratch) {
            known.renew(self, limit, found);
            known.served = known.served.saturating_add(1);
            return Ok(found);
        }
        known.drop_front();
        let before = scratch.work.cost();
        let Some(near) = known.near_points_within(limit, self, scratch) else { return Ok(None) };
        let found = match self.separation_below_while((&near, hardly_less_than(&near)), effort, scratch) {
            Ok(None) => self.separation_while(limit, effort, scratch),
            found => found,
        };
        let found = found.inspect_err(|roughly| known.give_up(self, roughly))?;
        known.renew(self, limit, found);
        known.last_given_up = 0;
        known.searching += scratch.work.cost() - before;
        let Some(found) = found.filter(|found| found.distance <= limit) else { return Ok(None) };
        if found.distance > 0.0 {
            known.wish_for_front(self, effort, scratch);
        } else {
            known.awaits_front = false;
        }
        Ok(Some(found))
    }
}
