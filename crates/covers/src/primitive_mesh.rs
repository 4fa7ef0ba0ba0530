//! Triangle meshes inscribed in primitives, with the largest distance of a primitive's point from its mesh.

use std::f64::consts::{PI, TAU};

use clearance_geometry::math::Point;
use clearance_geometry::{MeshError, Primitive, TriangleMesh};

/// Number of segments of a circle.
const SEGMENTS: u32 = 96;

/// Mesh with its corners on the surface of a primitive, and a bound (m) on the distance of the primitive's points from it as a solid.
pub fn inscribed_mesh(primitive: &Primitive) -> Result<(TriangleMesh, f64), MeshError> {
    let half_segment = PI / f64::from(SEGMENTS);
    // a face of a sphere's mesh spans one segment in both directions; its corners are within half of its diagonal
    let (of_circle, of_sphere) = (sagitta(half_segment), sagitta(1.5 * half_segment));
    match *primitive {
        Primitive::Box { half_extents } => Ok((cuboid(half_extents)?, 0.0)),
        Primitive::Sphere { radius } => Ok((revolved(&arc(radius, 0.0))?, radius * of_sphere)),
        Primitive::Capsule { radius, half_length } => {
            Ok((revolved(&arc(radius, half_length))?, radius * of_sphere))
        }
        Primitive::Cylinder { radius, half_length } => {
            let profile =
                [[0.0, -half_length], [radius, -half_length], [radius, half_length], [0.0, half_length]];
            Ok((revolved(&profile)?, radius * of_circle))
        }
        Primitive::Cone { radius, half_length } => Ok((
            revolved(&[[0.0, -half_length], [radius, -half_length], [0.0, half_length]])?,
            radius * of_circle,
        )),
    }
}

/// Height of a circular segment of radius 1 over its chord, of half the angle `half` (rad), rounded up.
fn sagitta(half: f64) -> f64 {
    (1.0 - half.cos()) * 1.000_001
}

fn cuboid([x, y, z]: [f64; 3]) -> Result<TriangleMesh, MeshError> {
    let sign = |i: u32, bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
    let corners = (0..8).map(|i| Point::new(sign(i, 1) * x, sign(i, 2) * y, sign(i, 4) * z));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    TriangleMesh::new(corners.collect(), triangles.collect())
}

/// Profile (distance from the axis, height) of a sphere whose halves are moved apart by `half_length` each.
fn arc(radius: f64, half_length: f64) -> Vec<[f64; 2]> {
    let steps = SEGMENTS / 2;
    let at = |i: u32| {
        let angle = PI * f64::from(i) / f64::from(steps);
        let shift = if 2 * i <= steps { -half_length } else { half_length };
        [radius * angle.sin(), shift - radius * angle.cos()]
    };
    let mut profile: Vec<_> = (0..=steps).map(at).collect();
    (profile[0][0], profile[steps as usize][0]) = (0.0, 0.0);
    if half_length > 0.0 {
        profile.insert(steps as usize / 2 + 1, [radius, half_length]);
    }
    profile
}

/// Closed mesh of a profile, from its lowest point to its highest (both on the axis), revolved about z.
fn revolved(profile: &[[f64; 2]]) -> Result<TriangleMesh, MeshError> {
    let rings = u32::try_from(profile.len()).unwrap_or(u32::MAX) - 2;
    let mut vertices = vec![Point::new(0.0, 0.0, profile[0][1])];
    for [distance, height] in &profile[1..profile.len() - 1] {
        vertices.extend((0..SEGMENTS).map(|i| {
            let angle = TAU * f64::from(i) / f64::from(SEGMENTS);
            Point::new(distance * angle.cos(), distance * angle.sin(), *height)
        }));
    }
    vertices.push(Point::new(0.0, 0.0, profile[profile.len() - 1][1]));
    let at = |ring: u32, i: u32| 1 + ring * SEGMENTS + i % SEGMENTS;
    let top = 1 + rings * SEGMENTS;
    let mut triangles = vec![];
    for i in 0..SEGMENTS {
        triangles.push([0, at(0, i + 1), at(0, i)]);
        triangles.push([top, at(rings - 1, i), at(rings - 1, i + 1)]);
        for ring in 1..rings {
            let [a, b, c, d] = [at(ring - 1, i), at(ring - 1, i + 1), at(ring, i + 1), at(ring, i)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriangleMesh::new(vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link_solid::LinkSolid;
    use clearance_geometry::math::Vector;

    fn primitives() -> [Primitive; 5] {
        [
            Primitive::cuboid([0.2, 0.3, 0.4]).unwrap(),
            Primitive::sphere(0.3).unwrap(),
            Primitive::cylinder(0.1, 0.5).unwrap(),
            Primitive::cone(0.2, 0.3).unwrap(),
            Primitive::capsule(0.1, 0.4).unwrap(),
        ]
    }

    #[test]
    fn meshes_are_closed_and_inscribed() {
        for primitive in primitives() {
            let (mesh, error) = inscribed_mesh(&primitive).unwrap();
            assert!(mesh.signed_volume() > 0.0 && !mesh.solid().remarks().is_open(), "{primitive:?}");
            assert!(mesh.solid().remarks().is_empty() && error <= 0.002 * 0.3, "{primitive:?}");
            let reach = mesh.vertices().iter().map(|v| v.coords.norm()).fold(0.0, f64::max);
            assert!((reach - primitive.bounding_radius()).abs() < 1e-12, "{primitive:?}");
        }
    }

    #[test]
    fn the_error_bounds_the_gap_to_a_sphere() {
        let (mesh, error) = inscribed_mesh(&Primitive::sphere(1.0).unwrap()).unwrap();
        let gap = (0..mesh.triangles().len()).map(|i| {
            let t = mesh.triangle(i);
            1.0 - t.nearest_point(&Point::origin()).coords.norm()
        });
        let gap = gap.fold(0.0, f64::max);
        assert!(gap <= error && gap > 0.2 * error, "{gap} {error}");
    }

    #[test]
    fn distances_agree_with_the_inscribed_mesh() {
        let mut random = fastrand::Rng::with_seed(1);
        for primitive in primitives() {
            let (mesh, error) = inscribed_mesh(&primitive).unwrap();
            let solid = LinkSolid::of_meshes(vec![mesh]).unwrap();
            for _ in 0..2000 {
                let p = Point::from(Vector::from_fn(|_, _| random.f64() - 0.5));
                let (exact, of_mesh) = (primitive.signed_distance(&p), solid.signed_distance(&p));
                let gap = of_mesh - exact;
                assert!(-1e-12 <= gap && gap <= error + 1e-12, "{primitive:?} {p:?}: {exact} {of_mesh}");
            }
        }
    }
}
