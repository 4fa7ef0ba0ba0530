//! Class `ShapeCover`: capsules or boxes that contain the links.

use std::sync::Arc;

use clearance::covers::{self, CoverShape, LinkShapes, ShapeKind, ShapeSize};
use clearance::robot::RobotModel;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays::array;
use crate::error::error;
use crate::poses::matrix;
use crate::result_builder::result;
use crate::robot::Robot;
use crate::robot_sources::RobotSources;
use crate::sphere_cover::SearchArguments;

/// Capsules or boxes of the links of a robot, by `Robot.shape_cover`.
#[pyclass(frozen, module = "clearance")]
#[derive(Debug)]
pub struct ShapeCover {
    model: Arc<RobotModel>,
    sources: Arc<RobotSources>,
    cover: covers::ShapeCover,
    kind: ShapeKind,
}

/// Reads the kind of shapes.
pub fn kind(shape: &str) -> PyResult<ShapeKind> {
    match shape {
        "capsules" => Ok(ShapeKind::Capsule),
        "boxes" => Ok(ShapeKind::Box),
        other => {
            let text =
                format!("shape must be 'capsules' or 'boxes', not '{other}'; for spheres, call sphere_cover");
            Err(PyValueError::new_err(text))
        }
    }
}

impl ShapeCover {
    /// Searches a cover of at most `count` shapes for each link.
    pub fn compute(
        py: Python<'_>,
        robot: &Robot,
        kind: ShapeKind,
        count: usize,
        search: &SearchArguments,
    ) -> PyResult<Self> {
        let Robot { model, sources, .. } = robot;
        let cover = search.run(py, |limit| covers::shape_cover(model, kind, count, limit, &|_| ()))?;
        let cover = cover.map_err(error)?;
        Ok(Self { model: Arc::clone(model), sources: Arc::clone(sources), cover, kind })
    }
}

#[pymethods]
impl ShapeCover {
    /// One `LinkShapes` for each link with collision geometry, in the order of `Robot.link_names`.
    #[getter]
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let links = self.cover.links.iter().map(|link| self.link(py, link));
        PyTuple::new(py, links.collect::<PyResult<Vec<_>>>()?)
    }

    /// `capsules` or `boxes`.
    #[getter]
    fn shape(&self) -> &'static str {
        match self.kind {
            ShapeKind::Capsule => "capsules",
            ShapeKind::Box => "boxes",
        }
    }

    /// Proven bound (m) for all links on the distance of a point of the shapes from its link.
    #[getter]
    fn largest_excess(&self) -> f64 {
        self.cover.largest_excess()
    }

    /// True if `timeout` ended the search of a link: more time can give less excess. What is returned is proven nevertheless.
    #[getter]
    fn ended_by_time(&self) -> bool {
        self.cover.is_cut()
    }

    /// The robot's URDF with the shapes as collision geometry, a capsule as a cylinder and two spheres; all else is unchanged.
    fn to_urdf(&self) -> PyResult<String> {
        covers::shape_urdf(&self.model, &self.cover, &self.sources.urdf.text).map_err(error)
    }

    /// Number of shapes.
    fn __len__(&self) -> usize {
        self.cover.count()
    }

    fn __repr__(&self) -> String {
        let counted = |count: usize, names: [&str; 2]| format!("{count} {}", names[usize::from(count != 1)]);
        let names = match self.kind {
            ShapeKind::Capsule => ["capsule", "capsules"],
            ShapeKind::Box => ["box", "boxes"],
        };
        format!(
            "<clearance.ShapeCover of '{}': {} around {}, excess at most {:.2} mm>",
            self.model.name(),
            counted(self.cover.count(), names),
            counted(self.cover.links.len(), ["link", "links"]),
            (1e5 * self.cover.largest_excess()).ceil() / 100.0
        )
    }
}

impl ShapeCover {
    fn link<'py>(&self, py: Python<'py>, link: &LinkShapes) -> PyResult<Bound<'py, PyAny>> {
        let count = link.shapes.len();
        let poses = link.shapes.iter().flat_map(|(shape, _)| matrix(&shape.pose_ls())).collect();
        let sizes: Vec<f64> = link.shapes.iter().flat_map(|(shape, _)| sizes(shape)).collect();
        let columns = match self.kind {
            ShapeKind::Capsule => 2,
            ShapeKind::Box => 3,
        };
        let excesses = link.shapes.iter().map(|(_, excess)| *excess).collect();
        result!(py, "LinkShapes",
            link: &self.model.link(link.link).name, poses: array::<f64>(py, poses, &[count, 4, 4])?,
            sizes: array(py, sizes, &[count, columns])?, excesses: array::<f64>(py, excesses, &[count])?,
            excess: (link.excess[0], link.excess[1]), ended_by_time: link.is_cut)
    }
}

/// Radius and length of the segment (m) of a capsule, edges (m) of a box.
fn sizes(shape: &CoverShape) -> Vec<f64> {
    match shape.size {
        ShapeSize::Capsule { radius, half_length } => vec![radius, 2.0 * half_length],
        ShapeSize::Box { half_extents } => half_extents.map(|half| 2.0 * half).to_vec(),
    }
}
