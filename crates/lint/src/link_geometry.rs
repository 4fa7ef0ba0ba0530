//! Collision or visual geometry of one link, placed in the link frame.

use std::sync::Arc;

use clearance_geometry::math::{Extremes, Point, Pose};
use clearance_geometry::{Primitive, Shape, TriangleMesh};
use clearance_robot::{Collision, MeshSource};

/// Geometry of a link, with the places of its elements in the URDF.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbered<'g> {
    pub geometry: &'g [Collision],
    /// From 1; without them, no element is missing.
    pub numbers: &'g [usize],
}

impl<'g> Numbered<'g> {
    pub fn elements(self) -> impl Iterator<Item = (usize, &'g Collision)> {
        let number = move |i: usize| self.numbers.get(i).copied().unwrap_or(i + 1);
        self.geometry.iter().enumerate().map(move |(i, collision)| (number(i), collision))
    }
}

/// A shape in the link frame. The vertices of meshes are in the link frame already; primitives keep their pose.
#[derive(Clone, Debug)]
pub struct PlacedShape {
    /// The shape.
    pub shape: Shape,
    /// Pose of a primitive in the link frame; the identity for a mesh.
    pub pose: Pose,
}

impl PlacedShape {
    /// A mesh whose vertices are in the link frame.
    pub fn mesh(mesh: Arc<TriangleMesh>) -> Self {
        Self { shape: Shape::Mesh(mesh), pose: Pose::identity() }
    }

    /// A primitive at a pose in the link frame.
    pub fn primitive(primitive: Primitive, pose: Pose) -> Self {
        Self { shape: Shape::Primitive(primitive), pose }
    }

    /// The geometry of a link, in its frame. A mesh whose vertices get too large by its pose is left out.
    pub fn of(collision: &Collision) -> Option<Self> {
        let Shape::Mesh(mesh) = &collision.shape else {
            return Some(Self { shape: collision.shape.clone(), pose: collision.pose_ls });
        };
        if collision.pose_ls == Pose::identity() {
            return Some(Self::mesh(mesh.clone()));
        }
        let vertices = mesh.vertices().iter().map(|p| collision.pose_ls * p).collect();
        let placed = TriangleMesh::new(vertices, mesh.triangles().to_vec()).ok()?;
        Some(Self::mesh(Arc::new(placed)))
    }

    /// Smallest and largest corner (m) of a box around the shape, in the link frame.
    pub fn bounds(&self) -> Option<[Point; 2]> {
        match &self.shape {
            Shape::Mesh(mesh) => Some(mesh.bounds().into()),
            Shape::Primitive(primitive) => {
                let corners = primitive.hull_points().map(|p| [self.pose * p; 2]);
                corners.reduce(joined)
            }
            Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => None,
        }
    }
}

/// The box around two boxes.
pub(crate) fn joined(a: [Point; 2], b: [Point; 2]) -> [Point; 2] {
    [a[0].inf(&b[0]), a[1].sup(&b[1])]
}

/// The corners of a box.
pub(crate) fn box_corners([low, high]: [Point; 2]) -> impl Iterator<Item = Point> {
    let coordinate = move |i: usize, axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
    (0..8).map(move |i| Point::new(coordinate(i, 0), coordinate(i, 1), coordinate(i, 2)))
}

/// The box around all shapes; `None` without shapes.
pub(crate) fn bounds_of(shapes: &[PlacedShape]) -> Option<[Point; 2]> {
    shapes.iter().filter_map(PlacedShape::bounds).reduce(joined)
}

/// Largest absolute coordinate (m) of all shapes.
pub(crate) fn largest_coordinate(shapes: &[PlacedShape]) -> f64 {
    bounds_of(shapes).map_or(0.0, |[low, high]| low.coords.amax().greater(high.coords.amax()))
}

/// The geometry of a link, in its frame.
pub(crate) fn placed(geometry: &[Collision]) -> Vec<PlacedShape> {
    geometry.iter().filter_map(PlacedShape::of).collect()
}

/// True if both lists have the same meshes at the same poses, so that their surfaces are the same points.
pub(crate) fn are_same(a: &[Collision], b: &[Collision]) -> bool {
    let key = |c: &Collision| c.mesh_source.clone().map(|source: MeshSource| (source, c.pose_ls));
    let keys = |list: &[Collision]| list.iter().map(key).collect::<Option<Vec<_>>>();
    match (keys(a), keys(b)) {
        (Some(a), Some(b)) => {
            a.len() == b.len() && a.iter().all(|k| b.contains(k)) && b.iter().all(|k| a.contains(k))
        }
        _ => false,
    }
}
