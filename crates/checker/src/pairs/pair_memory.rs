//! Temporal coherence of one pair of bodies: reuses distance bounds, witness points and the front of the last state.
//!
//! It stores a lower bound on the distance at an earlier pose. At another pose this bound is reduced by the motion of
//! one body in the frame of the other, which is at most the largest displacement of the body's bounding sphere. Earlier
//! witness points give an upper bound on the distance. For a pair that stays near, a front is kept: the pairs of
//! elements that can contain the nearest points.
//!
//! This changes no exact result: the distance found depends neither on the search limit, as long as the limit is not
//! smaller, nor on the order in which elements are visited. (The common point of touching bodies does depend on them.
//! In reports without a tolerance it comes from a separate search; within a tolerance, it is of the elements that touched in
//! an earlier state, as long as they do.)

mod tolerance;

use clearance_geometry::PointPair;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_proximity::{Effort, ElementPair, Front, FrontLimits, Scratch, Separation};

use super::near_points::hardly_less_than;
use super::posed_pair::{PosedPair, RoughDistance};

/// Distance (m) beyond the requested limit up to which a pair is searched, so that the result lasts for some further
/// states.
const LOOK_AHEAD: f64 = 0.03;

/// Margin (m) beyond the nearest triangles within which other triangles are kept, since they may become the nearest.
const FRONT_MARGIN: f64 = 0.015;

/// Number of states for which a front must last to be worth its cost.
const LEAST_SERVED: u32 = 8;

/// Maximum pause, in states, before a front is collected again where this was never worth its cost.
const LONGEST_PAUSE: u32 = 1024;

/// Memory of a pair; distances are between the bodies, without padding.
#[derive(Clone, Debug)]
pub struct PairMemory {
    pose_ab: MatrixPose,
    /// Lower bound (m) on the distance at that pose.
    lower: f64,
    /// The result at that pose, if it was searched.
    found: Option<Separation>,
    /// Points of the bodies that were near each other at that pose.
    near_points: Option<PointPair>,
    /// Elements that touched in the last state.
    contact: Option<ElementPair>,
    /// Remaining tolerance (m) at the last state, and whether it will probably not last for the next state.
    tolerance_left: f64,
    is_due: bool,
    front: Front,
    /// Number of states that the front has served.
    served: u32,
    /// States until the next front is collected, and the length of the last such pause.
    front_pause: u32,
    last_front_pause: u32,
    /// Cost of searches since the last front was collected, and the cost of collecting it.
    search_cost: u64,
    collection_cost: u64,
    /// True if a front is to be collected in the idle time until the next state.
    front_is_requested: bool,
    /// States until the exact distance is tried again, and the length of the last such pause.
    exact_pause: u32,
    last_exact_pause: u32,
}

impl PairMemory {
    /// Memory of a search at the pair's pose up to `limit` (m).
    fn new(pair: &PosedPair, limit: f64, found: Option<Separation>) -> Self {
        let lower = found.map_or(limit, |f| f.distance);
        let near_points = found.map(|f| f.witness_points);
        Self {
            pose_ab: pair.pose_ab,
            lower,
            found,
            near_points,
            contact: None,
            tolerance_left: f64::INFINITY,
            is_due: false,
            front: Front::default(),
            served: 0,
            front_pause: 0,
            last_front_pause: LEAST_SERVED,
            search_cost: 0,
            collection_cost: 0,
            front_is_requested: false,
            exact_pause: 0,
            last_exact_pause: 0,
        }
    }

    /// True if the exact distance, which cost too much the last times, is to be tried again; called once per state.
    pub fn attempts_exact_distance(&mut self) -> bool {
        let tries = self.exact_pause == 0;
        self.exact_pause = self.exact_pause.saturating_sub(1);
        tries
    }

    /// Records bounds within a tolerance, after the exact distance cost too much. The exact distance is tried again
    /// after a pause; each pause is twice as long as the last.
    fn record_bounds_only(&mut self, pair: &PosedPair, found: &RoughDistance) {
        self.renew(pair, found.lower, None);
        self.near_points = Some(found.upper.witness_points);
        (self.tolerance_left, self.is_due) = (f64::INFINITY, false);
        self.last_exact_pause = (2 * self.last_exact_pause).clamp(1, LONGEST_PAUSE);
        self.exact_pause = self.last_exact_pause;
    }

