//! Outlines of bounding volumes for visualisation only: a box, a ball, or the triangles of a convex surface.

use clearance_geometry::math::{Point, Vector};

/// A volume in the frame that it was fitted in.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// A box along the axes.
    Box {
        /// Centre (m).
        centre: Point,
        /// Half extents (m).
        half_extents: Vector,
    },
    /// A ball.
    Ball {
        /// Centre (m).
        centre: Point,
        /// Radius (m).
        radius: f64,
    },
    /// A convex surface.
    Triangles(Vec<[Point; 3]>),
}

/// Number of triangles along an edge of an octant.
const FINENESS: u8 = 3;

/// Triangles between points of a convex surface, one for each direction: the farthest along it, or that on the ray from a point inside.
/// Directions are those of an octahedron, each face of it split into nine triangles.
pub(super) fn convex_outline(at: impl Fn(&Vector) -> Vector) -> Vec<[Point; 3]> {
    let mut triangles = Vec::new();
    for octant in 0..8 {
        let sign = |bit: u8| if octant & bit == 0 { 1.0 } else { -1.0 };
        let signs = Vector::new(sign(1), sign(2), sign(4));
        let point = |i: u8, j: u8| {
            let direction = Vector::new(f64::from(i), f64::from(j), f64::from(FINENESS - i - j));
            Point::from(at(&direction.component_mul(&signs).normalize()))
        };
        let mut add = |corners: [Point; 3]| {
            let [p, q, r] = corners;
            // counter-clockwise, seen from outside, in every octant
            triangles.push(if signs.product() > 0.0 { [p, q, r] } else { [p, r, q] });
        };
        for i in 0..FINENESS {
            for j in 0..FINENESS - i {
                add([point(i, j), point(i + 1, j), point(i, j + 1)]);
                if i + j + 1 < FINENESS {
                    add([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
                }
            }
        }
    }
    triangles
}
