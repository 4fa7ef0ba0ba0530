//! Inside of a body: its closed meshes with point-in-mesh tests, and a point of each of its connected parts.

use std::sync::Arc;

use clearance_geometry::math::{MatrixPose, Point, Pose};
use clearance_geometry::{InsideGrid, InsideTest, InsideWork, Primitive, Shape, TriangleMesh};

use super::solid_leaf::{Solid, SolidLeaf};
use crate::bounding_volume::Obb;
use crate::bvh::Tree;

/// The closed meshes of a body, and a point of each connected part of the body.
#[derive(Clone, Debug)]
pub(crate) struct Interior {
    closed_meshes: Vec<ClosedMesh>,
    part_points: Vec<Point>,
    decisive_points: Vec<Point>,
}

/// A mesh with an inside, placed in its body.
#[derive(Clone, Debug)]
pub(crate) struct ClosedMesh {
    mesh: Arc<TriangleMesh>,
    pose_bm: Pose,
    pose_mb: MatrixPose,
    bounds: (Point, Point),
    /// The box around the mesh, in the frame of the body.
    outline: Tree<Obb, SolidLeaf>,
}

impl Interior {
    pub fn new(shapes: &[(&Pose, &Shape)]) -> Self {
        let mut interior =
            Self { closed_meshes: Vec::new(), part_points: Vec::new(), decisive_points: Vec::new() };
        for &(pose, shape) in shapes {
            match shape {
                // no closed mesh contains a plane; cubes are searched in their tree
                Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => {}
                Shape::Primitive(_) => {
                    interior.part_points.push(Point::from(pose.translation.vector));
                    interior.decisive_points.push(Point::from(pose.translation.vector));
                }
                Shape::Mesh(mesh) => {
                    let points = mesh.part_points();
                    interior.part_points.extend(points.iter().map(|p| pose * p));
                    interior.decisive_points.extend(decisive_points(mesh, points).iter().map(|p| pose * p));
                    if !mesh.solid().surfaces().is_empty() {
                        interior.closed_meshes.push(ClosedMesh::new(mesh, pose));
                    }
                }
            }
        }
        interior
    }

    /// The meshes that are solid.
    #[inline]
    pub fn closed_meshes(&self) -> &[ClosedMesh] {
        &self.closed_meshes
    }

    /// A point of each connected part of the body, in its frame.
    #[inline]
    pub fn part_points(&self) -> &[Point] {
        &self.part_points
    }

    /// Points (frame of the body) that decide whether one of two bodies, whose surfaces are apart, has a part inside the other: this is so
    /// if and only if one of these points of either body is inside the other.
    #[inline]
    pub fn decisive_points(&self) -> &[Point] {
        &self.decisive_points
    }

    /// False if a point (frame of the body) is certainly outside of all closed meshes, found without computing a winding number.
    #[inline]
    pub fn may_contain(&self, point: &Point) -> bool {
        self.closed_meshes.iter().any(|mesh| mesh.mesh.may_enclose(&(&mesh.pose_mb * *point)))
    }
}

impl ClosedMesh {
    fn new(mesh: &Arc<TriangleMesh>, pose_bm: &Pose) -> Self {
        mesh.prepare_solid();
        let (low, high) = mesh.bounds();
        let half = 0.5 * (high - low);
        let primitive = Primitive::Box { half_extents: half.into() };
        let centre = Pose::from_parts((low + half).coords.into(), nalgebra::one());
        let outline = Solid { primitive, pose: pose_bm * centre };
        Self {
            mesh: Arc::clone(mesh),
            pose_bm: *pose_bm,
            pose_mb: MatrixPose::from(pose_bm).inverse(),
            bounds: (low, high),
            outline: Tree::build(&[outline]).0,
        }
    }

    /// Pose of the mesh in the frame of its body.
    #[inline]
    pub fn pose_bm(&self) -> &Pose {
        &self.pose_bm
    }

    /// The box around the mesh, in the frame of its body.
    #[inline]
    pub fn outline(&self) -> &Tree<Obb, SolidLeaf> {
        &self.outline
    }

    /// Grid of the cells that may be inside, in the frame of the mesh.
    pub fn inside_grid(&self) -> Option<&Arc<InsideGrid>> {
        self.mesh.inside_grid()
    }

    #[inline]
    pub fn test(&self) -> MeshTest<'_> {
        MeshTest { mesh: self, inside: InsideTest::new(&self.mesh) }
    }
}

/// Tests points against one mesh.
pub(crate) struct MeshTest<'i> {
    mesh: &'i ClosedMesh,
    inside: InsideTest<'i>,
}

impl MeshTest<'_> {
    /// True if a point (frame of the mesh's body) is inside.
    #[inline]
    pub fn contains(&mut self, point_b: &Point) -> bool {
        let p = &self.mesh.pose_mb * *point_b;
        let (lo, hi) = self.mesh.bounds;
        (0..3).all(|i| (lo[i]..=hi[i]).contains(&p[i])) && self.inside.encloses(&p)
    }

    /// Number of steps since the last call, without those for points outside of the box around the mesh.
    #[inline]
    pub fn take_work(&mut self) -> InsideWork {
        self.inside.take_work()
    }
}

/// Decisive points of a mesh: where it has only one connected part, a point well inside it, if one is known.
///
/// Let a connected part C of one body be inside a mesh M of another, and x a point that C encloses. Where x is not inside M, a connected
/// part of M is wholly inside C. Then M has several parts, as it is around C, too; and of a mesh with several parts, all have a point of
/// their own here.
fn decisive_points(mesh: &TriangleMesh, part_points: Vec<Point>) -> Vec<Point> {
    match mesh.inner_point() {
        Some(inner) if part_points.len() == 1 => vec![inner],
        _ => part_points,
    }
}