    /// As [`Self::new`], but keeps the front, and keeps the earlier near points where no nearer ones were found.
    fn renew(&mut self, pair: &PosedPair, limit: f64, found: Option<Separation>) {
        let near = found.or_else(|| self.near_points_at(&pair.pose_ab));
        self.near_points = near.map(|near| near.witness_points);
        self.pose_ab = pair.pose_ab;
        self.lower = found.map_or(limit, |f| f.distance);
        self.found = found;
    }

    /// Discards a front that did not suffice. If it served few states, later fronts would not last either: bodies move
    /// fast, or large parts of them are about equally near. Then the next front is collected after a pause; each pause
    /// is twice as long as the last.
    fn drop_front(&mut self) {
        if !self.front.is_collected() {
            return;
        }
        self.front.clear();
        self.last_front_pause = if self.served < LEAST_SERVED {
            (2 * self.last_front_pause).min(LONGEST_PAUSE)
        } else {
            LEAST_SERVED
        };
        self.front_pause = if self.served < LEAST_SERVED { self.last_front_pause } else { 0 };
    }

    /// Requests a front to be collected before the next state, unless the last ones were useless, or searches since
    /// then have cost less than collecting the last front.
    fn request_front(&mut self, pair: &PosedPair, effort: &Effort, scratch: &mut Scratch) {
        if self.front_is_requested {
            // there was no idle time
            if effort.exact_cost == 0 {
                self.collect_requested(pair, u64::MAX, scratch);
            }
        } else if self.front_pause > 0 {
            self.front_pause -= 1;
        } else {
            self.front_is_requested = self.search_cost >= self.collection_cost;
        }
    }

    /// Collects a requested front, if there is one, at the pose where the pair was found, unless it costs more than
    /// `most`.
    fn collect_requested(&mut self, pair: &PosedPair, most: u64, scratch: &mut Scratch) {
        let found = self.found.filter(|_| self.front_is_requested && self.pose_ab == pair.pose_ab);
        let Some(found) = found else { return };
        let before = scratch.work.cost();
        let limits = FrontLimits { beyond: found.distance + FRONT_MARGIN, most_work: most };
        self.front.collect(pair.posed_bodies(), &found, limits, scratch);
        self.collection_cost = scratch.work.cost() - before;
        (self.search_cost, self.served, self.front_is_requested) = (0, 0, false);
    }

    /// True if the idle time until the next state should be spent on this pair.
    pub fn is_due(&self) -> bool {
        self.is_due || self.front_is_requested
    }

    /// Lower bound (m) on the bodies' distance at another pose, from the motion of either body in the frame of the
    /// other.
    pub fn lower_at(&self, pair: &PosedPair) -> f64 {
        self.lower - pair.displacement_to(&self.pose_ab) - CONTACT_DISTANCE
    }

