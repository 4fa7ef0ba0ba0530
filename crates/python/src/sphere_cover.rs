//! Class `SphereCover`: spheres that contain the links, or lie inside of them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use clearance::covers::{self, CoverSize, LinkCover, MeasuredLink, SearchLimit};
use clearance::robot::{LinkId, RobotModel};
use numpy::PyArrayDyn;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::array;
use crate::batches::run;
use crate::error::error;
use crate::result_builder::result;
use crate::robot::Robot;
use crate::robot_sources::RobotSources;

/// Spheres of the links of a robot, by `Robot.sphere_cover`.
#[pyclass(frozen, module = "clearance")]
#[derive(Debug)]
pub struct SphereCover {
    model: Arc<RobotModel>,
    sources: Arc<RobotSources>,
    cover: covers::SphereCover,
    is_inner: bool,
}

/// How many spheres, as arguments.
#[derive(Debug)]
pub struct SizeArguments {
    pub count: Option<usize>,
    pub total: Option<usize>,
    pub excess: Option<f64>,
    pub counts: Option<BTreeMap<String, usize>>,
}

/// Limits of a search, as arguments.
#[derive(Debug)]
pub struct SearchArguments {
    pub deadline: Option<Instant>,
    pub num_threads: Option<usize>,
}

impl SearchArguments {
    /// Runs a search, which Ctrl-C ends.
    pub fn run<T: Send>(&self, py: Python<'_>, search: impl FnOnce(&SearchLimit) -> T + Send) -> PyResult<T> {
        let limit = self.deadline.map_or_else(SearchLimit::default, SearchLimit::until);
        let copy = limit.clone();
        run(py, self.num_threads, move || copy.stop(), |_| search(&limit))
    }
}

impl SizeArguments {
    fn size(&self, robot: &RobotModel) -> PyResult<CoverSize> {
        match (self.count, self.total, self.excess, &self.counts) {
            (Some(count), None, None, None) => Ok(CoverSize::PerLink(count)),
            (None, Some(total), None, None) => Ok(CoverSize::Total(total)),
            (None, None, Some(excess), None) => Ok(CoverSize::Excess(excess)),
            (None, None, None, Some(counts)) => links_with_counts(robot, counts).map(CoverSize::Links),
            _ => Err(PyTypeError::new_err("give one of count, total, excess and counts")),
        }
    }
}

/// The number of each link. A link without spheres would not be covered.
fn links_with_counts(robot: &RobotModel, counts: &BTreeMap<String, usize>) -> PyResult<Vec<(LinkId, usize)>> {
    if let Some(name) = counts.keys().find(|name| robot.link_by_name(name).is_none()) {
        return Err(error(format!("counts: the robot has no link '{name}'")));
    }
    let with_geometry = robot.link_ids().filter(|id| !robot.link(*id).collisions.is_empty());
    let counted = with_geometry.map(|id| {
        let name = &robot.link(id).name;
        let missing =
            || error(format!("counts has no number for link '{name}', which has collision geometry"));
        Ok((id, *counts.get(name).ok_or_else(missing)?))
    });
    counted.collect()
}

impl SphereCover {
    /// Searches a cover.
    pub fn compute(
        py: Python<'_>,
        robot: &Robot,
        size: &SizeArguments,
        is_inner: bool,
        search: &SearchArguments,
    ) -> PyResult<Self> {
        let Robot { model, sources, .. } = robot;
        let size = size.size(model)?;
        let cover = search.run(py, |limit| {
            if is_inner {
                covers::inner_sphere_cover(model, &size, limit, &|_| ())
            } else {
                covers::sphere_cover(model, &size, limit, &|_| ())
            }
        })?;
        let cover = cover.map_err(error)?;
        Ok(Self { model: Arc::clone(model), sources: Arc::clone(sources), cover, is_inner })
    }

    fn name(&self, link: &LinkCover) -> &str {
        &self.model.link(link.link).name
    }
}

