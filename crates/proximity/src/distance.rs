//! How far are two bodies apart?

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

/// As [`distance`], but satisfied with less than the whole truth: what is certain after some effort.
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

/// As [`distance_bounds`], where points of the bodies are known to be no farther apart than `reached` (m): when the effort is over before
/// anything nearer is found, what is certain is within the tolerance of that, and there is no upper bound.
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

/// How exact a distance has to be, and for how long it may be looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// The answer may be too large by this share of itself (of the bodies' distance, where a padding is taken off).
    pub relative_tolerance: f64,
    /// Or by this much (m).
    pub absolute_tolerance: f64,
    /// Distances up to this (m) are told exactly all the same.
    pub exact_within: f64,
    /// Until a state has cost this much ([`Work::cost`]), its distances are told exactly all the same.
    pub exact_cost: u64,
    /// When to stop with what is known so far.
    pub deadline: Option<Instant>,
}

impl Effort {
    /// Whether nothing less than the exact answer is asked for, however long it takes.
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

    /// What a distance may really be when it is told as `upper`; tolerances below zero count as zero.
    #[must_use]
    #[inline]
    pub fn lower(&self, upper: f64) -> f64 {
        let within = upper - self.absolute_tolerance.greater(self.relative_tolerance * upper).greater(0.0);
        if self.exact_within > 0.0 { within.greater(self.exact_within.lesser(upper)) } else { within }
    }

    /// As [`Self::lower`], after so much work.
    #[inline]
    pub fn lower_after(&self, work: &Work, upper: f64) -> f64 {
        if self.exact_cost > 0 && work.cost() < self.exact_cost { upper } else { self.lower(upper) }
    }
}

/// What is certain about a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceBounds {
    /// The distance is not less than this (m); infinite only if the bodies are infinitely apart.
    pub lower: f64,
    /// Points of the bodies that are this far apart: the distance is not more. `None` if none within the limit was found.
    pub upper: Option<Separation>,
    /// Whether the deadline came before the tolerance was reached.
    pub interrupted: bool,
}
