//! Penetration depth of two solid primitives.

use clearance_geometry::Primitive;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};

use crate::body::CollisionBody;
use crate::elements::{CoreShape, Element, RoundedShape};
use crate::narrow_phase::{Separation, core_nearest_points, penetration, separation_within};

/// Signed distance (m) of two solid primitives, b posed in the frame of a: as [`distance`](crate::distance()) when apart; when they
/// overlap, minus the least translation that separates them, with the witness points deepest in each other.
///
/// Exact if one is a sphere, or if the cores of capsules are apart; otherwise by EPA, within about 1e-6 of the size of the solids. For
/// two capsules whose axes cross, the depth is the sum of their radii.
#[must_use]
#[allow(clippy::missing_panics_doc)] // nothing is beyond infinity
#[inline]
pub fn signed_distance(a: &Primitive, b: &Primitive, pose_ab: &Pose) -> Separation {
    let core_of = |primitive: &Primitive, pose: Pose| {
        RoundedShape::from(&Element::Primitive { primitive: *primitive, pose })
    };
    signed_distance_of_cores(&core_of(a, Pose::identity()), &core_of(b, *pose_ab), pose_ab)
}

/// Deepest overlap of the solids of two bodies: [`signed_distance`] of the pair of primitives for which it is least. `None` where no
/// primitives touch; the depth of meshes is not defined.
#[must_use]
#[inline]
pub fn deepest_overlap(
    a: &CollisionBody,
    b: &CollisionBody,
    pose_ab: impl Into<MatrixPose>,
) -> Option<Separation> {
    let pose_ab = pose_ab.into();
    let (solids_of_a, solids_of_b) = (a.solids()?, b.solids()?);
    let mut deepest: Option<Separation> = None;
    for first in solids_of_a.leaves().iter().map(|leaf| &leaf.content.shape) {
        for second in solids_of_b.leaves().iter().map(|leaf| &leaf.content.shape) {
            if separation_within(first, second, &pose_ab, CONTACT_DISTANCE).is_none() {
                continue;
            }
            let pose = Pose::from(&first.pose.relative(&pose_ab.compose(&second.pose)));
            let found = signed_distance_of_cores(first, second, &pose);
            if deepest.is_none_or(|deepest| found.distance < deepest.distance) {
                let witness_points = found.witness_points.map(|p| &first.pose * p);
                deepest = Some(Separation { witness_points, ..found });
            }
        }
    }
    deepest
}

/// Signed distance of cores, each in its own frame, b posed in the frame of a.
fn signed_distance_of_cores(a: &RoundedShape, b: &RoundedShape, pose_ab: &Pose) -> Separation {
    let [p, q] = core_nearest_points(&a.core, &b.core, &pose_ab.into(), f64::INFINITY)
        .expect("nothing is beyond infinity");
    let apart = nalgebra::distance(&p, &q);
    if apart > CONTACT_DISTANCE {
        return moved_out(a, b, [p, q], (q - p) / apart, apart);
    }
    let (depth, [p, q]) = core_depth(&a.core, &b.core, pose_ab).unwrap_or((0.0, [p, q]));
    let out = ((p - q).try_normalize(CONTACT_DISTANCE))
        .unwrap_or_else(|| normal_of_crossing(&a.core, &b.core, pose_ab));
    moved_out(a, b, [p, q], out, -depth)
}

/// The direction of the shortest separation of cores without common volume: normal to both, if they are segments.
fn normal_of_crossing(a: &CoreShape, b: &CoreShape, pose_ab: &Pose) -> Vector {
    let axis_b = pose_ab * Vector::z();
    match (a, b) {
        (CoreShape::Segment(_), CoreShape::Segment(_)) => Vector::z().cross(&axis_b),
        (CoreShape::Segment(_), _) => Vector::x(),
        _ => axis_b.cross(&Vector::x()),
    }
    .try_normalize(1e-9)
    .unwrap_or_else(Vector::x)
}

/// Surface points, a radius outward from the core points: for a along `out`, for b against it.
fn moved_out(a: &RoundedShape, b: &RoundedShape, [p, q]: [Point; 2], out: Vector, apart: f64) -> Separation {
    Separation {
        distance: apart - a.radius - b.radius,
        witness_points: [p + out * a.radius, q - out * b.radius],
    }
}

/// Depth of overlapping cores, the point of a deepest in b, and the point of b deepest in a.
fn core_depth(a: &CoreShape, b: &CoreShape, pose_ab: &Pose) -> Option<(f64, [Point; 2])> {
    match (a, b) {
        (_, CoreShape::Point) => {
            let inside = Point::from(pose_ab.translation.vector);
            let (depth, surface) = a.depth(&inside)?;
            Some((depth, [surface, inside]))
        }
        (CoreShape::Point, _) => {
            let (depth, surface) = b.depth(&pose_ab.inverse_transform_point(&Point::origin()))?;
            Some((depth, [Point::origin(), pose_ab * surface]))
        }
        (CoreShape::Segment(_), CoreShape::Segment(_)) => None,
        _ => penetration(a, b, pose_ab),
    }
}
