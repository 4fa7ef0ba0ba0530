//! Shapes from Python arguments: primitives, planes, meshes, mesh files, points and voxels.

use std::path::Path;
use std::sync::Arc;

use clearance::geometry::math::{Extremes, Point, Vector};
use clearance::geometry::{Cube, Plane, Primitive, PrimitiveError, Shape, TriangleMesh, Voxels};
use clearance::robot::MeshFiles;
use clearance::scene::CloudPoints;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{Numbers, wrong_shape};
use crate::error::error;

/// A primitive, or the error about its dimensions.
pub fn primitive(made: Result<Primitive, PrimitiveError>) -> PyResult<Shape> {
    made.map(Shape::Primitive).map_err(error)
}

/// The plane of all points p with `normal · p = offset`; the normal has any length above 0.
pub fn plane(normal: [f64; 3], offset: f64) -> PyResult<Shape> {
    let [a, b, c] = normal;
    Plane::from_coefficients([a, b, c, -offset]).map(Shape::Plane).map_err(error)
}

/// A mesh of vertices (N, 3) and faces (M, 3).
pub fn mesh(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<Shape> {
    let vertices = Numbers::new(vertices, "vertices")?.rows_of_three("vertices")?;
    let mesh = TriangleMesh::new(vertices.into_iter().map(Point::from).collect(), triangles(faces)?);
    mesh.map(|mesh| Shape::Mesh(Arc::new(mesh))).map_err(error)
}

fn triangles(faces: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    let numbers = Numbers::new(faces, "faces")?;
    let index = |number: f64| {
        if number.fract() != 0.0 {
            return Err(PyTypeError::new_err(format!(
                "faces must be indices of vertices, but one is {number}"
            )));
        }
        if !(0.0..=f64::from(u32::MAX)).contains(&number) {
            return Err(PyValueError::new_err(format!(
                "faces must be indices of vertices from 0, but one is {number}"
            )));
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked above
        Ok(number as u32)
    };
    let rows = numbers.rows_of_three("faces")?;
    rows.into_iter().map(|[a, b, c]| Ok([index(a)?, index(b)?, index(c)?])).collect()
}

/// A mesh file, scaled; with remarks about it.
pub fn mesh_file(path: &Path, scale: [f64; 3]) -> PyResult<(Shape, Vec<String>)> {
    let absolute = std::path::absolute(path).map_err(|why| error(format!("{}: {why}", path.display())))?;
    let folder = absolute.parent().unwrap_or(&absolute);
    let name = absolute.to_str().ok_or_else(|| error(format!("{}: the path is no UTF-8", path.display())))?;
    let loaded = MeshFiles::under(folder).load(&escaped(name), Vector::from(scale)).map_err(error)?;
    Ok((Shape::Mesh(loaded.mesh), loaded.remarks))
}

/// A mesh name in which nothing is taken for an escape.
fn escaped(path: &str) -> String {
    path.replace('%', "%25")
}

/// Balls of one radius (m) around points (N, 3). Points are kept as 32-bit floats; the balls are larger by what is lost.
pub fn points(xyz: &Bound<'_, PyAny>, radius: f64) -> PyResult<Shape> {
    let points = Numbers::new(xyz, "xyz")?.rows_of_three("xyz")?;
    if let Some(index) = points.iter().position(|point| !point.iter().all(|c| c.is_finite())) {
        return Err(PyValueError::new_err(format!(
            "xyz[{index}] is {:?}, which is not finite: leave such points out, with xyz[numpy.isfinite(xyz).all(axis=1)]",
            points[index]
        )));
    }
    let mut cloud = CloudPoints::default();
    for point in points {
        cloud.push(point).map_err(error)?;
    }
    let cloud = cloud.cloud(radius).map_err(error)?;
    cloud.map(Shape::Points).ok_or_else(|| error("xyz has no points"))
}

/// Cubes of one edge length (m) around centres (N, 3). Centres are kept as 32-bit floats; the cubes are larger by what is lost.
pub fn voxels(centres: &Bound<'_, PyAny>, edge: f64) -> PyResult<Shape> {
    let centres = Numbers::new(centres, "centres")?.rows_of_three("centres")?;
    let cubes = centres.into_iter().map(|centre| {
        #[allow(clippy::cast_possible_truncation)] // what is lost is added
        let rounded = centre.map(|c| c as f32);
        let lost = (0..3).map(|k| (centre[k] - f64::from(rounded[k])).abs()).fold(0.0, f64::greater);
        let half = 0.5 * edge + lost;
        #[allow(clippy::cast_possible_truncation)] // rounded up
        let half_edge = half as f32;
        let half_edge = if f64::from(half_edge) < half { half_edge.next_up() } else { half_edge };
        Cube { centre: rounded, half_edge }
    });
    Voxels::new(cubes.collect()).map(|voxels| Shape::Voxels(Arc::new(voxels))).map_err(error)
}

/// One factor, or one for each axis.
pub fn scale(scale: Option<&Bound<'_, PyAny>>) -> PyResult<[f64; 3]> {
    let Some(scale) = scale else { return Ok([1.0; 3]) };
    let numbers = Numbers::new(scale, "scale")?;
    match *numbers.values() {
        [factor] => Ok([factor; 3]),
        [x, y, z] => Ok([x, y, z]),
        _ => Err(wrong_shape("scale", numbers.shape(), "must be a number or (3,)")),
    }
}
