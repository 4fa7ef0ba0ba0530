//! Pickling of the Python classes: arguments of `__reduce__` with a version, and the object made from them again.
//! States that do not fit are rejected with `Error`.

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::error::{Error, error};

/// Version of the states of all classes.
const VERSION: i64 = 1;

/// Result of `__reduce__`: the function that makes the object again, and its arguments.
pub fn reduced<'py>(
    py: Python<'py>,
    function: &str,
    state: Bound<'py, PyTuple>,
) -> PyResult<Bound<'py, PyAny>> {
    let restore = py.import("clearance._clearance")?.getattr(function)?;
    Ok((restore, (VERSION, state)).into_pyobject(py)?.into_any())
}

/// Makes an object of a class from the arguments that [`reduced`] returned.
pub fn restored<'py, S, T>(
    class: &str,
    arguments: &Bound<'py, PyTuple>,
    make: impl FnOnce(S) -> PyResult<T>,
) -> PyResult<T>
where
    S: for<'a> FromPyObject<'a, 'py>,
{
    let py = arguments.py();
    let version = arguments.get_item(0).and_then(|version| version.extract::<i64>()).ok();
    if arguments.len() != 2 || version != Some(VERSION) {
        let version =
            version.map_or_else(|| "an unknown version".to_owned(), |number| format!("version {number}"));
        return Err(error(format!(
            "this pickle of a {class} is of {version}, but this package reads version {VERSION}: make it again with clearance {}",
            env!("CARGO_PKG_VERSION")
        )));
    }
    let damaged = |why: PyErr| {
        if why.is_instance_of::<Error>(py) {
            why
        } else {
            error(format!("this pickle of a {class} is damaged: {}", why.value(py)))
        }
    };
    let state = arguments.get_item(1)?.extract::<S>().map_err(|why| damaged(why.into()))?;
    make(state).map_err(damaged)
}
