//! Warnings about meshes of robot and world that were repaired to be solids, or are treated as surfaces.

use std::sync::Arc;

use clearance_geometry::{Shape, TriangleMesh};
use clearance_robot::RobotModel;
use clearance_scene::World;
use rayon::prelude::*;

/// A mesh, with the remarks on its use as a solid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SolidMeshRemark {
    /// Name of the mesh, such as `mesh 0 of object 'shelf'`.
    pub mesh: String,
    /// True if the whole mesh is treated as a surface.
    pub is_surface: bool,
    /// The remark.
    pub text: String,
}

impl std::fmt::Display for SolidMeshRemark {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.mesh, self.text)
    }
}

/// Meshes of the robot, obstacles and attached objects that were repaired to be solids, or that stay surfaces at least
/// in part.
#[must_use]
pub fn solid_mesh_remarks(robot: &RobotModel, world: &World) -> Vec<SolidMeshRemark> {
    let of_links = robot.links().iter().flat_map(|link| {
        let named = |i| format!("mesh of link '{}' (collision {i})", link.name);
        meshes(link.collisions.iter().map(|c| &c.shape)).map(move |(i, mesh)| (named(i), mesh))
    });
    let of_obstacles = world.obstacles().flat_map(|obstacle| {
        let named = |i| format!("mesh {i} of object '{}'", obstacle.name);
        meshes(obstacle.shapes.iter().map(|s| &s.shape)).map(move |(i, mesh)| (named(i), mesh))
    });
    let of_attached = world.attached().iter().flat_map(|object| {
        let named = |i| format!("mesh {i} of attached object '{}'", object.name);
        meshes(object.shapes.iter().map(|s| &s.shape)).map(move |(i, mesh)| (named(i), mesh))
    });
    let all: Vec<_> = of_links.chain(of_obstacles).chain(of_attached).collect();
    let remark = |(mesh, shape): (String, &Arc<TriangleMesh>)| {
        let remarks = shape.solid().remarks();
        let (is_surface, text) = (shape.solid().surfaces().is_empty(), remarks.to_string());
        (!remarks.is_empty()).then_some(SolidMeshRemark { mesh, is_surface, text })
    };
    all.into_par_iter().filter_map(remark).collect()
}

fn meshes<'s>(
    shapes: impl Iterator<Item = &'s Shape>,
) -> impl Iterator<Item = (usize, &'s Arc<TriangleMesh>)> {
    shapes.enumerate().filter_map(|(i, shape)| match shape {
        Shape::Mesh(mesh) => Some((i, mesh)),
        _ => None,
    })
}
