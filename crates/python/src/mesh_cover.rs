//! Class `MeshCover`: simplified collision meshes of the links.

use std::sync::Arc;

use clearance::covers::{self, CoverSize, LinkMeshes, SimplifiedMesh};
use clearance::geometry::math::Pose;
use clearance::robot::RobotModel;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};

use crate::arrays::array;
use crate::error::error;
use crate::poses::matrix;
use crate::result_builder::{result, xyz};
use crate::robot::Robot;
use crate::robot_sources::RobotSources;
use crate::sphere_cover::SearchArguments;

/// Simplified collision meshes of the links of a robot, by `Robot.mesh_cover`.
#[pyclass(frozen, module = "clearance")]
#[derive(Debug)]
pub struct MeshCover {
    model: Arc<RobotModel>,
    sources: Arc<RobotSources>,
    cover: covers::MeshCover,
}

/// Reads how many triangles, or how much error.
pub fn size(count: Option<usize>, excess: Option<f64>) -> PyResult<CoverSize> {
    match (count, excess) {
        (Some(count), None) => Ok(CoverSize::PerLink(count)),
        (None, Some(excess)) => Ok(CoverSize::Excess(excess)),
        _ => Err(PyTypeError::new_err("give one of count and excess")),
    }
}

impl MeshCover {
    /// Simplifies the meshes of all links.
    pub fn compute(
        py: Python<'_>,
        robot: &Robot,
        size: &CoverSize,
        search: &SearchArguments,
    ) -> PyResult<Self> {
        let Robot { model, sources, .. } = robot;
        let cover = search.run(py, |limit| covers::mesh_cover(model, size, limit, &|_| ()))?;
        let cover = cover.map_err(error)?;
        Ok(Self { model: Arc::clone(model), sources: Arc::clone(sources), cover })
    }
}

#[pymethods]
impl MeshCover {
    /// One `LinkMeshes` for each link with a collision mesh, in the order of `Robot.link_names`.
    #[getter]
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let links = self.cover.links.iter().map(|link| self.link(py, link));
        PyTuple::new(py, links.collect::<PyResult<Vec<_>>>()?)
    }

    /// Number of triangles of all meshes.
    #[getter]
    fn triangles(&self) -> usize {
        self.cover.triangles()
    }

    /// Number of triangles of the original meshes.
    #[getter]
    fn original_triangles(&self) -> usize {
        self.cover.original_triangles()
    }

    /// Proven bound (m) for all meshes on the Hausdorff distance from the original one.
    #[getter]
    fn largest_error(&self) -> f64 {
        self.cover.error()[1]
    }

    /// True if `timeout` ended the search of a link: more time can give fewer triangles, or less error.
    #[getter]
    fn ended_by_time(&self) -> bool {
        self.cover.is_cut()
    }

    /// The meshes as binary STL files, by `SimplifiedMesh.file_name`.
    #[getter]
    fn files<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let files = PyDict::new(py);
        for SimplifiedMesh { mesh, file_name, .. } in self.cover.links.iter().flat_map(|link| &link.meshes) {
            files.set_item(file_name, PyBytes::new(py, &covers::stl(mesh)))?;
        }
        Ok(files)
    }

    /// The robot's URDF with the STL files in `folder` as collision meshes; all else is unchanged.
    ///
    /// `folder` is as in the mesh names of a URDF: relative to the folder of the URDF, absolute, or with `package://`.
    fn to_urdf(&self, folder: &str) -> PyResult<String> {
        if folder.is_empty() || folder.contains(char::is_control) {
            let text = "folder must be the name of a folder, as in the mesh names of a URDF; \
                        '.' is that of the URDF itself";
            return Err(error(text));
        }
        covers::mesh_urdf(&self.model, &self.cover, &self.sources.urdf.text, folder).map_err(error)
    }

    /// Number of meshes.
    fn __len__(&self) -> usize {
        self.cover.links.iter().map(|link| link.meshes.len()).sum()
    }

    fn __repr__(&self) -> String {
        format!(
            "<clearance.MeshCover of '{}': {} of {} triangles, error at most {:.2} mm>",
            self.model.name(),
            self.cover.triangles(),
            self.cover.original_triangles(),
            (1e5 * self.cover.error()[1]).ceil() / 100.0
        )
    }
}

impl MeshCover {
    fn link<'py>(&self, py: Python<'py>, link: &LinkMeshes) -> PyResult<Bound<'py, PyAny>> {
        let described = self.model.link(link.link);
        let meshes = link.meshes.iter().map(|mesh| {
            let pose_ls = &described.collisions[mesh.collision].pose_ls;
            simplified_mesh(py, mesh, pose_ls)
        });
        let meshes = PyTuple::new(py, meshes.collect::<PyResult<Vec<_>>>()?)?;
        let ([lower, upper], point) = (link.error(), link.point().unwrap_or_default());
        result!(py, "LinkMeshes",
            link: &described.name, meshes: meshes, error: (lower, upper),
            point: array(py, xyz(&point).to_vec(), &[3])?, ended_by_time: link.is_cut)
    }
}

fn simplified_mesh<'py>(
    py: Python<'py>,
    simplified: &SimplifiedMesh,
    pose_ls: &Pose,
) -> PyResult<Bound<'py, PyAny>> {
    let (vertices, faces) = (simplified.mesh.vertices(), simplified.mesh.triangles());
    let coordinates: Vec<f64> = vertices.iter().flat_map(xyz).collect();
    let corners: Vec<i64> = faces.iter().flatten().map(|corner| i64::from(*corner)).collect();
    let [lower, upper] = simplified.error;
    result!(py, "SimplifiedMesh",
        collision: simplified.collision, pose: array(py, matrix(pose_ls).to_vec(), &[4, 4])?,
        vertices: array(py, coordinates, &[vertices.len(), 3])?,
        faces: array(py, corners, &[faces.len(), 3])?, original_triangles: simplified.original_triangles,
        error: (lower, upper), file_name: &simplified.file_name)
}
