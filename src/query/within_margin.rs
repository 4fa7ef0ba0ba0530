//! Do two bodies come within a margin of each other?

use super::body::CollisionBody;
use super::collide;
use super::element_pair::Separation;
use super::scratch::Scratch;
use super::search::{Goal, search};
use crate::bounding_volume::BoundingVolume;
use crate::math::MatrixPose;

/// A separation of at most `margin` (m, not negative), not always the least; or `None` if the bodies were proven farther
/// apart.
#[must_use]
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
