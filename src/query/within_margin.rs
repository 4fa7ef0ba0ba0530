//! Do two bodies come within a margin of each other?

use super::distance::nearest_below;
use super::element_pair::Separation;
use super::{CollisionBody, Work, collide};
use crate::math::Pose;

/// A separation of at most `margin` (m, not negative), not always the least; or `None` if the bodies were proven farther
/// apart.
#[must_use]
pub fn within_margin(
    a: &CollisionBody,
    b: &CollisionBody,
    pose_ab: &Pose,
    margin: f64,
    work: &mut Work,
) -> Option<Separation> {
    if margin <= 0.0 {
        return collide(a, b, pose_ab, work).map(Separation::touching_at);
    }
    nearest_below(a, b, pose_ab, margin, margin, work)
}
