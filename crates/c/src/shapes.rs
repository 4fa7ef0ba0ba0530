//! Conversion of C meshes, point arrays and mesh files to shapes.

use std::path::Path;
use std::sync::Arc;

use clearance::geometry::math::{Point, Vector};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::robot::MeshFiles;
use clearance::scene::CloudPoints;

use crate::arguments::Arguments;
use crate::status::{Failure, Outcome};

/// A triangle mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_mesh {
    /// vertex_count x 3 coordinates (m).
    pub vertices: *const f64,
    /// Number of vertices.
    pub vertex_count: usize,
    /// triangle_count x 3 indices of vertices, from 0.
    pub triangles: *const u32,
    /// Number of triangles.
    pub triangle_count: usize,
}

/// Points.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_points {
    /// count x 3 coordinates (m).
    pub xyz: *const f64,
    /// Number of points.
    pub count: usize,
}

fn rows_of_three<T: Copy>(values: &[T]) -> impl Iterator<Item = [T; 3]> {
    values.chunks_exact(3).map(|row| [row[0], row[1], row[2]])
}

/// A mesh.
pub fn mesh(arguments: Arguments<'_>, mesh: clearance_mesh) -> Outcome<Shape> {
    let vertices = arguments.array(mesh.vertices, mesh.vertex_count.saturating_mul(3), "mesh.vertices")?;
    let triangles =
        arguments.array(mesh.triangles, mesh.triangle_count.saturating_mul(3), "mesh.triangles")?;
    let mesh = TriangleMesh::new(
        rows_of_three(vertices).map(Point::from).collect(),
        rows_of_three(triangles).collect(),
    );
    mesh.map(|mesh| Shape::Mesh(Arc::new(mesh))).map_err(Failure::rejected)
}

/// A mesh file, scaled; with remarks about it.
pub fn mesh_file(path: &Path, scale: [f64; 3]) -> Outcome<(Shape, Vec<String>)> {
    let absolute =
        std::path::absolute(path).map_err(|why| Failure::rejected(format!("{}: {why}", path.display())))?;
    if !absolute.is_file() {
        return Err(Failure::rejected(format!(
            "there is no mesh file {}: give an absolute path, or one relative to the working directory",
            absolute.display()
        )));
    }
    let folder = absolute.parent().unwrap_or(&absolute);
    // a mesh name in which nothing is taken for an escape
    let name = absolute.to_string_lossy().replace('%', "%25");
    let loaded = MeshFiles::under(folder).load(&name, Vector::from(scale)).map_err(Failure::rejected)?;
    Ok((Shape::Mesh(loaded.mesh), loaded.remarks))
}

/// Balls of one radius (m) around points. Points are kept as 32-bit floats; the balls are larger by what is lost.
pub fn points(arguments: Arguments<'_>, points: clearance_points, radius: f64) -> Outcome<Shape> {
    let values = arguments.array(points.xyz, points.count.saturating_mul(3), "points.xyz")?;
    let mut cloud = CloudPoints::default();
    for (i, point) in rows_of_three(values).enumerate() {
        if !point.iter().all(|c| c.is_finite()) {
            return Err(Failure::rejected(format!(
                "point {i} is {point:?}, which is not finite: leave such points out"
            )));
        }
        cloud.push(point).map_err(Failure::rejected)?;
    }
    let cloud = cloud.cloud(radius).map_err(Failure::rejected)?;
    cloud.map(Shape::Points).ok_or_else(|| Failure::rejected("there are no points"))
}
