//! Exact signed distances of points from primitives.

use clearance_geometry::Primitive;
use clearance_geometry::math::{Extremes, Point};

/// Signed distance (m) of a point in the frame of a primitive: outside, its distance; inside, the negative distance from the surface.
pub fn signed_distance(primitive: &Primitive, p: &Point) -> f64 {
    let from_axis = p.x.hypot(p.y);
    match *primitive {
        Primitive::Sphere { radius } => p.coords.norm() - radius,
        Primitive::Capsule { radius, half_length } => {
            from_axis.hypot((p.z.abs() - half_length).greater(0.0)) - radius
        }
        Primitive::Box { half_extents: [x, y, z] } => of_faces([p.x.abs() - x, p.y.abs() - y, p.z.abs() - z]),
        Primitive::Cylinder { radius, half_length } => {
            of_faces([from_axis - radius, p.z.abs() - half_length, f64::NEG_INFINITY])
        }
        Primitive::Cone { radius, half_length } => of_cone(radius, half_length, from_axis, p.z),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link_solid::LinkSolid;
    use crate::primitive_mesh::inscribed_mesh;
    use clearance_geometry::math::Vector;

    #[test]
    fn distances_agree_with_the_inscribed_mesh() {
        let mut random = fastrand::Rng::with_seed(1);
        for primitive in [
            Primitive::cuboid([0.2, 0.3, 0.4]).unwrap(),
            Primitive::sphere(0.3).unwrap(),
            Primitive::cylinder(0.1, 0.5).unwrap(),
            Primitive::cone(0.2, 0.3).unwrap(),
            Primitive::capsule(0.1, 0.4).unwrap(),
        ] {
            let (mesh, error) = inscribed_mesh(&primitive).unwrap();
            let solid = LinkSolid::of_meshes(vec![mesh]).unwrap();
            for _ in 0..2000 {
                let p = Point::from(Vector::from_fn(|_, _| random.f64() - 0.5));
                let (exact, of_mesh) = (signed_distance(&primitive, &p), solid.signed_distance(&p));
                let gap = of_mesh - exact;
                assert!(-1e-12 <= gap && gap <= error + 1e-12, "{primitive:?} {p:?}: {exact} {of_mesh}");
            }
        }
    }
}
