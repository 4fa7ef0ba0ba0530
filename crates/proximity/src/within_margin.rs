//! Margin query: do two bodies come within a margin of each other?

use std::time::Instant;

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose};

use super::body::CollisionBody;
use super::collide;
use super::distance::{DistanceBounds, Effort};
use super::element_pair::Separation;
use super::piece::Piece;
use super::scratch::Scratch;
use super::search::{Goal, Pieces, search, search_pieces};
use crate::bounding_volume::{BoundingVolume, Obb};

/// A separation of at most `margin` (m, not negative), not always the least; or `None` if the bodies were proven farther
/// apart.
#[must_use]
#[inline]
pub fn within_margin<B: BoundingVolume>(
    a: &CollisionBody<B>,
    b: &CollisionBody<B>,
    pose_ab: impl Into<MatrixPose>,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<Separation> {
    if margin <= 0.0 {
        return collide(a, b, pose_ab, scratch).map(Separation::touching_at);
    }
    let goal = Goal { limit: margin, enough: margin, ..Goal::EXACT };
    search::<B, false>((a, b), &pose_ab.into(), goal, scratch).best
}

/// As [`within_margin`], of a and some pieces of b.
#[must_use]
#[inline]
pub fn pieces_within_margin(
    a: &CollisionBody,
    (b, pieces): (&CollisionBody, &[Piece]),
    pose_ab: impl Into<MatrixPose>,
    margin: f64,
    scratch: &mut Scratch,
) -> Option<Separation> {
    let pieces = Pieces::Some(pieces);
    if margin <= 0.0 {
        return search_pieces::<Obb, true>((a, b), pieces, &pose_ab.into(), Goal::CONTACT, scratch).best;
    }
    let goal = Goal { limit: margin, enough: margin, ..Goal::EXACT };
    search_pieces::<Obb, false>((a, b), pieces, &pose_ab.into(), goal, scratch).best
}

/// As [`within_margin`], for a limited time. If something within `margin` was found, it is `upper`; otherwise the bodies are proven
/// farther apart, unless `interrupted`.
#[must_use]
#[inline]
pub fn margin_bounds<B: BoundingVolume>(
    a: &CollisionBody<B>,
    b: &CollisionBody<B>,
    pose_ab: impl Into<MatrixPose>,
    margin: f64,
    deadline: Option<Instant>,
    scratch: &mut Scratch,
) -> DistanceBounds {
    let margin = margin.greater(CONTACT_DISTANCE);
    let effort = Effort { deadline, ..Effort::default() };
    let found = search::<B, false>(
        (a, b),
        &pose_ab.into(),
        Goal { limit: margin, enough: margin, effort, ..Goal::EXACT },
        scratch,
    );
    let lower = if found.best.is_some() { 0.0 } else { margin.lesser(found.unseen) };
    let interrupted = found.best.is_none() && found.unseen.is_finite();
    DistanceBounds { lower, upper: found.best, interrupted }
}
