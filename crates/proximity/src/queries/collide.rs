//! Collision query: do two bodies touch?

use clearance_geometry::math::{MatrixPose, Point};

use crate::body::{BodyPair, CollisionBody};
use crate::bounding_volume::BoundingVolume;
use crate::search::{Goal, Scratch, search};

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
    let bodies = BodyPair { a, b, pose_ab: &pose_ab.into() };
    let found = search::<B, true>(bodies, Goal::CONTACT, scratch);
    found.best.map(|touching| touching.witness_points[0])
}
