//! The best result of a search so far, and the limit for better ones.

use std::time::Instant;

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, Point};

use super::element::ElementNumber;
use super::element_pair::Separation;
use super::search::Goal;
use super::work::Work;

/// Number of volume tests between two reads of the clock.
const TESTS_A_LOOK: u64 = 256;

/// The best result of a search, and its remaining goal.
#[derive(Debug)]
pub(super) struct Incumbent<'w> {
    goal: Goal,
    pub best: Option<Separation>,
    /// Indices of the elements of the best result, where the choice among equally near ones matters.
    pub numbers: Option<(ElementNumber, ElementNumber)>,
    /// Number of volume tests at which the clock is read next.
    next_look: u64,
    pub work: &'w mut Work,
}

impl<'w> Incumbent<'w> {
    /// Touching elements are within any limit.
    #[inline]
    pub fn new(goal: Goal, work: &'w mut Work) -> Self {
        let goal = Goal { limit: goal.limit.greater(CONTACT_DISTANCE), ..goal };
        Self { goal, best: None, numbers: None, next_look: work.volume_tests, work }
    }

    /// Elements farther apart than this (m) no longer matter; negative infinity once none do.
    #[inline]
    pub fn bound(&self) -> f64 {
        match self.best {
            Some(best) if best.distance <= self.goal.enough => f64::NEG_INFINITY,
            Some(best) => self.goal.effort.lower_after(self.work, best.distance),
            None if self.goal.is_reached => self.goal.effort.lower_after(self.work, self.goal.limit),
            None => self.goal.limit,
        }
    }

    /// Reduces the limit to `limit` (m).
    #[inline]
    pub fn lower_limit(&mut self, limit: f64) {
        self.goal.limit = self.goal.limit.lesser(limit).greater(CONTACT_DISTANCE);
    }

    /// [`Self::bound`], rounded up unless it is negative infinity.
    #[allow(clippy::cast_possible_truncation)] // rounded up right after
    #[inline]
    pub fn threshold(&self) -> f32 {
        let bound = self.bound();
        if bound == f64::NEG_INFINITY { f32::NEG_INFINITY } else { (bound as f32).next_up() }
    }

    #[inline]
    pub fn touches(&self) -> bool {
        self.best.is_some_and(|best| best.distance == 0.0)
    }

    #[inline]
    pub fn is_settled(&self) -> bool {
        self.bound() == f64::NEG_INFINITY
    }

    /// Keeps `found` if it is nearer than the best so far, or the first within the limit.
    #[inline]
    pub fn offer(&mut self, found: Separation) {
        if self.is_bettered_by(&found) {
            self.best = Some(found);
            self.numbers = None;
        }
    }

    /// As [`Self::offer`] for two elements; of equally near ones those with the smaller indices are kept, so that the result does not
    /// depend on the order in which they are visited.
    #[inline]
    pub fn offer_numbered(&mut self, found: Separation, numbers: (ElementNumber, ElementNumber)) {
        let tied = self.best.is_some_and(|best| found.distance == best.distance);
        if tied && self.numbers.is_some_and(|best| numbers < best) || self.is_bettered_by(&found) {
            self.best = Some(found);
            self.numbers = Some(numbers);
        }
    }

    /// Keeps a common point that belongs to no elements.
    #[inline]
    pub fn touch_at(&mut self, point: Point) {
        (self.best, self.numbers) = (Some(Separation::touching_at(point)), None);
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

    #[inline]
    pub fn interrupted(&mut self) -> bool {
        let Some(deadline) = self.goal.effort.deadline else { return false };
        if self.work.volume_tests < self.next_look {
            return false;
        }
        self.next_look = self.work.volume_tests + TESTS_A_LOOK;
        Instant::now() >= deadline
    }
}
