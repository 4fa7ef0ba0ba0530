//! Test oracle: distance and containment of bodies by brute force, with solid angles instead of hierarchies.

use clearance::geometry::math::{Point, Pose};
use clearance::geometry::{Primitive, Shape};
use clearance::scene::BodyId;

use crate::reference::{self, ReferenceBody};

/// A body without hierarchies.
pub struct Slow {
    pub id: BodyId,
    elements: ReferenceBody,
    /// Triangles of meshes, those of each mesh in a list, and whether the mesh is closed.
    meshes: Vec<(Vec<[Point; 3]>, bool)>,
    /// Points of all connected parts, more than are needed.
    samples: Vec<Point>,
}

impl Slow {
    pub fn new(id: BodyId, shapes: &[(Pose, &Shape)]) -> Self {
        let elements: Vec<(Pose, Shape)> = shapes.iter().flat_map(elements_of).collect();
        let elements = ReferenceBody::new(elements.iter().map(|(pose, shape)| (pose, shape)));
        let mut slow = Self { id, elements, meshes: Vec::new(), samples: Vec::new() };
        for (pose, shape) in shapes {
            match shape {
                Shape::Primitive(_) => slow.samples.push(Point::from(pose.translation.vector)),
                Shape::Mesh(mesh) => {
                    let faces = (0..mesh.triangles().len()).map(|i| mesh.triangle(i).corners());
                    let faces: Vec<_> = faces.map(|corners| corners.map(|p| pose * p)).collect();
                    slow.samples.extend(faces.iter().map(|corners| corners[0]));
                    slow.meshes.push((faces, !mesh.solid().remarks().is_open()));
                }
                Shape::Points(cloud) => {
                    let centres = cloud.points().iter().map(|p| Point::from(p.map(f64::from)));
                    slow.samples.extend(centres.map(|p| pose * p));
                }
                _ => unreachable!("not in these scenes"),
            }
        }
        slow
    }

    /// True if a closed mesh winds around a point.
    fn encloses(&self, p: &Point) -> bool {
        let winding = |faces: &[[Point; 3]]| {
            let angle = |[a, b, c]: &[Point; 3]| {
                let [a, b, c] = [a - p, b - p, c - p].map(|v| v.normalize());
                2.0 * a.dot(&b.cross(&c)).atan2(1.0 + a.dot(&b) + b.dot(&c) + c.dot(&a))
            };
            faces.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
        };
        self.meshes.iter().any(|(faces, is_closed)| *is_closed && winding(faces).abs() > 0.5)
    }

    /// Distance (m) as solids, and whether something is inside although the surfaces are apart.
    pub fn distance(&self, other: &Self, pose_ab: &Pose) -> (f64, bool) {
        let least = reference::distance(&self.elements, &other.elements, pose_ab, f64::INFINITY);
        let least = least.map_or(f64::INFINITY, |found| found.distance);
        if least == 0.0 {
            return (0.0, false);
        }
        let pose_ba = pose_ab.inverse();
        let is_inside = other.samples.iter().any(|p| self.encloses(&(pose_ab * p)))
            || self.samples.iter().any(|p| other.encloses(&(pose_ba * p)));
        (if is_inside { 0.0 } else { least }, is_inside)
    }
}

/// A shape as the reference engine takes it: a cloud is a sphere for each point.
fn elements_of((pose, shape): &(Pose, &Shape)) -> Vec<(Pose, Shape)> {
    let Shape::Points(cloud) = shape else { return vec![(*pose, (*shape).clone())] };
    let sphere = Shape::Primitive(Primitive::sphere(cloud.radius()).unwrap());
    let pose_of = |[x, y, z]: [f64; 3]| pose * Pose::translation(x, y, z);
    cloud.points().iter().map(|p| (pose_of(p.map(f64::from)), sphere.clone())).collect()
}
