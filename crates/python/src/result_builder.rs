//! Builds instances of the Python result dataclasses (`clearance._results`) from named fields.

use clearance::CollisionChecker;
use clearance::geometry::math::Point;
use clearance::scene::BodyId;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An instance of a result class.
pub fn make<'py>(py: Python<'py>, class: &str, fields: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyAny>> {
    py.import("clearance._results")?.getattr(class)?.call((), Some(fields))
}

/// An instance of a result class, from its fields.
macro_rules! result {
    ($py:expr, $class:literal, $($field:ident: $value:expr),* $(,)?) => {{
        let fields = pyo3::types::PyDict::new($py);
        $(fields.set_item(stringify!($field), $value)?;)*
        crate::result_builder::make($py, $class, &fields)
    }};
}
pub(crate) use result;

/// Coordinates of a point.
pub fn xyz(point: &Point) -> [f64; 3] {
    [point.x, point.y, point.z]
}

/// Names of two bodies.
pub fn names(checker: &CollisionChecker, a: BodyId, b: BodyId) -> (String, String) {
    (checker.body_name(a).to_owned(), checker.body_name(b).to_owned())
}
