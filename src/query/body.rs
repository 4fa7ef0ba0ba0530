//! A rigid body ready for questions: its triangles and solids, and the hierarchies over them.

use super::bounding_sphere::BoundingSphere;
use super::containment::Interior;
use super::core::RoundedCore;
use super::element::ElementNumber;
use super::solid::{Solid, SolidLeaf};
use super::surface::Surface;
use crate::bounding_volume::{BoundingVolume, Obb};
use crate::bvh::Tree;
use crate::geometry::Shape;
use crate::math::{Point, Pose};

/// One body in its own frame, with hierarchies of volumes `B`.
#[derive(Clone, Debug)]
pub struct CollisionBody<B: BoundingVolume = Obb> {
    /// All triangles.
    pub(super) surface: Option<Surface<B>>,
    /// All primitives.
    pub(super) solids: Option<Tree<B, SolidLeaf>>,
    pub(super) interior: Option<Interior>,
    bounding_sphere: BoundingSphere,
}

impl CollisionBody {
    /// A body of shapes, each at its pose in the body's frame; `None` without shapes. Meshes are surfaces.
    #[must_use]
    pub fn new<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Option<Self> {
        Self::with_volumes(shapes)
    }

    /// As [`Self::new`], but what lies wholly inside a closed mesh touches it, if it was made so, too. Open meshes stay surfaces.
    #[must_use]
    pub fn with_solid_meshes<'a>(
        shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape), IntoIter: Clone>,
    ) -> Option<Self> {
        let shapes = shapes.into_iter();
        let mut body = Self::new(shapes.clone())?;
        body.interior = Some(Interior::new(shapes));
        Some(body)
    }
}

impl<B: BoundingVolume> CollisionBody<B> {
    /// As [`CollisionBody::new`], with hierarchies of any volume.
    ///
    /// # Panics
    /// When the meshes have more than 2³² vertices or 2³¹ triangles together.
    #[must_use]
    pub fn with_volumes<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Option<Self> {
        let (mut vertices, mut faces, mut solids): (Vec<Point>, Vec<[u32; 3]>, Vec<Solid>) =
            Default::default();
        for (pose, shape) in shapes {
            match shape {
                Shape::Primitive(primitive) => solids.push(Solid { primitive: *primitive, pose: *pose }),
                Shape::Mesh(mesh) => {
                    let first = u32::try_from(vertices.len()).expect("vertex count fits 32 bits");
                    vertices.extend(mesh.vertices().iter().map(|p| pose * p));
                    faces.extend(mesh.triangles().iter().map(|t| t.map(|v| v + first)));
                }
                Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => todo!("planes, points, cubes"),
            }
        }
        let bounding_sphere = BoundingSphere::around(&vertices, &faces, &solids)?;
        let solids = (!solids.is_empty()).then(|| Tree::build(&solids).0);
        Some(Self { surface: Surface::new(vertices, &faces), solids, interior: None, bounding_sphere })
    }

    /// A sphere around the body, in its frame.
    #[must_use]
    pub fn bounding_sphere(&self) -> &BoundingSphere {
        &self.bounding_sphere
    }

    /// One of the elements.
    pub(super) fn core(&self, number: ElementNumber) -> RoundedCore {
        let missing = "the number is of an element of this body";
        if number.is_triangle() {
            self.surface.as_ref().expect(missing).core(number.index())
        } else {
            self.solids.as_ref().expect(missing).leaves()[number.index() as usize].content.core
        }
    }

    pub(super) fn has_solids(&self) -> bool {
        self.solids.is_some()
    }

    /// Number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.surface.as_ref().map_or(0, Surface::triangle_count)
    }

    /// Memory of the hierarchies and of the triangles in them, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.surface.as_ref().map_or(0, Surface::bytes) + self.solids.as_ref().map_or(0, Tree::bytes)
    }
}