#[pymethods]
impl SphereCover {
    /// One `LinkSpheres` for each link with collision geometry, in the order of `Robot.link_names`.
    #[getter]
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let links = self.cover.links.iter().map(|link| {
            let excesses: Vec<f64> = link.spheres.iter().map(|sphere| sphere.excess).collect();
            let excesses = array(py, excesses, &[link.spheres.len()])?;
            let [excess, depth] = if self.is_inner { [[0.0; 2], link.error] } else { [link.error, [0.0; 2]] };
            result!(py, "LinkSpheres",
                link: self.name(link), spheres: spheres(py, link)?, excesses: excesses, excess: (excess[0], excess[1]),
                uncovered_depth: (depth[0], depth[1]), ended_by_time: link.is_cut)
        });
        PyTuple::new(py, links.collect::<PyResult<Vec<_>>>()?)
    }

    /// Spheres by name of the link: centre in the link frame and radius (m), shape (N, 4).
    #[getter]
    fn spheres<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let result = PyDict::new(py);
        for link in &self.cover.links {
            result.set_item(self.name(link), spheres(py, link)?)?;
        }
        Ok(result)
    }

    /// True if the spheres lie inside of the links, false if they contain the links.
    #[getter]
    fn inner(&self) -> bool {
        self.is_inner
    }

    /// Proven bound (m) for all links: on the distance of a point of the spheres from its link, or, for spheres inside, on the depth of a
    /// point in no sphere.
    #[getter]
    fn largest_error(&self) -> f64 {
        self.cover.largest_error()
    }

    /// True if `timeout` ended the search of a link: more time can give a smaller error, and an excess that was asked for may not be
    /// reached. What is returned is proven nevertheless.
    #[getter]
    fn ended_by_time(&self) -> bool {
        self.cover.is_cut()
    }

    /// The robot's URDF with the spheres as collision geometry, as VAMP and foam read it; all else is unchanged.
    fn to_urdf(&self) -> PyResult<String> {
        covers::sphere_urdf(&self.model, &self.cover, &self.sources.urdf.text).map_err(error)
    }

    /// YAML text with `collision_spheres`, as a configuration of cuRobo names it.
    fn to_curobo(&self) -> String {
        covers::curobo_yaml(&self.model, &self.cover)
    }

    /// XRDF 1.0 text for Isaac; check its limits and tool frames, which URDF does not have.
    fn to_xrdf(&self) -> String {
        covers::xrdf(&self.model, &self.cover)
    }

    /// Number of spheres.
    fn __len__(&self) -> usize {
        self.cover.count()
    }

    fn __repr__(&self) -> String {
        let what = if self.is_inner { "inside of" } else { "around" };
        format!(
            "<clearance.SphereCover of '{}': {} spheres {what} {} links, error at most {:.2} mm>",
            self.model.name(),
            self.cover.count(),
            self.cover.links.len(),
            (1e5 * self.cover.largest_error()).ceil() / 100.0
        )
    }
}

fn spheres<'py>(py: Python<'py>, link: &LinkCover) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let rows = link.spheres.iter().flat_map(|s| [s.centre.x, s.centre.y, s.centre.z, s.radius]);
    array(py, rows.collect(), &[link.spheres.len(), 4])
}

/// Measures a robot whose collision geometry is spheres beside another one.
pub fn measure<'py>(
    py: Python<'py>,
    robot: &Robot,
    spheres: &Robot,
    search: &SearchArguments,
) -> PyResult<Bound<'py, PyTuple>> {
    let measured = search.run(py, |limit| covers::measure_spheres(&robot.model, &spheres.model, limit))?;
    let links = measured.map_err(error)?.links;
    let of_link = |link: &MeasuredLink| {
        let (area, excess) = (link.uncovered, link.excess);
        result!(py, "MeasuredSpheres",
            link: &robot.model.link(link.link).name, count: link.spheres, excess: (excess[0], excess[1]),
            uncovered_area: (area.lower, area.upper), surface_area: area.total)
    };
    PyTuple::new(py, links.iter().map(of_link).collect::<PyResult<Vec<_>>>()?)
}
