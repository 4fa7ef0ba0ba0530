//! A rigid body ready for questions: its convex elements and the hierarchies over them.

use super::containment::Interior;
use crate::bounding_volume::{BoundingVolume, Obb, Rss, Sphere};
use crate::bvh::{Element, Tree};
use crate::geometry::Shape;
use crate::math::{Point, Pose};

/// One body in its own frame: triangles and primitives, an OBB tree for booleans and an RSS tree for distances.
#[derive(Clone, Debug)]
pub struct CollisionBody {
    pub(super) elements: Vec<Element>,
    pub(super) obb: Tree<Obb>,
    pub(super) rss: Tree<Rss>,
    pub(super) interior: Option<Interior>,
    bounding_sphere: Sphere,
}

impl CollisionBody {
    /// A body of shapes, each at its pose in the body's frame; `None` without shapes. Meshes are surfaces.
    #[must_use]
    pub fn new<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Option<Self> {
        let mut elements = Vec::new();
        for (pose, shape) in shapes {
            match shape {
                Shape::Primitive(primitive) => {
                    elements.push(Element::Primitive { primitive: *primitive, pose: *pose });
                }
                Shape::Mesh(mesh) => elements.extend(
                    (0..mesh.triangles().len())
                        .map(|i| Element::Triangle(mesh.triangle(i).transformed(pose))),
                ),
            }
        }
        (!elements.is_empty()).then(|| Self {
            obb: Tree::build(&elements),
            rss: Tree::build(&elements),
            bounding_sphere: bounding_sphere(&elements),
            elements,
            interior: None,
        })
    }

    /// As [`Self::new`], but what lies wholly inside a closed mesh touches it. Open meshes stay surfaces.
    #[must_use]
    pub fn with_solid_meshes<'a>(
        shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape), IntoIter: Clone>,
    ) -> Option<Self> {
        let shapes = shapes.into_iter();
        let mut body = Self::new(shapes.clone())?;
        body.interior = Some(Interior::new(shapes));
        Some(body)
    }

    /// A sphere around the body, in its frame.
    #[must_use]
    pub fn bounding_sphere(&self) -> &Sphere {
        &self.bounding_sphere
    }

    /// Number of convex elements: triangles and primitives.
    #[must_use]
    pub fn element_count(&self) -> usize {
        self.elements.len()
    }
}

/// A single primitive's own sphere, else one around the corners of everything.
fn bounding_sphere(elements: &[Element]) -> Sphere {
    if let [Element::Primitive { primitive, pose }] = elements {
        return Sphere::around(primitive, pose);
    }
    let mut points: Vec<Point> = Vec::new();
    for e in elements {
        e.hull_points(&mut points);
    }
    Sphere::fit(&points)
}
