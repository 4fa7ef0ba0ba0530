//! Class `CollisionMatrix`: which pairs of links can collide within the joint limits.

use std::sync::Arc;
use std::time::Instant;

use clearance::checker::Watch;
use clearance::collision_matrix::{
    AllowedPairs, DecidedPair, Decision, MatrixBuilder, MatrixDocument, MatrixOptions, add_disabled_pairs,
};
use clearance::robot::{LinkId, RobotModel};
use clearance::scene::Settings;
use numpy::PyArray1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::batches::run;
use crate::error::error;
use crate::options;
use crate::result_builder::result;
use crate::robot::Robot;
use crate::robot_sources::RobotSources;
use crate::settings::CheckSettings;

/// Settings that change the distance of two links.
const KEYWORDS: [&str; 5] = ["padding", "link_padding", "link_scale", "pad_self", "mesh_model"];

/// Decisions about all pairs of links of a robot with collision geometry, by `Robot.collision_matrix`.
#[pyclass(frozen, module = "clearance")]
#[derive(Debug)]
pub struct CollisionMatrix {
    model: Arc<RobotModel>,
    sources: Arc<RobotSources>,
    settings: Settings,
    document: MatrixDocument,
}

/// Limits of the search, as arguments.
#[derive(Debug)]
pub struct MatrixArguments {
    pub deadline: Option<Instant>,
    pub max_boxes: Option<u64>,
    pub num_threads: Option<usize>,
}

impl CollisionMatrix {
    /// Decides all pairs.
    pub fn compute(
        py: Python<'_>,
        robot: &Robot,
        arguments: &MatrixArguments,
        keywords: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let settings = read_settings(keywords)?;
        let Robot { model, sources, .. } = robot;
        let watch = Watch::default();
        let options = MatrixOptions {
            most_boxes: arguments.max_boxes.unwrap_or(MatrixOptions::MOST_BOXES),
            deadline: arguments.deadline,
            watch: Some(watch.clone()),
            ..MatrixOptions::default()
        };
        let decide = |_: &_| {
            let builder = MatrixBuilder::new(model, &settings)?;
            Ok(builder.decide(&[], &options, &|_| {}))
        };
        let decided = run(py, arguments.num_threads, move || watch.stop(), decide)?;
        let pairs = decided.map_err(|why: clearance::collision_matrix::MatrixFailure| error(why))?;
        let document = MatrixDocument::new(model, &settings, pairs);
        Ok(Self { model: Arc::clone(model), sources: Arc::clone(sources), settings, document })
    }

    fn link(&self, name: &str) -> PyResult<LinkId> {
        let link = self.model.link_by_name(name);
        link.ok_or_else(|| error(format!("allow: the robot has no link '{name}'")))
    }
}

#[pymethods]
impl CollisionMatrix {
    /// One `LinkPair` for each pair, in the order of the links.
    #[getter]
    fn pairs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let pairs = self.document.pairs.iter().map(|pair| link_pair(py, pair));
        PyTuple::new(py, pairs.collect::<PyResult<Vec<_>>>()?)
    }

    /// Names of the positions of the states of the pairs.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.document.joints.clone()
    }

    /// The robot's SRDF with an entry for each pair that never collides, or a new SRDF. All that the text has stays; pairs that it
    /// disables or enables get no second entry.
    ///
    /// `allow`: further pairs of links, with the reason `User`. `allow_adjacent`: also links that are joined by a joint and touch in most
    /// states, with the reason `Adjacent`.
    #[pyo3(signature = (allow=Vec::new(), allow_adjacent=false))]
    fn srdf(
        &self,
        #[pyo3(from_py_with = options::allow)] allow: Vec<(String, String)>,
        allow_adjacent: bool,
    ) -> PyResult<String> {
        let mut allowed = AllowedPairs { adjacent: allow_adjacent, ..AllowedPairs::default() };
        for (a, b) in &allow {
            let links = [self.link(a)?, self.link(b)?];
            allowed.allow(&self.model, links).map_err(|why| error(format!("allow: {why}")))?;
        }
        let entries = allowed.new_entries(&self.document.pairs, Some(&self.model));
        let original = self.sources.srdf.as_ref().map(|srdf| srdf.text.as_str());
        add_disabled_pairs(original, self.model.name(), &entries).map_err(error)
    }

    /// Proofs of the pairs that never collide, or always: one line of JSON, which the command `clearance verify` checks
    /// with code that is independent of this search.
    fn certificate(&self) -> String {
        self.document.certificate_json(&self.model, &self.settings)
    }

    fn __repr__(&self) -> String {
        let count = |name| self.document.pairs.iter().filter(|pair| pair.decision.name() == name).count();
        let [never, always, sometimes, undecided] = ["never", "always", "sometimes", "undecided"].map(count);
        format!(
            "<clearance.CollisionMatrix of '{}': {never} never, {always} always, {sometimes} sometimes, {undecided} undecided>",
            self.document.robot
        )
    }
}

fn read_settings(keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Settings> {
    for (keyword, _) in keywords.into_iter().flatten() {
        let keyword: String = keyword.extract()?;
        if !KEYWORDS.contains(&keyword.as_str()) {
            let text = format!(
                "there is no setting '{keyword}' of a collision matrix; there are {}",
                KEYWORDS.join(", ")
            );
            return Err(PyTypeError::new_err(text));
        }
    }
    Ok(CheckSettings::new(keywords)?.settings)
}

fn link_pair<'py>(py: Python<'py>, pair: &DecidedPair) -> PyResult<Bound<'py, PyAny>> {
    let state = |values: &[f64]| (!values.is_empty()).then(|| PyArray1::from_slice(py, values));
    let (colliding, free, nearest, least_distance) = match &pair.decision {
        Decision::Never { least_distance, .. } => (None, None, None, *least_distance),
        Decision::Always { .. } => (None, None, None, None),
        Decision::Sometimes { colliding, free } => (state(colliding), state(free), None, None),
        Decision::Undecided { least_distance, state: nearest } => {
            (None, None, state(nearest), *least_distance)
        }
    };
    result!(py, "LinkPair",
        links: (&pair.link1, &pair.link2), decision: pair.decision.name(), colliding: colliding, free: free,
        nearest: nearest, least_distance: least_distance, contact_share: pair.contact_share, depth: pair.depth,
        adjacent: pair.is_adjacent)
}
