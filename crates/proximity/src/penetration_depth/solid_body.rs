//! A rigid body as a solid: the union of its shapes, closed meshes with their inside.

use std::sync::{Arc, LazyLock, OnceLock};

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose, UnitVector, Vector};
use clearance_geometry::{Plane, Primitive, Shape, TriangleMesh};

use super::convex_solid::{ConvexSolid, Hull, SupportMap, farthest_along};
use super::inner_balls::{Ball, inner_balls};
use super::solid_set::SolidSet;
use super::winding::Winding;
use crate::body::BoundingSphere;
use crate::body::CollisionBody;
use crate::narrow_phase::Separation;
use crate::search::Scratch;

/// Number of directions in which the outermost point of each solid is kept.
const DIRECTIONS: usize = 128;

/// Rounding error of a distance, relative to the coordinates.
const ROUNDING: f64 = 1e-13;

/// The solids of one body, in its frame, for queries of penetration depth.
///
/// Closed meshes are solids, also where other queries use their surfaces only. Open meshes stay surfaces.
#[derive(Debug)]
pub struct SolidBody {
    /// All shapes that count as one body.
    pub(crate) union: Option<Union>,
    /// Points and voxels, each a body of its own.
    pub(super) sets: Vec<SolidSet>,
    /// All of these together; built at the first use.
    all_sets: OnceLock<Option<CollisionBody>>,
}

/// A union of solids and planes.
#[derive(Debug)]
pub(crate) struct Union {
    /// All shapes, for tests of separation.
    pub whole: CollisionBody,
    pub parts: Vec<Part>,
    /// All triangles, for distances of inner points from the surface; `None` if the union has nothing else.
    surface: Option<CollisionBody>,
    /// Points of the parts that are farthest in directions spread over the sphere.
    outermost: Vec<Point>,
    balls: OnceLock<Vec<Ball>>,
    /// The meshes, in the order of the triangles' vertices.
    meshes: Vec<Arc<TriangleMesh>>,
    winding: OnceLock<Winding>,
    /// Vertices of the connected parts of each part that is a mesh, in the frame of the body.
    mesh_parts: OnceLock<Vec<Vec<Point>>>,
    /// Whether a part of a mesh is not closed.
    pub is_open: bool,
}

/// One shape of a union.
#[derive(Debug)]
pub(crate) enum Part {
    Convex(ConvexSolid),
    Mesh {
        mesh: Arc<TriangleMesh>,
        pose: Pose,
    },
    /// Two sides and no inside.
    Plane(Plane),
}

impl SolidBody {
    /// A body of shapes, each at its pose in the frame of the body.
    #[must_use]
    pub fn new<'a>(shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>) -> Self {
        Self::with_hierarchies(shapes, None)
    }

    /// As [`Self::new`], for shapes from which `body` was built: its hierarchies are used, which saves most of the time and memory.
    #[must_use]
    pub fn of_body<'a>(
        body: &CollisionBody,
        shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>,
    ) -> Self {
        Self::with_hierarchies(shapes, Some(body))
    }

    fn with_hierarchies<'a>(
        shapes: impl IntoIterator<Item = (&'a Pose, &'a Shape)>,
        body: Option<&CollisionBody>,
    ) -> Self {
        let (mut of_union, mut sets) = (Vec::new(), Vec::new());
        for (pose, shape) in shapes {
            match shape {
                Shape::Points(cloud) => sets.push(SolidSet::Points { cloud: Arc::clone(cloud), pose: *pose }),
                Shape::Voxels(voxels) => {
                    sets.push(SolidSet::Voxels { voxels: Arc::clone(voxels), pose: *pose });
                }
                Shape::Primitive(_) | Shape::Mesh(_) | Shape::Plane(_) => of_union.push((pose, shape)),
            }
        }
        // points and voxels are not part of the union
        let body = body.filter(|_| sets.is_empty());
        Self { union: Union::new(&of_union, body), sets, all_sets: OnceLock::new() }
    }

    /// Whether it has a mesh with an inside.
    pub(super) fn has_closed_meshes(&self) -> bool {
        let interior = self.union.as_ref().and_then(|union| union.whole.interior());
        interior.is_some_and(|interior| !interior.closed_meshes().is_empty())
    }

    /// All points and voxels as one body; `None` if there are none.
    pub(super) fn all_sets(&self) -> Option<&CollisionBody> {
        let build = || {
            let shapes: Vec<(Pose, Shape)> = self.sets.iter().map(SolidSet::shape).collect();
            CollisionBody::new(shapes.iter().map(|(pose, shape)| (pose, shape)))
        };
        self.all_sets.get_or_init(build).as_ref()
    }
}

