//! Penetration depth of a plane in a bounded body.

use clearance_geometry::Plane;
use clearance_geometry::math::{Extremes, MatrixPose};

use super::expanding_polytope::ConvexDepth;
use super::solid_body::Union;

/// Rounding error of a height over a plane, relative to the coordinates.
const ROUNDING: f64 = 1e-13;

/// Depth of a body in a plane: the shorter of the translations to either side; negative if the body is on one side. `None` for a body that
/// is not bounded.
pub(super) fn depth_in_plane(plane: &Plane, body: &Union, pose_pb: &MatrixPose) -> Option<ConvexDepth> {
    let normal = plane.normal.into_inner();
    let in_body = pose_pb.rotation.tr_mul(&normal);
    let extreme = |direction: f64| {
        let mut farthest = None;
        for part in &body.parts {
            let point = pose_pb * part.farthest(&(in_body * direction))?;
            let height = direction * plane.height(&point);
            if farthest.is_none_or(|(_, highest)| height > highest) {
                farthest = Some((point, height));
            }
        }
        farthest
    };
    // how far the body reaches to either side, and the point that does
    let (above, below) = (extreme(1.0)?, extreme(-1.0)?);
    let ((point, depth), direction) = if below.1 <= above.1 { (below, normal) } else { (above, -normal) };
    let rounding = ROUNDING * (point.coords.amax() + plane.offset.abs());
    let on_plane = point - normal * plane.height(&point);
    Some(ConvexDepth {
        lower: depth - rounding,
        upper: (depth + rounding).greater(0.0),
        direction,
        witness_points: [on_plane, point],
    })
}
