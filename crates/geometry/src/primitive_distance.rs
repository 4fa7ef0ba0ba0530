//! Exact signed distances of points from primitives.

use crate::Primitive;
use crate::math::{Extremes, Point};

impl Primitive {
    /// Signed distance (m) of a point in the frame of the primitive: outside, its distance; inside, the negative distance from the surface.
    #[must_use]
    pub fn signed_distance(&self, p: &Point) -> f64 {
        let from_axis = p.x.hypot(p.y);
        match *self {
            Self::Sphere { radius } => p.coords.norm() - radius,
            Self::Capsule { radius, half_length } => {
                from_axis.hypot((p.z.abs() - half_length).greater(0.0)) - radius
            }
            Self::Box { half_extents: [x, y, z] } => of_faces([p.x.abs() - x, p.y.abs() - y, p.z.abs() - z]),
            Self::Cylinder { radius, half_length } => {
                of_faces([from_axis - radius, p.z.abs() - half_length, f64::NEG_INFINITY])
            }
            Self::Cone { radius, half_length } => of_cone(radius, half_length, from_axis, p.z),
        }
    }
}

/// Signed distance of a point with these heights (m) over orthogonal faces.
fn of_faces(heights: [f64; 3]) -> f64 {
    let squared: f64 = heights.iter().map(|h| h.greater(0.0) * h.greater(0.0)).sum();
    if squared > 0.0 {
        squared.sqrt()
    } else {
        heights.into_iter().fold(f64::NEG_INFINITY, Extremes::greater)
    }
}

/// A cone is a triangle that revolves about its height.
fn of_cone(radius: f64, half_length: f64, from_axis: f64, height: f64) -> f64 {
    let to_side = from_segment([radius, -half_length], [0.0, half_length], [from_axis, height]);
    let to_base = from_segment([0.0, -half_length], [radius, -half_length], [from_axis, height]);
    let is_under_side = from_axis * 2.0 * half_length <= radius * (half_length - height);
    let distance = to_side.lesser(to_base);
    if is_under_side && height >= -half_length { -distance } else { distance }
}

/// Distance of a point from a segment in the plane.
fn from_segment(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    let (edge, way) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let squared = edge[0] * edge[0] + edge[1] * edge[1];
    let t = if squared > 0.0 { (edge[0] * way[0] + edge[1] * way[1]) / squared } else { 0.0 };
    let t = t.greater(0.0).lesser(1.0);
    (way[0] - t * edge[0]).hypot(way[1] - t * edge[1])
}
