//! Signed distance of two solid primitives.

use clearance_geometry::Primitive;
use clearance_geometry::math::{MatrixPose, Pose};

use super::convex_solid::ConvexSolid;
use super::depth_of_convex;
use crate::elements::{Element, RoundedShape};
use crate::narrow_phase::{Separation, separation_within};

/// Signed distance (m) of two solid primitives, b posed in the frame of a: as [`distance`](crate::distance()) when apart; when they
/// overlap, minus the length of the shortest translation that separates them, with the witness points that come apart last.
///
/// Exact up to rounding if one is a sphere, if both are capsules, or if the cores of rounded solids are apart; otherwise by the expanding
/// polytope algorithm, within 1e-6 of the depth. For two capsules whose axes cross, the depth is the sum of their radii.
#[must_use]
#[allow(clippy::missing_panics_doc)] // nothing is beyond infinity
pub fn signed_distance(a: &Primitive, b: &Primitive, pose_ab: &Pose) -> Separation {
    let shape = |primitive: &Primitive| {
        RoundedShape::from(&Element::Primitive { primitive: *primitive, pose: Pose::identity() })
    };
    let (a, b, pose_ab) = (shape(a), shape(b), &MatrixPose::from(pose_ab));
    let found = separation_within(&a, &b, pose_ab, f64::INFINITY).expect("nothing is beyond infinity");
    if found.distance > 0.0 {
        return found;
    }
    let depth = depth_of_convex(&ConvexSolid::Primitive(a), &ConvexSolid::Primitive(b), pose_ab);
    depth.map_or(found, |depth| Separation {
        distance: -0.5 * (depth.lower + depth.upper),
        witness_points: depth.witness_points,
    })
}
