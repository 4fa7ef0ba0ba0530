//! Support faces of convex solids: the face turned most towards a direction, where another solid may lie flat.

use clearance_geometry::math::{Extremes, Point, Vector};

use crate::elements::{CoreShape, RoundedShape};
use crate::penetration_depth::{ConvexSolid, Hull};

/// Number of points on the rim of a disc.
const RIM: u32 = 8;

/// Distance from the plane of a face up to which corners belong to the face, relative to the size of the solid: the rounding of
/// coordinates in 32 bits.
const COPLANAR: f64 = 1e-6;

impl ConvexSolid {
    /// Points of the face that faces `direction` (unit length) most, in the frame of the body: the corners of a flat face, points of the
    /// rim of a disc, the ends of a line on a round side, or one point. Their convex hull is inside the solid, and the farthest point in this
    /// direction is one of them.
    pub(super) fn support_face(&self, direction: &Vector) -> Vec<Point> {
        match self {
            Self::Primitive(rounded) => rounded.support_face(direction),
            Self::Hull(hull) => hull.support_face(direction),
        }
    }
}

impl Hull {
    fn support_face(&self, direction: &Vector) -> Vec<Point> {
        let faces = self.faces().iter();
        let facing = faces.max_by(|a, b| a.normal.dot(direction).total_cmp(&b.normal.dot(direction)));
        let Some(face) = facing else { return Vec::new() };
        let height = |p: &Point| face.normal.dot(&p.coords) - face.offset;
        let lowest = self.vertices().iter().map(height).fold(0.0, f64::lesser);
        self.vertices().iter().filter(|p| height(p) >= COPLANAR * lowest).copied().collect()
    }
}

impl RoundedShape {
    fn support_face(&self, direction: &Vector) -> Vec<Point> {
        let n = self.pose.rotation.tr_mul(direction);
        let out = n * self.radius;
        let of_core: Vec<Point> = match self.core {
            CoreShape::Point => vec![Point::origin()],
            CoreShape::Segment(_) if n.z.abs() > n.x.hypot(n.y) => vec![self.core.support(&n)],
            CoreShape::Segment(half_length) => CoreShape::segment(half_length).into(),
            CoreShape::Triangle(t) => t.corners().into(),
            CoreShape::Cuboid(half) => face_of_cuboid(&half, &n).into(),
            CoreShape::Cylinder { radius, half_length } => {
                let (u, across) = sideways(&n);
                if n.z.abs() >= across {
                    rim(&u, radius, half_length.copysign(n.z))
                } else {
                    CoreShape::segment(half_length).map(|p| p + u * radius).into()
                }
            }
            CoreShape::Cone { radius, half_length } => {
                let (u, across) = sideways(&n);
                let slant = (2.0 * half_length).hypot(radius);
                if -n.z * slant >= 2.0 * half_length * across + radius * n.z {
                    rim(&u, radius, -half_length)
                } else {
                    let [low, apex] = CoreShape::segment(half_length);
                    vec![low + u * radius, apex]
                }
            }
        };
        of_core.into_iter().map(|p| &self.pose * (p + out)).collect()
    }
}

/// The unit vector across the z axis towards `n`, and how far `n` points there.
fn sideways(n: &Vector) -> (Vector, f64) {
    let across = n.x.hypot(n.y);
    let u = if across > 1e-9 { Vector::new(n.x / across, n.y / across, 0.0) } else { Vector::x() };
    (u, across)
}

fn face_of_cuboid(half: &Vector, n: &Vector) -> [Point; 4] {
    let (i, j, k) = match n.iamax() {
        0 => (0, 1, 2),
        1 => (1, 2, 0),
        _ => (2, 0, 1),
    };
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[u, v]| {
        let mut corner = Point::origin();
        (corner[i], corner[j], corner[k]) = (half[i].copysign(n[i]), u * half[j], v * half[k]);
        corner
    })
}

/// Points of a circle around the z axis; the first is towards the unit vector `u`.
fn rim(u: &Vector, radius: f64, z: f64) -> Vec<Point> {
    let v = Vector::z().cross(u);
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(RIM);
    let at = |angle: f64| Point::from((u * angle.cos() + v * angle.sin()) * radius + Vector::z() * z);
    (0..RIM).map(|i| at(angle(i))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::Primitive;
    use clearance_geometry::testing::Random;

    #[test]
    fn points_of_a_face_are_on_the_surface_and_the_farthest_is_among_them() {
        let mut random = Random::new(4);
        for _ in 0..2_000 {
            let primitive = random.primitive();
            let solid = ConvexSolid::primitive(primitive, random.pose(1.0));
            let n = random.direction();
            let face = solid.support_face(&n);
            assert!(!face.is_empty());
            let highest = {
                use crate::penetration_depth::SupportMap;
                solid.support(&n).coords.dot(&n) + solid.radius()
            };
            let heights = face.iter().map(|p| p.coords.dot(&n));
            let top = heights.fold(f64::NEG_INFINITY, f64::greater);
            assert!(top <= highest + 1e-12 && top >= highest - 1e-9, "{primitive:?} {n:?} {top} {highest}");
            for p in &face {
                let nearer = p + (Point::from(solid_centre(&solid)) - p) * 1e-9;
                // the ends of a tilted capsule are as deep as the tilt makes them
                let most =
                    if let Primitive::Capsule { radius, .. } = primitive { 0.3 * radius } else { 1e-6 };
                assert!(solid.inner_radius(&nearer).is_some_and(|r| r < most), "{primitive:?} {n:?} {p:?}");
            }
        }
    }

    fn solid_centre(solid: &ConvexSolid) -> Vector {
        match solid {
            ConvexSolid::Primitive(rounded) => rounded.pose.translation,
            ConvexSolid::Hull(_) => Vector::zeros(),
        }
    }
}
