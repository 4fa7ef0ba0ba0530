//! Collision query: a common point of two bodies, if they touch.

use clearance_geometry::math::{MatrixPose, Point};

use crate::body::{BodyPair, CollisionBody};
use crate::search::{Goal, Scratch, search};

/// A common point (frame of a) of two bodies, or `None` if every pair of elements was proven apart.
///
/// Descends both trees at once, by separating axes where volumes have them (Gottschalk, Lin & Manocha 1996).
#[must_use]
#[inline]
pub fn collide(
    a: &CollisionBody,
    b: &CollisionBody,
    pose_ab: impl Into<MatrixPose>,
    scratch: &mut Scratch,
) -> Option<Point> {
    common_point(BodyPair { a, b, pose_ab: &pose_ab.into() }, scratch)
}

fn common_point(bodies: BodyPair, scratch: &mut Scratch) -> Option<Point> {
    let found = search::<true>(bodies, Goal::CONTACT, scratch);
    found.best.map(|touching| touching.witness_points[0])
}
