//! Collision geometry of a link as one solid in the link frame.

use std::collections::HashSet;

use clearance_geometry::math::{Extremes, Point, Pose, Vector};
use clearance_geometry::{MeshError, Primitive, Shape, Triangle, TriangleMesh};
use clearance_robot::{Collision, Link};

use crate::ball::{Ball, ROUNDING};
use crate::primitive_mesh::inscribed_mesh;
use crate::triangle_tree::TriangleTree;

/// Largest coordinate (m) for which the rounding of distances is below `ball::ROUNDING`.
const LARGEST_COORDINATE: f64 = 1000.0;

/// Reason why a link has no solid.
#[derive(Debug, thiserror::Error)]
pub enum SolidError {
    /// The shape has no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Nothing would be proven by rounded distances.
    #[error(
        "its collision geometry reaches {0} m from the link's origin: covers are proven up to 1000 m; check the units"
    )]
    TooFar(f64),
}

/// The solid that a link's collision geometry makes: closed surfaces with what is inside of them, and open surfaces. Coordinates (m) are in
/// the link frame.
///
/// Distances from primitives are exact. The triangles of a curved primitive are those of an inscribed mesh; [`Self::chord_error`] bounds the
/// distance of the primitive's points outside of it.
#[derive(Clone, Debug)]
pub struct LinkSolid {
    parts: Vec<Part>,
    chord_error: f64,
}

/// A point (m), and the signed distance (m) of the solid there.
pub type KnownDistance = (Point, f64);

/// A primitive, a closed surface of a mesh, or the faces that belong to none.
#[derive(Clone, Debug)]
struct Part {
    /// The primitive with the pose of the link in its frame.
    primitive: Option<(Primitive, Pose)>,
    mesh: TriangleMesh,
    tree: TriangleTree,
    has_inside: bool,
}

impl Part {
    /// The parts of a mesh. Each closed surface is one: faces within another surface do not reduce its depths.
    fn of_mesh(mesh: TriangleMesh) -> Result<Vec<Self>, MeshError> {
        let surfaces = mesh.solid().surfaces();
        if surfaces.len() <= 1 && !mesh.solid().remarks().is_open() {
            return Ok(vec![Self::new(mesh)]);
        }
        let of = |triangles: &[[u32; 3]]| TriangleMesh::new(mesh.vertices().to_vec(), triangles.to_vec());
        let key = |triangle: &[u32; 3]| {
            let mut corners =
                triangle.map(|v| mesh.vertices()[v as usize].coords.data.0[0].map(f64::to_bits));
            corners.sort_unstable();
            corners
        };
        let closed: HashSet<_> =
            surfaces.iter().flat_map(clearance_geometry::ClosedSurface::triangles).map(key).collect();
        let rest: Vec<[u32; 3]> =
            mesh.triangles().iter().filter(|t| !closed.contains(&key(t))).copied().collect();
        let mut parts = vec![];
        for surface in surfaces {
            parts.push(Self::new(of(surface.triangles())?));
        }
        if !rest.is_empty() {
            parts.push(Self::new(of(&rest)?));
        }
        Ok(parts)
    }

    fn new(mesh: TriangleMesh) -> Self {
        let triangles = (0..mesh.triangles().len()).map(|i| mesh.triangle(i)).collect();
        let has_inside = !mesh.solid().surfaces().is_empty();
        Self { primitive: None, tree: TriangleTree::new(triangles), has_inside, mesh }
    }

    fn of_primitive(primitive: Primitive, mesh: TriangleMesh, pose_ls: &Pose) -> Self {
        let triangles = (0..mesh.triangles().len()).map(|i| mesh.triangle(i)).collect();
        let primitive = Some((primitive, pose_ls.inverse()));
        Self { primitive, tree: TriangleTree::new(triangles), has_inside: true, mesh }
    }

    /// Signed distance, or `limit` if the point is farther outside; `is_outside` of a point that is known to be.
    fn signed_distance(&self, p: &Point, limit: f64, is_outside: bool) -> f64 {
        if let Some((primitive, pose_sl)) = &self.primitive {
            return primitive.signed_distance(&(pose_sl * p));
        }
        let distance = self.tree.distance(p, limit);
        if self.has_inside && !is_outside && self.mesh.encloses(p) { -distance } else { distance }
    }

    fn surface_distance(&self, p: &Point, limit: f64) -> f64 {
        match &self.primitive {
            Some(_) => self.signed_distance(p, limit, false).abs().lesser(limit),
            None => self.tree.distance(p, limit),
        }
    }
}

