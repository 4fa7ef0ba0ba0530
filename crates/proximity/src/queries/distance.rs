//! Distance query: how far are two bodies apart, exactly or as lower and upper bounds?

use clearance_geometry::math::{Extremes, MatrixPose};

use crate::body::{BodyPair, CollisionBody};
use crate::narrow_phase::Separation;
use crate::search::{Effort, Goal, Scratch, search};

/// Least distance of two bodies and their nearest points, or `None` if it was proven larger than `limit` (m).
///
/// Descends both trees at once, the nearer children first (Larsen, Gottschalk, Lin & Manocha 1999).
#[must_use]
#[inline]
pub fn distance(
    a: &CollisionBody,
    b: &CollisionBody,
    pose_ab: impl Into<MatrixPose>,
    limit: f64,
    scratch: &mut Scratch,
) -> Option<Separation> {
    nearest(BodyPair { a, b, pose_ab: &pose_ab.into() }, limit, scratch)
}

fn nearest(bodies: BodyPair, limit: f64, scratch: &mut Scratch) -> Option<Separation> {
    search::<false>(bodies, Goal { limit, ..Goal::EXACT }, scratch).best
}

/// As [`distance`], with tolerances or a deadline: returns bounds.
#[must_use]
pub fn distance_bounds(
    bodies: BodyPair,
    limit: f64,
    effort: &Effort,
    scratch: &mut Scratch,
) -> DistanceBounds {
    bounds(bodies, Goal { limit, effort: *effort, ..Goal::EXACT }, scratch)
}

/// As [`distance_bounds`], where points of the bodies are known to be at most `reached` (m) apart. If the search stops before anything
/// nearer is found, the lower bound is within the tolerance of `reached`, and there is no upper bound.
#[must_use]
pub fn distance_bounds_below(
    bodies: BodyPair,
    reached: f64,
    effort: &Effort,
    scratch: &mut Scratch,
) -> DistanceBounds {
    let goal = Goal { limit: reached, is_reached: true, effort: *effort, ..Goal::EXACT };
    bounds(bodies, goal, scratch)
}

fn bounds(bodies: BodyPair, goal: Goal, scratch: &mut Scratch) -> DistanceBounds {
    let found = search::<false>(bodies, goal, scratch);
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
