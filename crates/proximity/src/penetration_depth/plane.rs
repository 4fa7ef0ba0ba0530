//! Penetration depth of a plane in a bounded body.

use clearance_geometry::Plane;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Vector};

use super::convex_solid::{ConvexSolid, SupportMap};
use super::expanding_polytope::ConvexDepth;
use super::solid_body::{Part, Union};

/// Rounding error of a height over a plane, relative to the coordinates.
const ROUNDING: f64 = 1e-13;

/// How far a connected part of a body reaches to both sides of a plane.
#[derive(Clone, Copy)]
struct Reach {
    lowest: PointAtHeight,
    highest: PointAtHeight,
}

/// A point, and its height (m) over the plane.
#[derive(Clone, Copy)]
struct PointAtHeight {
    point: Point,
    height: f64,
}

/// Depth of a body in a plane: the shorter of the translations to either side, without padding; negative if the body is on one side. The
/// plane may also leave into a gap between parts of the body that is wider than twice the `margin` (m). `None` for a body that is not
/// bounded.
pub(super) fn depth_in_plane(
    plane: &Plane,
    body: &Union,
    pose_pb: &MatrixPose,
    margin: f64,
) -> Option<ConvexDepth> {
    let normal = plane.normal.into_inner();
    let Reach { lowest, highest } = reach_around(reaches(plane, body, pose_pb)?, margin)?;
    let is_below_nearer = -lowest.height <= highest.height;
    let (point, depth, direction) = if is_below_nearer {
        (lowest.point, -lowest.height, normal)
    } else {
        (highest.point, highest.height, -normal)
    };
    let rounding = ROUNDING * (point.coords.amax() + plane.offset.abs());
    let on_plane = point - normal * plane.height(&point);
    Some(ConvexDepth {
        lower: depth - rounding,
        upper: depth + rounding,
        direction,
        witness_points: [on_plane, point],
    })
}

/// The heights of all connected parts; `None` if one has no end.
fn reaches(plane: &Plane, body: &Union, pose_pb: &MatrixPose) -> Option<Vec<Reach>> {
    let in_body = pose_pb.rotation.tr_mul(&plane.normal.into_inner());
    let placed = |point: Point| {
        let point = pose_pb * point;
        PointAtHeight { point, height: plane.height(&point) }
    };
    let reach = |[lowest, highest]: [Point; 2]| Reach { lowest: placed(lowest), highest: placed(highest) };
    let mut found = Vec::with_capacity(body.parts.len());
    for part in &body.parts {
        match part {
            Part::Convex(solid) => found.push(reach(ends_of_convex(solid, &in_body))),
            Part::Mesh { .. } => {}
            Part::Plane(_) => return None,
        }
    }
    found.extend(body.mesh_parts().iter().filter_map(|vertices| Some(reach(ends_of(vertices, &in_body)?))));
    Some(found)
}

fn ends_of_convex(solid: &ConvexSolid, direction: &Vector) -> [Point; 2] {
    [-direction, *direction].map(|n| solid.support(&n) + n * solid.radius())
}

/// The points that are farthest against a direction and along it.
fn ends_of(points: &[Point], direction: &Vector) -> Option<[Point; 2]> {
    let along = |p: &Point| p.coords.dot(direction);
    let lowest = points.iter().min_by(|p, q| along(p).total_cmp(&along(q)))?;
    let highest = points.iter().max_by(|p, q| along(p).total_cmp(&along(q)))?;
    Some([*lowest, *highest])
}

/// The reach of all parts among which the plane is, up to gaps on both sides in which it has room; where it already is in such a gap, that
/// of the parts on the nearer side.
fn reach_around(mut reaches: Vec<Reach>, margin: f64) -> Option<Reach> {
    reaches.sort_unstable_by(|a, b| a.lowest.height.total_cmp(&b.lowest.height));
    let widest = 2.0 * (margin + CONTACT_DISTANCE);
    let mut groups: Vec<Reach> = Vec::new();
    for reach in reaches {
        match groups.last_mut() {
            Some(group) if reach.lowest.height - group.highest.height <= widest => {
                if reach.highest.height > group.highest.height {
                    group.highest = reach.highest;
                }
            }
            _ => groups.push(reach),
        }
    }
    let distance = |reach: &Reach| reach.lowest.height.greater(-reach.highest.height);
    groups.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}
