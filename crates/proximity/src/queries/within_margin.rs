//! Margin query: do two bodies come within a margin of each other?

use std::time::Instant;

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose};

use super::collide::collide;
use super::distance::DistanceBounds;
use crate::body::{BodyPair, CollisionBody, Piece};
use crate::narrow_phase::Separation;
use crate::search::{Effort, Goal, Scratch, SearchedPieces, search, search_pieces};

/// A separation of at most `margin` (m, not negative), not always the least; or `None` if the bodies were proven farther
/// apart.
#[must_use]
#[inline]
pub fn within_margin(
    a: &CollisionBody,
    b: &CollisionBody,
    pose_ab: impl Into<MatrixPose>,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<Separation> {
    let pose_ab = pose_ab.into();
    if margin <= 0.0 {
        return collide(a, b, pose_ab, scratch).map(Separation::touching_at);
    }
    first_within(BodyPair { a, b, pose_ab: &pose_ab }, margin, scratch)
}

fn first_within(bodies: BodyPair, margin: f64, scratch: &mut Scratch) -> Option<Separation> {
    search::<false>(bodies, Goal { limit: margin, enough: margin, ..Goal::EXACT }, scratch).best
}

/// As [`within_margin`], of a and some pieces of b.
#[must_use]
pub fn pieces_within_margin(
    bodies: BodyPair,
    pieces: &[Piece],
    margin: f64,
    scratch: &mut Scratch,
) -> Option<Separation> {
    let pieces = SearchedPieces::new(pieces);
    if margin <= 0.0 {
        return search_pieces::<true>(bodies, pieces, Goal::CONTACT, scratch).best;
    }
    let goal = Goal { limit: margin, enough: margin, ..Goal::EXACT };
    search_pieces::<false>(bodies, pieces, goal, scratch).best
}

/// As [`within_margin`], for a limited time. If something within `margin` was found, it is `upper`; otherwise the bodies are proven
/// farther apart, unless `interrupted`.
#[must_use]
pub fn margin_bounds(
    bodies: BodyPair,
    margin: f64,
    deadline: Option<Instant>,
    scratch: &mut Scratch,
) -> DistanceBounds {
    let margin = margin.greater(CONTACT_DISTANCE);
    let effort = Effort { deadline, ..Effort::default() };
    let goal = Goal { limit: margin, enough: margin, effort, ..Goal::EXACT };
    let found = search::<false>(bodies, goal, scratch);
    let lower = if found.best.is_some() { 0.0 } else { margin.lesser(found.unseen) };
    let interrupted = found.best.is_none() && found.unseen.is_finite();
    DistanceBounds { lower, upper: found.best, interrupted }
}
