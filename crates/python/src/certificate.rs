//! Class `Certificate`: the proof that a motion is free, read from and written to JSON.

use std::path::PathBuf;
use std::sync::Arc;

use clearance_files::input_files::{self, STATES_LIMIT};
use pyo3::prelude::*;

use crate::error::error;

/// A proof that a motion is free, for one robot in one world: `verify` checks it with code that is independent of the checker.
///
/// It is the document that `clearance motion --certificate` writes.
#[pyclass(frozen, eq, module = "clearance")]
#[derive(Debug, PartialEq)]
pub struct Certificate {
    pub inner: Arc<clearance::Certificate>,
}

#[pymethods]
impl Certificate {
    /// A certificate from JSON text. Raises `Error` if this is none, or if something in it was altered.
    #[new]
    fn new(json: &str) -> PyResult<Self> {
        let inner = clearance::Certificate::from_json(json).map_err(error)?;
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Reads a file that `save` or `clearance motion --certificate` has written.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let text = input_files::read_text(&path, STATES_LIMIT).map_err(error)?;
        Self::new(&text).map_err(|why| error(format!("{}: {why}", path.display())))
    }

    /// Writes the certificate as one line of JSON.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        input_files::write(&path, (self.to_json() + "\n").as_bytes()).map_err(error)
    }

    /// One line of JSON.
    fn to_json(&self) -> String {
        self.inner.to_json()
    }

    /// Name of the robot.
    #[getter]
    fn robot(&self) -> &str {
        &self.inner.robot
    }

    /// Names of the positions of the motion: those of the whole robot.
    #[getter]
    fn joint_names(&self) -> Vec<String> {
        self.inner.joints.clone()
    }

    /// Names of the pairs of bodies that are proven apart.
    #[getter]
    fn pairs(&self) -> Vec<(String, String)> {
        self.inner.pairs.iter().map(|[a, b]| (a.clone(), b.clone())).collect()
    }

    /// Number of segments of the motion.
    #[getter]
    fn segments(&self) -> usize {
        self.inner.segments.len()
    }

    /// Distance (m) that every pair is proven to keep, besides its padding.
    #[getter]
    fn margin(&self) -> f64 {
        self.inner.kept_margin()
    }

    /// Tolerance (m) of the check; None for the first version of the format.
    #[getter]
    fn tolerance(&self) -> Option<f64> {
        self.inner.tolerance
    }

    fn __repr__(&self) -> String {
        let (robot, pairs) = (&self.inner.robot, self.inner.pairs.len());
        format!("<clearance.Certificate of '{robot}': {} segments, {pairs} pairs>", self.inner.segments.len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok((py.get_type::<Self>(), (self.to_json(),)).into_pyobject(py)?.into_any())
    }
}
