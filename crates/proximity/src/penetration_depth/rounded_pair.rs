//! Penetration depth of balls and capsules in other primitives, by closed formulas. The polytope of support points
//! would be flat there, or have round corners.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};

use super::expanding_polytope::ConvexDepth;
use crate::elements::{CoreShape, RoundedShape};
use crate::narrow_phase::core_nearest_points;

/// Rounding error of a closed formula, relative to the coordinates.
const ROUNDING: f64 = 1e-14;

/// Depth of two overlapping primitives, each a core swept by a sphere: exact if the cores are apart, if one of them is a point, or if both
/// are segments. `None` for others.
pub(super) fn depth_of_rounded(
    a: &RoundedShape,
    b: &RoundedShape,
    pose_ab: &MatrixPose,
) -> Option<ConvexDepth> {
    let pose_cores = a.pose.relative(&pose_ab.compose(&b.pose));
    let [p, q] = core_nearest_points(&a.core, &b.core, &pose_cores, f64::INFINITY)?;
    let apart = nalgebra::distance(&p, &q);
    if apart > CONTACT_DISTANCE {
        return Some(swept(a, b, [p, q], (q - p) / apart, -apart));
    }
    let pose = Pose::from(&pose_cores);
    let (depth, [p, q]) = match (&a.core, &b.core) {
        (core, CoreShape::Point) => {
            let inside = Point::from(pose_cores.translation);
            core.depth(&inside).map_or((0.0, [p, q]), |(depth, surface)| (depth, [surface, inside]))
        }
        (CoreShape::Point, core) => {
            let found = core.depth(&pose.inverse_transform_point(&Point::origin()));
            found.map_or((0.0, [p, q]), |(depth, surface)| (depth, [Point::origin(), pose * surface]))
        }
        (CoreShape::Segment(_), CoreShape::Segment(_)) => (0.0, [p, q]),
        _ => return None,
    };
    let out = (p - q).try_normalize(CONTACT_DISTANCE);
    Some(swept(a, b, [p, q], out.unwrap_or_else(|| normal_of_crossing(&a.core, &b.core, &pose)), depth))
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

/// Result for points and a direction in the frame of a's core: the points are moved out to the surfaces.
fn swept(a: &RoundedShape, b: &RoundedShape, [p, q]: [Point; 2], out: Vector, depth: f64) -> ConvexDepth {
    let depth = depth + a.radius + b.radius;
    let rounding = ROUNDING * (p.coords.amax() + q.coords.amax() + a.pose.translation.amax() + depth.abs());
    ConvexDepth {
        lower: depth - rounding,
        upper: depth + rounding,
        direction: a.pose.rotation * out,
        witness_points: [&a.pose * (p + out * a.radius), &a.pose * (q - out * b.radius)],
    }
}