impl LinkSolid {
    /// The solid of a link; `None` if the link has no collision geometry. Rejects planes, clouds and voxels.
    pub fn of_link(link: &Link) -> Result<Option<Self>, SolidError> {
        if link.collisions.is_empty() {
            return Ok(None);
        }
        let (mut parts, mut chord_error) = (vec![], 0.0_f64);
        for collision in &link.collisions {
            let (mesh, error) = mesh_of(collision)?;
            chord_error = chord_error.greater(error);
            match &collision.shape {
                Shape::Primitive(primitive) => {
                    parts.push(Part::of_primitive(*primitive, mesh, &collision.pose_ls));
                }
                _ => parts.extend(Part::of_mesh(mesh)?),
            }
        }
        let solid = Self { parts, chord_error };
        let [low, high] = solid.bounds();
        let farthest = low.coords.amax().greater(high.coords.amax());
        if farthest > LARGEST_COORDINATE {
            return Err(SolidError::TooFar(farthest));
        }
        Ok(Some(solid))
    }

    /// The solid of meshes; `None` of no meshes.
    #[cfg(test)]
    pub fn of_meshes(meshes: Vec<TriangleMesh>) -> Option<Self> {
        let parts: Vec<Part> =
            meshes.into_iter().flat_map(|mesh| Part::of_mesh(mesh).unwrap_or_default()).collect();
        (!parts.is_empty()).then_some(Self { parts, chord_error: 0.0 })
    }

    /// Largest distance (m) of a point of a curved primitive from the mesh that replaces it.
    pub fn chord_error(&self) -> f64 {
        self.chord_error
    }

    /// The spheres that the solid consists of; `None` if a part is of another shape.
    pub fn spheres(&self) -> Option<Vec<Ball>> {
        let sphere = |part: &Part| match part.primitive {
            Some((Primitive::Sphere { radius }, pose_sl)) => {
                Some(Ball { centre: pose_sl.inverse() * Point::origin(), radius })
            }
            _ => None,
        };
        self.parts.iter().map(sphere).collect()
    }

    /// True if a part of the solid has an inside.
    pub fn has_inside(&self) -> bool {
        self.parts.iter().any(|part| part.has_inside)
    }

    /// All triangles of all parts.
    pub fn triangles(&self) -> impl Iterator<Item = &Triangle> {
        self.parts.iter().flat_map(|part| part.tree.triangles())
    }

    /// Smallest and largest corner (m) of a box around the solid.
    pub fn bounds(&self) -> [Point; 2] {
        let bounds = self.parts.iter().map(|part| part.tree.bounds());
        let [low, high] =
            bounds.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])]).unwrap_or([Point::origin(); 2]);
        // a curved primitive is beyond the box of its triangles
        [low - Vector::repeat(self.chord_error), high + Vector::repeat(self.chord_error)]
    }

    /// Length (m) of the diagonal of the box around the solid.
    pub fn extent(&self) -> f64 {
        let [low, high] = self.bounds();
        (high - low).norm()
    }

    /// Distance (m) of a point from the nearest surface, or `limit` if none is nearer.
    pub fn surface_distance(&self, p: &Point, limit: f64) -> f64 {
        self.parts.iter().fold(limit, |least, part| part.surface_distance(p, least))
    }

    /// Signed distance (m) of a point: outside, its distance from the solid. Inside, it is negative: a ball of this radius around the point is
    /// inside, too (for overlapping parts, the deepest part counts).
    pub fn signed_distance(&self, p: &Point) -> f64 {
        let distances = self.parts.iter().map(|part| part.signed_distance(p, f64::INFINITY, false));
        distances.fold(f64::INFINITY, Extremes::lesser)
    }

    /// The same as [`Self::signed_distance`], faster near a point with a known value.
    pub fn signed_distance_near(&self, p: &Point, (q, known): KnownDistance) -> f64 {
        // values at two points differ by at most their distance
        let apart = (p - q).norm() + ROUNDING;
        if let [part] = self.parts.as_slice() {
            if known.abs() > apart && part.primitive.is_none() {
                return part.tree.distance(p, known.abs() + apart).copysign(known);
            }
            return part.signed_distance(p, known.abs() + apart, false);
        }
        let limit = known.abs() + apart;
        let distances = self.parts.iter().map(|part| part.signed_distance(p, limit, known > apart));
        distances.fold(limit, Extremes::lesser)
    }
}

/// The triangles of a collision geometry in the link frame, with their chord error.
fn mesh_of(collision: &Collision) -> Result<(TriangleMesh, f64), MeshError> {
    let (mesh, error) = match &collision.shape {
        Shape::Primitive(primitive) => inscribed_mesh(primitive)?,
        Shape::Mesh(mesh) => (TriangleMesh::clone(mesh), 0.0),
        Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => return Err(MeshError::NoTriangles),
    };
    let vertices = mesh.vertices().iter().map(|v| collision.pose_ls * v).collect();
    Ok((TriangleMesh::new(vertices, mesh.triangles().to_vec())?, error))
}
