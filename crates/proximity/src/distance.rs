//! Distance query: how far are two bodies apart?

use std::time::Instant;

use clearance_geometry::math::{Extremes, MatrixPose};

use super::body::CollisionBody;
use super::element_pair::Separation;
use super::scratch::Scratch;
use super::search::{Goal, search};
use super::work::Work;
use crate::bounding_volume::BoundingVolume;

/// Least distance of two bodies and their nearest points, or `None` if it was proven larger than `limit` (m).
///
/// Descends both trees at once, the nearer children first (Larsen, Gottschalk, Lin & Manocha 1999).
#[must_use]
#[inline]
pub fn distance<B: BoundingVolume>(
    a: &CollisionBody<B>,
    b: &CollisionBody<B>,
    pose_ab: impl Into<MatrixPose>,
    limit: f64,
    scratch: &mut Scratch,
) -> Option<Separation> {
    let goal = Goal { limit, ..Goal::EXACT };
    search::<B, false>((a, b), &pose_ab.into(), goal, scratch).best
}

/// As [`distance`], with tolerances or a deadline: returns bounds.
#[must_use]
#[inline]
pub fn distance_bounds<B: BoundingVolume>(
    a: &CollisionBody<B>,
    b: &CollisionBody<B>,
    pose_ab: impl Into<MatrixPose>,
    limit: f64,
    effort: &Effort,
    scratch: &mut Scratch,
) -> DistanceBounds {
    bounds((a, b), &pose_ab.into(), Goal { limit, effort: *effort, ..Goal::EXACT }, scratch)
}

/// As [`distance_bounds`], where points of the bodies are known to be at most `reached` (m) apart. If the search stops before anything
/// nearer is found, the lower bound is within the tolerance of `reached`, and there is no upper bound.
#[must_use]
#[inline]
pub fn distance_bounds_below(
    bodies: (&CollisionBody, &CollisionBody),
    pose_ab: &MatrixPose,
    reached: f64,
    effort: &Effort,
    scratch: &mut Scratch,
) -> DistanceBounds {
    let goal = Goal { limit: reached, is_reached: true, effort: *effort, ..Goal::EXACT };
    bounds(bodies, pose_ab, goal, scratch)
}

fn bounds<B: BoundingVolume>(
    bodies: (&CollisionBody<B>, &CollisionBody<B>),
    pose_ab: &MatrixPose,
    goal: Goal,
    scratch: &mut Scratch,
) -> DistanceBounds {
    let found = search::<B, false>(bodies, pose_ab, goal, scratch);
    let certain = |upper: f64| goal.effort.lower_after(&scratch.work, upper);
    let seen = match found.best {
        Some(best) => certain(best.distance).greater(0.0),
        None if goal.is_reached => certain(goal.limit).greater(0.0),
        None => goal.limit,
    };
    DistanceBounds {
        lower: seen.lesser(found.unseen),
        upper: found.best,
        interrupted: found.unseen.is_finite(),
    }
}

/// Search options: tolerances and time limit of a distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Allowed relative error by which the result may be too large (relative to the bodies' distance, where a padding is subtracted).
    pub relative_tolerance: f64,
    /// Allowed absolute error (m); the larger of the two applies.
    pub absolute_tolerance: f64,
    /// Distances up to this (m) are exact nevertheless.
    pub exact_within: f64,
    /// The distances of a state are exact until it has cost this much ([`Work::cost`]).
    pub exact_cost: u64,
    /// Time at which the search stops with its results so far.
    pub deadline: Option<Instant>,
}

impl Effort {
    /// True if the result must be exact, without a time limit.
    #[must_use]
    #[inline]
    pub fn is_exact(&self) -> bool {
        let is_tolerant = self.relative_tolerance > 0.0 || self.absolute_tolerance > 0.0;
        !is_tolerant && self.deadline.is_none()
    }

    /// Whether the deadline has passed.
    #[must_use]
    #[inline]
    pub fn is_over(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Lower bound on a distance that is reported as `upper`; tolerances below zero count as zero.
    #[must_use]
    #[inline]
    pub fn lower(&self, upper: f64) -> f64 {
        let within = upper - self.absolute_tolerance.greater(self.relative_tolerance * upper).greater(0.0);
        if self.exact_within > 0.0 { within.greater(self.exact_within.lesser(upper)) } else { within }
    }

    /// As [`Self::lower`], after the given amount of work.
    #[inline]
    pub fn lower_after(&self, work: &Work, upper: f64) -> f64 {
        if self.exact_cost > 0 && work.cost() < self.exact_cost { upper } else { self.lower(upper) }
    }
}

/// Bounds on a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceBounds {
    /// Lower bound (m); infinite only if the bodies are infinitely far apart.
    pub lower: f64,
    /// Points of the bodies; their distance is an upper bound. `None` if none were found within the limit.
    pub upper: Option<Separation>,
    /// True if the deadline passed before the tolerance was reached.
    pub interrupted: bool,
}
