//! Options of motion checks and of searches for the least distance along motions, from keyword arguments.

use std::time::Instant;

use clearance::checker::{MotionClearanceOptions, Watch};
use clearance::{MotionOptions, MotionOrder};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::options;

/// Options of motion checks; the time runs from the call on.
pub struct MotionSettings {
    pub tolerance: f64,
    pub deadline: Option<Instant>,
    pub budget: u64,
    pub any_contact: bool,
    pub margin: f64,
}

impl Default for MotionSettings {
    fn default() -> Self {
        let MotionOptions { tolerance, budget, .. } = MotionOptions::default();
        Self { tolerance, deadline: None, budget, any_contact: false, margin: 0.0 }
    }
}

impl MotionSettings {
    /// Reads keyword arguments.
    pub fn new(keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut read = Self::default();
        for (keyword, value) in keywords.into_iter().flatten() {
            match keyword.extract::<String>()?.as_str() {
                "tolerance" => read.tolerance = options::tolerance(&value)?,
                "timeout" => read.deadline = options::timeout(&value)?,
                "budget" => read.budget = options::budget(&value)?,
                "any_contact" => read.any_contact = options::any_contact(&value)?,
                "margin" => read.margin = options::margin(&value)?,
                other => {
                    let text = format!(
                        "there is no option '{other}'; there are tolerance, timeout, budget, any_contact and margin"
                    );
                    return Err(PyTypeError::new_err(text));
                }
            }
        }
        Ok(read)
    }

    /// The options of the library, for a check that `watch` may stop.
    pub fn options(&self, watch: &Watch) -> MotionOptions {
        MotionOptions {
            tolerance: self.tolerance,
            margin: self.margin,
            order: if self.any_contact { MotionOrder::Any } else { MotionOrder::Earliest },
            deadline: self.deadline,
            budget: self.budget,
            watch: Some(watch.clone()),
        }
    }
}

/// Options of the search for the least distance, as keyword arguments; the time runs from the call on.
pub struct ClearanceSettings(MotionClearanceOptions);

impl ClearanceSettings {
    /// Reads keyword arguments.
    pub fn new(keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut read = MotionClearanceOptions::default();
        for (keyword, value) in keywords.into_iter().flatten() {
            match keyword.extract::<String>()?.as_str() {
                "absolute_tolerance" => read.absolute_tolerance = options::absolute_tolerance(&value)?,
                "relative_tolerance" => read.relative_tolerance = options::relative_tolerance(&value)?,
                "max_distance" => read.limit = options::max_distance(&value)?,
                "timeout" => read.deadline = options::timeout(&value)?,
                "budget" => read.budget = options::budget(&value)?,
                other => {
                    let text = format!(
                        "there is no option '{other}'; there are absolute_tolerance, relative_tolerance, max_distance, timeout and budget"
                    );
                    return Err(PyTypeError::new_err(text));
                }
            }
        }
        Ok(Self(read))
    }

    /// The options of the library, for a search that `watch` may stop.
    pub fn options(&self, watch: &Watch) -> MotionClearanceOptions {
        MotionClearanceOptions { watch: Some(watch.clone()), ..self.0.clone() }
    }
}

/// True if a deadline has passed.
pub fn is_over(deadline: Option<Instant>) -> bool {
    deadline.is_some_and(|deadline| Instant::now() >= deadline)
}
