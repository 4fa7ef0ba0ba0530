//! Containment test: is any part of one body inside a closed mesh of another?
//!
//! Where surfaces are apart, each connected part of one is wholly inside or wholly outside the other: one point of each decides.
//! Inside is where one of a mesh's closed surfaces winds around a point (van Oosterom & Strackee 1983 give a triangle's solid angle).
//! Which closed surfaces a mesh has is read from its faces alone, for prover and verifier alike.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use clearance_geometry::math::{MatrixPose, Point, Pose};
use clearance_geometry::{ClosedSurface, Shape, TriangleMesh};

/// The closed meshes of a body, and a point of each connected part of it.
#[derive(Debug)]
pub(super) struct Interior {
    closed: Vec<(Pose, Arc<TriangleMesh>)>,
    parts: Vec<Point>,
}

impl Interior {
    pub fn new(shapes: &[(Pose, &Shape)]) -> Self {
        let mut interior = Self { closed: Vec::new(), parts: Vec::new() };
        for (pose, shape) in shapes {
            match shape {
                // no closed mesh holds a plane
                Shape::Plane(_) => {}
                Shape::Points(cloud) => interior.parts.extend(cloud.points().iter().map(|p| pose * at(p))),
                Shape::Voxels(voxels) => {
                    interior.parts.extend(voxels.cubes().iter().map(|cube| pose * at(&cube.centre)));
                }
                Shape::Primitive(_) => interior.parts.push(Point::from(pose.translation.vector)),
                Shape::Mesh(mesh) => {
                    interior.parts.extend(parts(mesh).iter().map(|p| pose * p));
                    if !mesh.solid().surfaces().is_empty() {
                        interior.closed.push((*pose, Arc::clone(mesh)));
                    }
                }
            }
        }
        interior
    }

    /// True if a part of either body lies in the other.
    pub fn overlap(&self, other: &Self, pose: &MatrixPose) -> bool {
        let back = pose.inverse();
        other.parts.iter().any(|p| self.holds(&(pose * *p)))
            || self.parts.iter().any(|p| other.holds(&(&back * *p)))
    }

    fn holds(&self, point: &Point) -> bool {
        self.closed.iter().any(|(pose, mesh)| {
            let p = pose.inverse_transform_point(point);
            mesh.solid().surfaces().iter().any(|surface| {
                let [low, high] = surface.bounds();
                let is_around = (0..3).all(|i| low[i] <= p[i] && p[i] <= high[i]);
                is_around && turns(mesh.vertices(), surface, &p).abs() > 0.5
            })
        })
    }
}

fn at(coordinates: &[f32; 3]) -> Point {
    Point::from(coordinates.map(f64::from))
}

/// Winding number of a closed surface around a point.
fn turns(vertices: &[Point], surface: &ClosedSurface, p: &Point) -> f64 {
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| vertices[v as usize] - p);
        let [x, y, z] = [a, b, c].map(|v| v.norm());
        let across = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
        a.dot(&b.cross(&c)).atan2(across)
    };
    surface.triangles().iter().map(angle).sum::<f64>() / (2.0 * PI)
}

/// A corner of each connected part; corners at one place are one.
fn parts(mesh: &TriangleMesh) -> Vec<Point> {
    let mut places: HashMap<[u64; 3], usize> = HashMap::new();
    let place_of: Vec<usize> = (mesh.vertices().iter())
        .map(|p| {
            let next = places.len();
            // -0.0 and 0.0 are one place
            *places.entry([p.x, p.y, p.z].map(|c| (c + 0.0).to_bits())).or_insert(next)
        })
        .collect();
    let mut triangles_at: Vec<Vec<usize>> = vec![Vec::new(); places.len()];
    for (i, t) in mesh.triangles().iter().enumerate() {
        for &v in t {
            triangles_at[place_of[v as usize]].push(i);
        }
    }
    let mut seen = vec![false; mesh.triangles().len()];
    let mut parts = Vec::new();
    for start in 0..seen.len() {
        if seen[start] {
            continue;
        }
        parts.push(mesh.triangle(start).a);
        let mut open = vec![start];
        while let Some(i) = open.pop() {
            if !std::mem::replace(&mut seen[i], true) {
                for &v in &mesh.triangles()[i] {
                    open.append(&mut triangles_at[place_of[v as usize]]);
                }
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::testing::Random;

    /// Random tetrahedra, of which some are there in both windings or overlap others that are wound against them: what prover and
    /// verifier hold to be inside is the same.
    #[test]
    fn inside_is_what_it_is_to_the_prover() {
        let mut random = Random::new(8);
        let mut inside = 0;
        for _ in 0..300 {
            let (mut vertices, mut faces) = (Vec::new(), Vec::new());
            for _ in 0..=random.below(2) {
                let first = u32::try_from(vertices.len()).unwrap();
                vertices.extend((0..4).map(|_| Point::from(random.vector(1.0))));
                for face in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
                    let [a, b, c] = face.map(|v: u32| v + first);
                    faces.push([a, b, c]);
                    if random.below(3) == 0 {
                        faces.push([a, c, b]);
                    }
                }
            }
            let mesh = Arc::new(TriangleMesh::new(vertices, faces).unwrap());
            let shape = Shape::Mesh(Arc::clone(&mesh));
            let interior = Interior::new(&[(Pose::identity(), &shape)]);
            for _ in 0..50 {
                let p = Point::from(random.vector(0.6));
                assert_eq!(interior.holds(&p), mesh.encloses(&p));
                inside += usize::from(interior.holds(&p));
            }
        }
        assert!(inside > 100, "{inside}");
    }
}
