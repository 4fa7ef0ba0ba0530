//! Bodies without hierarchies: the slow path of the comparison.

use clearance::geometry::Shape;
use clearance::geometry::math::{Point, Pose};
use clearance::scene::BodyId;

use crate::reference::{self, ReferenceBody};

/// A body without hierarchies.
pub struct Slow {
    pub id: BodyId,
    elements: Option<ReferenceBody>,
    /// Triangles of meshes, those of each mesh in a list, and whether the mesh is closed.
    meshes: Vec<(Vec<[Point; 3]>, bool)>,
    /// Points of all connected parts, more than are needed.
    samples: Vec<Point>,
    /// Balls: centres, and their radius (m).
    cloud: (Vec<Point>, f64),
}

impl Slow {
    pub fn new(id: BodyId, shapes: &[(Pose, &Shape)]) -> Self {
        let is_element = |shape: &Shape| matches!(shape, Shape::Mesh(_) | Shape::Primitive(_));
        let elements: Vec<_> = shapes.iter().filter(|(_, shape)| is_element(shape)).collect();
        let mut slow = Self {
            id,
            elements: (!elements.is_empty())
                .then(|| ReferenceBody::new(elements.iter().map(|(pose, shape)| (pose, *shape)))),
            meshes: Vec::new(),
            samples: Vec::new(),
            cloud: (Vec::new(), 0.0),
        };
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
                    let centres = cloud.points().iter().map(|p| pose * Point::from(p.map(f64::from)));
                    slow.cloud = (centres.collect(), cloud.radius());
                }
                _ => unreachable!("not in these scenes"),
            }
        }
        slow.samples.extend(&slow.cloud.0);
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

    /// Distance of the balls of a cloud from triangles.
    fn distance_of_cloud(&self, (centres, radius): &(Vec<Point>, f64), pose: &Pose) -> f64 {
        let faces: Vec<_> = self.meshes.iter().flat_map(|(faces, _)| faces).collect();
        let mut least = f64::INFINITY;
        for centre in centres {
            let p = pose * centre;
            for [a, b, c] in &faces {
                let triangle = clearance::geometry::Triangle { a: *a, b: *b, c: *c };
                least = least.min((nalgebra::distance(&triangle.nearest_point(&p), &p) - radius).max(0.0));
            }
        }
        least
    }

    /// Distance (m) as solids, and whether something is inside although the surfaces are apart.
    pub fn distance(&self, other: &Self, pose_ab: &Pose) -> (f64, bool) {
        let mut least = f64::INFINITY;
        if let (Some(a), Some(b)) = (&self.elements, &other.elements) {
            least = reference::distance(a, b, pose_ab, f64::INFINITY).map_or(least, |found| found.distance);
        }
        let pose_ba = pose_ab.inverse();
        least = least.min(self.distance_of_cloud(&other.cloud, pose_ab));
        least = least.min(other.distance_of_cloud(&self.cloud, &pose_ba));
        if least == 0.0 {
            return (0.0, false);
        }
        let is_inside = other.samples.iter().any(|p| self.encloses(&(pose_ab * p)))
            || self.samples.iter().any(|p| other.encloses(&(pose_ba * p)));
        (if is_inside { 0.0 } else { least }, is_inside)
    }
}
