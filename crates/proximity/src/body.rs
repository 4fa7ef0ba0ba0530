//! Collision geometry of a rigid body: its triangles, solids, planes and grains, and the hierarchies over them.

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose};
use clearance_geometry::{Plane, Shape};

use super::bounding_sphere::BoundingSphere;
use super::containment::Interior;
use super::core::RoundedCore;
use super::element::ElementNumber;
use super::grains::Grains;
use super::planes::planes_bound;
use super::solid::{Solid, SolidLeaf};
use super::surface::Surface;
use crate::bounding_volume::{BoundingVolume, Obb};
use crate::bvh::Tree;

/// Collision geometry of one body in its own frame, with hierarchies of volumes `B`.
#[derive(Clone, Debug)]
pub struct CollisionBody<B: BoundingVolume = Obb> {
    /// All triangles.
    pub(super) surface: Option<Surface<B>>,
    /// All primitives.
    pub(super) solids: Option<Tree<B, SolidLeaf>>,
    /// In the frame of the body.
    pub(super) planes: Vec<Plane>,
    /// Clouds of points and sets of voxels.
    pub(super) grains: Vec<Grains<B>>,
    pub(super) interior: Option<Interior>,
    /// Bounding sphere of everything except the planes.
    bounded: Option<BoundingSphere>,
}

impl CollisionBody {
    /// A body of shapes, each at its pose in the body's frame; `None` without shapes. Meshes are surfaces.
    #[must_use]
    #[inline]
    pub fn new<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Option<Self> {
        Self::with_volumes(shapes)
    }

    /// As [`Self::new`], but closed meshes are solids: a body wholly inside one touches it, if it was also built by this function. Open
    /// meshes stay surfaces.
    #[must_use]
    #[inline]
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
    /// As [`CollisionBody::new`], with hierarchies of any type of volume.
    ///
    /// # Panics
    /// If the meshes together have more than 2³² vertices or 2³¹ triangles.
    #[must_use]
    #[inline]
    pub fn with_volumes<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Option<Self> {
        let (mut vertices, mut faces, mut solids): (Vec<Point>, Vec<[u32; 3]>, Vec<Solid>) =
            Default::default();
        let (mut planes, mut grains): (Vec<Plane>, Vec<Grains<B>>) = Default::default();
        for (pose, shape) in shapes {
            match shape {
                Shape::Primitive(primitive) => solids.push(Solid { primitive: *primitive, pose: *pose }),
                Shape::Mesh(mesh) => {
                    let first = u32::try_from(vertices.len()).expect("vertex count fits 32 bits");
                    vertices.extend(mesh.vertices().iter().map(|p| pose * p));
                    faces.extend(mesh.triangles().iter().map(|t| t.map(|v| v + first)));
                }
                Shape::Plane(plane) => planes.push(plane.transformed(pose)),
                Shape::Points(cloud) => grains.push(Grains::of_points(cloud, pose, set(&grains))),
                Shape::Voxels(voxels) => grains.push(Grains::of_voxels(voxels, pose, set(&grains))),
            }
        }
        let bounded = BoundingSphere::around(&vertices, &faces, &solids, &grains);
        if bounded.is_none() && planes.is_empty() {
            return None;
        }
        let solids = (!solids.is_empty()).then(|| Tree::build(&solids).0);
        let surface = Surface::new(vertices, &faces);
        Some(Self { surface, solids, planes, grains, interior: None, bounded })
    }

    /// A sphere around the body, in its frame; its radius is infinite where the body has a plane.
    #[must_use]
    #[inline]
    pub fn bounding_sphere(&self) -> BoundingSphere {
        self.bounded.filter(|_| !self.has_planes()).unwrap_or(BoundingSphere::UNBOUNDED)
    }

    /// A sphere around everything except the planes.
    #[inline]
    pub(super) fn bounded(&self) -> Option<&BoundingSphere> {
        self.bounded.as_ref()
    }

    /// Lower bound (m) on the distance of two bodies, from their bounding spheres and planes.
    #[must_use]
    #[inline]
    pub fn sphere_bound(&self, other: &Self, pose_ab: &MatrixPose) -> f64 {
        let bounded = self.bounded.as_ref().zip(other.bounded.as_ref());
        let of_spheres = bounded.map_or(f64::INFINITY, |(a, b)| a.lower_bound(b, pose_ab));
        if !self.has_planes() && !other.has_planes() {
            return of_spheres;
        }
        of_spheres.lesser(planes_bound((self, other), pose_ab))
    }

    /// One of the elements.
    #[inline]
    pub(super) fn core(&self, number: ElementNumber) -> RoundedCore {
        let missing = "the number is of an element of this body";
        if number.is_triangle() {
            self.surface.as_ref().expect(missing).core(number.index())
        } else {
            self.solids.as_ref().expect(missing).leaves()[number.index() as usize].content.core
        }
    }

    #[inline]
    pub(super) fn has_solids(&self) -> bool {
        self.solids.is_some()
    }

    #[inline]
    pub(super) fn has_planes(&self) -> bool {
        !self.planes.is_empty()
    }

    #[inline]
    pub(super) fn has_grains(&self) -> bool {
        !self.grains.is_empty()
    }

    /// Number of triangles.
    #[must_use]
    #[inline]
    pub fn triangle_count(&self) -> usize {
        self.surface.as_ref().map_or(0, Surface::triangle_count)
    }

    /// Number of points in clouds and of voxels.
    #[must_use]
    #[inline]
    pub fn grain_count(&self) -> usize {
        self.grains.iter().map(Grains::count).sum()
    }

    /// Memory of the hierarchies and of the triangles, points and voxels in them, in bytes.
    #[must_use]
    #[inline]
    pub fn bytes(&self) -> usize {
        let grains: usize = self.grains.iter().map(Grains::bytes).sum();
        self.surface.as_ref().map_or(0, Surface::bytes) + self.solids.as_ref().map_or(0, Tree::bytes) + grains
    }
}

/// The number of the next set.
fn set<B: BoundingVolume>(grains: &[Grains<B>]) -> u32 {
    u32::try_from(grains.len()).expect("a body has few clouds")
}
