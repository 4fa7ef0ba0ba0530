//! Collision query: do two bodies touch?

use clearance_geometry::math::{MatrixPose, Point};

use super::body::CollisionBody;
use super::scratch::Scratch;
use super::search::{Goal, search};
use crate::bounding_volume::BoundingVolume;

/// A common point (frame of a) of two bodies, or `None` if every pair of elements was proven apart.
///
/// Descends both trees at once, by separating axes where volumes have them (Gottschalk, Lin & Manocha 1996).
#[must_use]
#[inline]
pub fn collide<B: BoundingVolume>(
    a: &CollisionBody<B>,
    b: &CollisionBody<B>,
    pose_ab: impl Into<MatrixPose>,
    scratch: &mut Scratch,
) -> Option<Point> {
    let found = search::<B, true>((a, b), &pose_ab.into(), Goal::CONTACT, scratch);
    found.best.map(|touching| touching.witness_points[0])
}