    /// Whether elements are known that touched in the last state.
    pub fn touched(&self) -> bool {
        self.contact.is_some()
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

    /// Near points of the bodies from which a search may start; `None` if the bodies are proven farther apart than
    /// `limit` (m), which is recorded.
    fn near_points_within(
        &mut self,
        limit: f64,
        pair: &PosedPair,
        scratch: &mut Scratch,
    ) -> Option<Separation> {
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

/// A pair in one state, with the memory of earlier states.
pub struct RememberedPair<'m, 'c> {
    pub pair: &'m PosedPair<'c>,
    pub memory: &'m mut Option<PairMemory>,
}

impl RememberedPair<'_, '_> {
    /// Prepares the next state in the idle time before it, at the present pose; a front may cost as much as `most`.
    pub fn prepare(&mut self, limit: f64, effort: &Effort, most: u64, scratch: &mut Scratch) {
        if let Some(known) = self.memory.as_mut().filter(|_| most > 0) {
            known.collect_requested(self.pair, most, scratch);
        }
        if !effort.is_exact() && self.memory.as_ref().is_some_and(|known| known.is_due) {
            let effort = &Effort { exact_cost: 0, ..*effort };
            self.renew_bounds(limit, effort, scratch);
        }
    }

    /// As [`PosedPair::touches`], using the memory.
    pub fn touches(&mut self, scratch: &mut Scratch) -> bool {
        let padding = self.pair.info.padding;
        match &*self.memory {
            Some(known) if known.lower_at(self.pair) > padding => return false,
            // a pair that touched probably still touches, and a search beyond the padding would be useless
            Some(known) if known.lower > padding => {}
            _ => {
                let touches = self.pair.touches(scratch);
                if touches || self.memory.is_none() {
                    let limit = if touches { 0.0 } else { padding };
                    *self.memory = Some(PairMemory::new(self.pair, limit, None));
                    return touches;
                }
            }
        }
        let found = self.separation(padding, 0, scratch);
        found.is_some_and(|found| found.distance <= padding)
    }

    /// The separation of the elements that touched in the last state, if they still touch.
    pub fn still_touches(&mut self, scratch: &mut Scratch) -> Option<Separation> {
        let known = self.memory.as_mut()?;
        let found = self.pair.elements_touch(known.contact?, scratch);
        if found.is_none() {
            known.contact = None;
        }
        found
    }

    /// As [`PosedPair::contact_or_bound`], using the memory. Elements that touch are kept for [`Self::still_touches`].
    pub fn contact_or_bound(&mut self, near: f64, scratch: &mut Scratch) -> Result<Separation, f64> {
        let pair = self.pair;
        let memory = self.memory.get_or_insert_with(|| PairMemory::new(pair, f64::NEG_INFINITY, None));
        let known = memory.lower_at(pair);
        if known > pair.info.padding {
            return Err(known);
        }
        let found = pair.contact_or_bound(near, scratch);
        memory.contact = found.ok().and_then(|(_, elements)| elements);
        memory.renew(pair, found.err().unwrap_or(0.0), None);
        found.map(|(contact, _)| contact)
    }

    /// As [`PosedPair::separation`], using the memory; distances are exact until the state has cost `exact_cost`, if
    /// not 0.
    pub fn separation(&mut self, limit: f64, exact_cost: u64, scratch: &mut Scratch) -> Option<Separation> {
        let exactly = Effort { exact_cost, ..Effort::default() };
        let found = self.separation_or_bounds(limit, &exactly, scratch);
        // without tolerances all distances are exact
        found.unwrap_or_else(|_| self.pair.separation(limit, scratch))
    }

    /// As [`PosedPair::separation_or_bounds`], using the memory.
    pub fn separation_or_bounds(
        &mut self,
        limit: f64,
        effort: &Effort,
        scratch: &mut Scratch,
    ) -> Result<Option<Separation>, RoughDistance> {
        let pair = self.pair;
        let limit = limit.greater(CONTACT_DISTANCE);
        let Some(known) = &mut *self.memory else {
            let found = pair.separation_or_bounds(limit, effort, scratch);
            let known = self.memory.insert(PairMemory::new(pair, limit, found.ok().flatten()));
            return found.inspect_err(|roughly| known.record_bounds_only(pair, roughly));
        };
        if known.lower_at(pair) > limit {
            return Ok(None);
        }
        if known.pose_ab == pair.pose_ab
            && let Some(found) = known.found
        {
            return Ok((found.distance <= limit).then_some(found));
        }
        if let Some(found) = known.front.distance(pair.posed_bodies(), limit, scratch) {
            known.renew(pair, limit, found);
            known.served = known.served.saturating_add(1);
            return Ok(found);
        }
        known.drop_front();
        let before = scratch.work.cost();
        let Some(near) = known.near_points_within(limit, pair, scratch) else { return Ok(None) };
        let found = match pair.separation_below_or_bounds(&near, hardly_less_than(&near), effort, scratch) {
            Ok(None) => pair.separation_or_bounds(limit, effort, scratch),
            found => found,
        };
        let found = found.inspect_err(|roughly| known.record_bounds_only(pair, roughly))?;
        known.renew(pair, limit, found);
        known.last_exact_pause = 0;
        known.search_cost += scratch.work.cost() - before;
        let Some(found) = found.filter(|found| found.distance <= limit) else { return Ok(None) };
        if found.distance > 0.0 {
            known.request_front(pair, effort, scratch);
        } else {
            known.front_is_requested = false;
        }
        Ok(Some(found))
    }
}
