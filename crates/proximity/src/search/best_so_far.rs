//! The best result of a search so far (the incumbent of branch and bound), and the limit for better ones.

use std::time::Instant;

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, Point};

use super::goal::Goal;
use super::ties::Ties;
use super::work::Work;
use crate::elements::ElementPair;
use crate::narrow_phase::{Separation, f32_above};

/// Number of volume tests between two reads of the clock.
const TESTS_PER_READ: u64 = 256;

/// The best result of a search, and its remaining goal.
#[derive(Debug)]
pub(crate) struct BestSoFar<'w> {
    goal: Goal,
    best: Option<Separation>,
    /// Elements of the best result, where the choice among equally near ones matters.
    elements: Option<ElementPair>,
    /// Number of volume tests at which the clock is read next.
    next_read: u64,
    /// The pairs that are as near as the best, if they are collected.
    ties: Option<&'w mut Ties>,
    /// Counts the cost of the search.
    pub work: &'w mut Work,
}

impl<'w> BestSoFar<'w> {
    /// Touching elements are within any limit.
    #[inline]
    pub fn new(goal: Goal, work: &'w mut Work) -> Self {
        let goal = Goal { limit: goal.limit.greater(CONTACT_DISTANCE), ..goal };
        Self { goal, best: None, elements: None, next_read: work.volume_tests, ties: None, work }
    }

    /// Also collects the pairs of elements that are as near as the best, until something touches.
    #[inline]
    pub fn with_ties(self, ties: Option<&'w mut Ties>) -> Self {
        Self { ties, ..self }
    }

    /// Elements farther apart than this (m) no longer matter; negative infinity once none do.
    #[inline]
    pub fn bound(&self) -> f64 {
        match self.best {
            Some(best) if best.distance <= self.goal.enough => f64::NEG_INFINITY,
            Some(best) => self.tie_limit(self.goal.effort.lower_after(self.work, best.distance)),
            None if self.goal.is_reached => self.goal.effort.lower_after(self.work, self.goal.limit),
            None => self.goal.limit,
        }
    }

    /// Elements up to this distance (m) matter if the least distance is at most `reached` (m).
    #[inline]
    fn tie_limit(&self, reached: f64) -> f64 {
        self.ties.as_ref().map_or(reached, |ties| ties.limit(reached))
    }

    /// As [`Self::threshold`], if the least distance is at most `reached` (m).
    #[inline]
    pub fn threshold_below(&self, reached: f32) -> f32 {
        let below = if self.ties.is_some() { f32_above(self.tie_limit(f64::from(reached))) } else { reached };
        self.threshold().lesser(below)
    }

    /// Reduces the limit to `limit` (m).
    #[inline]
    pub fn lower_limit(&mut self, limit: f64) {
        self.goal.limit = self.goal.limit.lesser(limit).greater(CONTACT_DISTANCE);
    }

    /// [`Self::bound`], rounded up unless it is negative infinity.
    #[inline]
    pub fn threshold(&self) -> f32 {
        let bound = self.bound();
        if bound == f64::NEG_INFINITY { f32::NEG_INFINITY } else { f32_above(bound) }
    }

    /// The nearest pair of points found within the limit.
    #[inline]
    pub fn separation(&self) -> Option<Separation> {
        self.best
    }

    /// The elements of the nearest pair, where they matter.
    #[inline]
    pub fn elements(&self) -> Option<ElementPair> {
        self.elements
    }

    /// True if a common point is known.
    #[inline]
    pub fn touches(&self) -> bool {
        self.best.is_some_and(|best| best.distance == 0.0)
    }

    /// True if no other result can be better.
    #[inline]
    pub fn is_settled(&self) -> bool {
        self.bound() == f64::NEG_INFINITY
    }

    /// Keeps `found` if it is nearer than the best so far, or the first within the limit.
    #[inline]
    pub fn offer(&mut self, found: Separation) {
        if self.is_bettered_by(&found) {
            self.best = Some(found);
            self.elements = None;
        }
    }

    /// As [`Self::offer`] for two elements; of equally near ones those with the smaller identifiers are kept, so that the result does not
    /// depend on the order in which they are visited.
    #[inline]
    pub fn offer_elements(&mut self, found: Separation, elements: ElementPair) {
        let tied = self.best.is_some_and(|best| found.distance == best.distance);
        if tied && self.elements.is_some_and(|best| elements < best) || self.is_bettered_by(&found) {
            self.best = Some(found);
            self.elements = Some(elements);
        }
        if let (Some(ties), Some(best)) = (&mut self.ties, &self.best) {
            ties.offer(found, elements, best.distance);
        }
    }

    /// Keeps a common point that belongs to no elements.
    #[inline]
    pub fn touch_at(&mut self, point: Point) {
        (self.best, self.elements) = (Some(Separation::touching_at(point)), None);
    }

    fn is_bettered_by(&self, found: &Separation) -> bool {
        match self.best {
            Some(best) => found.distance < best.distance,
            None => found.distance <= self.goal.limit,
        }
    }

    /// True if any result within the limit suffices.
    #[inline]
    pub fn seeks_any(&self) -> bool {
        self.goal.enough >= self.goal.limit
    }

    /// True if the deadline has passed; the clock is read now and then.
    #[inline]
    pub fn interrupted(&mut self) -> bool {
        let Some(deadline) = self.goal.effort.deadline else { return false };
        if self.work.volume_tests < self.next_read {
            return false;
        }
        self.next_read = self.work.volume_tests + TESTS_PER_READ;
        Instant::now() >= deadline
    }
}