impl Part {
    fn new(shape: &Shape, pose: &Pose) -> Option<Self> {
        Some(match shape {
            Shape::Primitive(primitive) => Self::Convex(ConvexSolid::primitive(*primitive, *pose)),
            Shape::Mesh(mesh) => match Hull::of_convex_mesh(mesh, pose) {
                Some(hull) => Self::Convex(ConvexSolid::Hull(hull)),
                None => Self::Mesh { mesh: Arc::clone(mesh), pose: *pose },
            },
            Shape::Plane(plane) => Self::Plane(plane.transformed(pose)),
            Shape::Points(_) | Shape::Voxels(_) => return None,
        })
    }

    /// The point farthest along a direction; `None` for a plane.
    pub fn farthest(&self, n: &Vector) -> Option<Point> {
        match self {
            Self::Convex(solid) => Some(solid.support(n) + n * solid.radius()),
            Self::Mesh { mesh, pose } => farthest_corner(mesh, pose, n, &used_vertices(mesh)),
            Self::Plane(_) => None,
        }
    }

    /// The points farthest along some directions.
    fn farthest_along_each(&self, directions: &[UnitVector]) -> Vec<Point> {
        if let Self::Mesh { mesh, pose } = self {
            let used = used_vertices(mesh);
            return directions.iter().filter_map(|n| farthest_corner(mesh, pose, n, &used)).collect();
        }
        directions.iter().filter_map(|n| self.farthest(n)).collect()
    }
}

/// The last of the corners farthest along a direction.
fn farthest_corner(mesh: &TriangleMesh, pose: &Pose, n: &Vector, used: &[u32]) -> Option<Point> {
    let local = pose.inverse_transform_vector(n);
    let corners = used.iter().map(|&v| mesh.vertices()[v as usize]);
    let farthest = corners.max_by(|p, q| p.coords.dot(&local).total_cmp(&q.coords.dot(&local)));
    farthest.map(|p| pose * p)
}

/// The vertices that faces use, each once, in the order of their last faces.
fn used_vertices(mesh: &TriangleMesh) -> Vec<u32> {
    let mut is_new = vec![true; mesh.vertices().len()];
    let corners = mesh.triangles().iter().flatten().rev().copied();
    let mut used: Vec<u32> = corners.filter(|&v| std::mem::take(&mut is_new[v as usize])).collect();
    used.reverse();
    used
}

impl SupportMap for Union {
    /// Among the outermost points that are kept: it may be nearer than the farthest.
    fn support(&self, direction: &Vector) -> Point {
        farthest_along(&self.outermost, direction)
    }

    fn radius(&self) -> f64 {
        0.0
    }
}

impl Union {
    /// `body` is built from the same shapes.
    fn new(shapes: &[(&Pose, &Shape)], body: Option<&CollisionBody>) -> Option<Self> {
        let whole = match body {
            Some(body) => body.with_interior(shapes),
            None => CollisionBody::with_solid_meshes(shapes.iter().copied())?,
        };
        let shapes = || shapes.iter().copied();
        let meshes = || shapes().filter(|(_, shape)| matches!(shape, Shape::Mesh(_)));
        let is_open = |shape: &Shape| matches!(shape, Shape::Mesh(mesh) if mesh.solid().remarks().is_open());
        let parts: Vec<Part> = shapes().filter_map(|(pose, shape)| Part::new(shape, pose)).collect();
        let directions = spread_directions(DIRECTIONS);
        let outermost = parts.iter().flat_map(|part| part.farthest_along_each(&directions));
        Some(Self {
            whole,
            surface: CollisionBody::new(meshes()).filter(|_| meshes().count() < shapes().count()),
            outermost: outermost.collect(),
            balls: OnceLock::new(),
            meshes: shapes().filter_map(mesh_of).collect(),
            winding: OnceLock::new(),
            mesh_parts: OnceLock::new(),
            is_open: meshes().any(|(_, shape)| is_open(shape)),
            parts,
        })
    }

    /// Which side of the triangles is outside; found at the first use.
    pub fn winding(&self) -> &Winding {
        self.winding.get_or_init(|| Winding::new(self.meshes.iter().map(Arc::as_ref)))
    }

    /// Vertices of each connected part of the meshes that are not convex solids, in the frame of the body; found at the first use.
    pub fn mesh_parts(&self) -> &[Vec<Point>] {
        let vertices = |part: &Part| match part {
            Part::Mesh { mesh, pose } => {
                let placed = |vertices: Vec<Point>| vertices.iter().map(|p| pose * p).collect();
                mesh.part_vertices().into_iter().map(placed).collect()
            }
            Part::Convex(_) | Part::Plane(_) => Vec::new(),
        };
        self.mesh_parts.get_or_init(|| self.parts.iter().flat_map(vertices).collect())
    }

    /// The only part, if it is a convex solid.
    pub fn only_convex(&self) -> Option<&ConvexSolid> {
        match &self.parts[..] {
            [Part::Convex(solid)] => Some(solid),
            _ => None,
        }
    }

