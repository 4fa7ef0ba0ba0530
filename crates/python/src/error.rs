//! Errors: texts of the library in one Python exception, and warnings about accepted input.

use std::fmt::Display;

use clearance_bindings::with_package_paths;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

pyo3::create_exception!(
    clearance,
    Error,
    PyValueError,
    "Input that the library rejects: a robot, a world, a setting, joint positions. The text names the element and what to do."
);

/// The exception with the text of an error of the library.
pub fn error(text: impl Display) -> PyErr {
    Error::new_err(with_package_paths(&text.to_string(), "package_paths"))
}

/// Emits one Python warning of the class `clearance.InputWarning` per text.
pub fn warn(py: Python<'_>, texts: impl IntoIterator<Item = impl Display>) -> PyResult<()> {
    for text in texts {
        let category = py.import("clearance._results")?.getattr("InputWarning")?;
        py.import("warnings")?.call_method1("warn", (text.to_string(), category, 1))?;
    }
    Ok(())
}
