//! Containment test: is any part of one body inside a closed mesh of another?
//!
//! Where surfaces are apart, each connected part of one is wholly inside or wholly outside the other: one point of each decides.
//! Inside is where one of a mesh's closed surfaces winds around a point. Faces that a ray crosses are counted; where rounding might change
//! the count, all solid angles are added (van Oosterom & Strackee 1983). Which closed surfaces a mesh has is read from its faces alone, for prover and verifier alike.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use clearance_geometry::math::{MatrixPose, Point, Pose};
use clearance_geometry::{ClosedSurface, Shape, TriangleMesh};

use super::ray_crossings::RayCrossings;

/// The closed meshes of a body, and a point of each connected part of it.
#[derive(Debug)]
pub(super) struct Interior {
    closed: Vec<ClosedMesh>,
    parts: Vec<Point>,
}

/// A mesh with an inside, placed in its body.
#[derive(Debug)]
struct ClosedMesh {
    pose: Pose,
    mesh: Arc<TriangleMesh>,
    /// By closed surface.
    crossings: Vec<RayCrossings>,
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
                        interior.closed.push(ClosedMesh::new(pose, mesh));
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
        self.closed.iter().any(|closed| closed.holds(point))
    }
}

impl ClosedMesh {
    fn new(pose: &Pose, mesh: &Arc<TriangleMesh>) -> Self {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.vertices()[v as usize]);
        let faces = |surface: &ClosedSurface| surface.triangles().iter().map(corners).collect();
        let crossings = mesh.solid().surfaces().iter().map(|surface| RayCrossings::new(faces(surface)));
        Self { pose: *pose, mesh: Arc::clone(mesh), crossings: crossings.collect() }
    }

    fn holds(&self, point: &Point) -> bool {
        let p = self.pose.inverse_transform_point(point);
        self.mesh.solid().surfaces().iter().zip(&self.crossings).any(|(surface, crossings)| {
            let [low, high] = surface.bounds();
            let is_around = (0..3).all(|i| low[i] <= p[i] && p[i] <= high[i]);
            is_around
                && match crossings.winding_number(&p) {
                    Some(number) => number != 0,
                    None => turns(self.mesh.vertices(), surface, &p).abs() > 0.5,
                }
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
    /// verifier hold to be inside is the same, and what all solid angles say. Corners are on a grid now and then, and so are points: then
    /// rays meet edges.
    #[test]
    fn inside_is_what_it_is_to_the_prover() {
        let mut random = Random::new(8);
        let (mut inside, mut counted, mut added) = (0, 0, 0);
        for round in 0..300 {
            let (mut vertices, mut faces) = (Vec::new(), Vec::new());
            let snapped = |p: Point| if round % 3 == 0 { p.map(|c| (4.0 * c).round() / 4.0) } else { p };
            for _ in 0..=random.below(2) {
                let first = u32::try_from(vertices.len()).unwrap();
                vertices.extend((0..4).map(|_| snapped(Point::from(random.vector(1.0)))));
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
                let p = snapped(Point::from(random.vector(0.6)));
                let turns_of = |surface| turns(mesh.vertices(), surface, &p);
                let all: Vec<f64> = mesh.solid().surfaces().iter().map(turns_of).collect();
                if all.iter().any(|turns| (turns - turns.round()).abs() > 1e-6) {
                    // a point of a face is neither inside nor outside
                    continue;
                }
                for (turns, crossings) in all.iter().zip(interior.closed.iter().flat_map(|c| &c.crossings)) {
                    #[allow(clippy::cast_possible_truncation)] // a small integer
                    let expected = turns.round() as i64;
                    let found = crossings.winding_number(&p);
                    assert!(found.is_none_or(|found| found == expected), "{p}: {found:?} {turns}");
                    *(if found.is_some() { &mut counted } else { &mut added }) += 1;
                }
                assert_eq!(interior.holds(&p), all.iter().any(|turns| turns.abs() > 0.5));
                assert_eq!(interior.holds(&p), mesh.encloses(&p));
                inside += usize::from(interior.holds(&p));
            }
        }
        assert!(inside > 100 && counted > 5000 && added > 100, "{inside} {counted} {added}");
    }
}