    /// A union of one convex solid.
    pub fn of_convex(primitive: Primitive, pose: &Pose) -> Option<Self> {
        Self::new(&[(pose, &Shape::Primitive(primitive))], None)
    }

    pub fn bounding_sphere(&self) -> BoundingSphere {
        self.whole.bounding_sphere()
    }

    /// Normals of the planes.
    pub fn plane_normals(&self) -> impl Iterator<Item = Vector> {
        self.parts.iter().filter_map(|part| match part {
            Part::Plane(plane) => Some(plane.normal.into_inner()),
            Part::Convex(_) | Part::Mesh { .. } => None,
        })
    }

    /// Upper bound (m) on the radius of a ball inside.
    pub fn size(&self) -> f64 {
        let radius = self.whole.bounding_sphere().radius;
        if radius.is_finite() { radius } else { 1.0 }
    }

    /// Depth (m) of a point inside, a lower bound for several overlapping parts; minus the distance of a point outside.
    pub fn depth_of_point(&self, p: &Point, scratch: &mut Scratch) -> f64 {
        self.inner_radius(p, scratch).unwrap_or_else(|| {
            let found = distance_of_point(&self.whole, p, scratch);
            found.map_or(f64::NEG_INFINITY, |found| -found.distance)
        })
    }

    /// Radius (m) of a ball around `p` inside one of the solids, as large as it is found; `None` for a point outside of all.
    pub fn inner_radius(&self, p: &Point, scratch: &mut Scratch) -> Option<f64> {
        let of_convex = self.parts.iter().filter_map(|part| match part {
            Part::Convex(solid) => solid.inner_radius(p),
            _ => None,
        });
        let radius = of_convex.reduce(f64::greater);
        if !self.is_in_mesh(p) {
            return radius;
        }
        let to_surface =
            distance_of_point(self.surface_only(), p, scratch).map_or(0.0, |found| found.distance);
        let to_surface = (to_surface - ROUNDING * p.coords.amax()).greater(0.0);
        Some(radius.map_or(to_surface, |radius| radius.greater(to_surface)))
    }

    /// Whether a point is inside a mesh that is not convex.
    pub fn is_in_mesh(&self, p: &Point) -> bool {
        self.parts.iter().any(|part| match part {
            Part::Mesh { mesh, pose } => mesh.encloses(&pose.inverse_transform_point(p)),
            _ => false,
        })
    }

    /// True if a mesh has an inside.
    pub fn has_closed_mesh(&self) -> bool {
        self.meshes.iter().any(|mesh| !mesh.solid().surfaces().is_empty())
    }

    /// All triangles, without other shapes.
    pub fn surface_only(&self) -> &CollisionBody {
        self.surface.as_ref().unwrap_or(&self.whole)
    }

    /// Balls inside the body that together fill much of it; found at the first use. This is not counted as work, which would then depend
    /// on earlier queries.
    pub(super) fn balls(&self, scratch: &mut Scratch) -> &[Ball] {
        let work = scratch.work;
        let balls = self.balls.get_or_init(|| inner_balls(self, scratch));
        scratch.work = work;
        balls
    }

    /// Length (m) by which convex meshes may be smaller than their support points show.
    pub fn excess(&self) -> f64 {
        let of_parts = self.parts.iter().map(|part| match part {
            Part::Convex(solid) => solid.excess(),
            _ => 0.0,
        });
        of_parts.fold(0.0, f64::greater)
    }
}

fn mesh_of((_, shape): (&Pose, &Shape)) -> Option<Arc<TriangleMesh>> {
    match shape {
        Shape::Mesh(mesh) => Some(Arc::clone(mesh)),
        _ => None,
    }
}

/// Distance (m) of a point from a body.
pub(crate) fn distance_of_point(
    body: &CollisionBody,
    p: &Point,
    scratch: &mut Scratch,
) -> Option<Separation> {
    static POINT: LazyLock<CollisionBody> = LazyLock::new(|| {
        let point = Shape::Primitive(Primitive::Sphere { radius: 0.0 });
        CollisionBody::new([(&Pose::identity(), &point)]).expect("a body with a shape")
    });
    let pose = MatrixPose { translation: p.coords, ..MatrixPose::identity() };
    crate::distance(body, &POINT, pose, f64::INFINITY, scratch)
}

/// Directions spread evenly over the sphere: points of a spiral whose turns are the golden angle apart.
#[allow(clippy::cast_precision_loss)] // small numbers
pub(super) fn spread_directions(count: usize) -> Vec<UnitVector> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let (across, angle) = ((1.0 - z * z).sqrt(), golden_angle * i as f64);
            UnitVector::new_normalize(Vector::new(across * angle.cos(), across * angle.sin(), z))
        })
        .collect()
}
