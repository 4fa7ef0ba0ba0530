//! Options of motion checks, as keyword arguments.

use std::time::Instant;

use clearance::checker::Watch;
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
}

impl Default for MotionSettings {
    fn default() -> Self {
        let MotionOptions { tolerance, budget, .. } = MotionOptions::default();
        Self { tolerance, deadline: None, budget, any_contact: false }
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
                other => {
                    let text = format!(
                        "there is no option '{other}'; there are tolerance, timeout, budget and any_contact"
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
            order: if self.any_contact { MotionOrder::Any } else { MotionOrder::Earliest },
            deadline: self.deadline,
            budget: self.budget,
            watch: Some(watch.clone()),
            ..MotionOptions::default()
        }
    }
}

/// True if a deadline has passed.
pub fn is_over(deadline: Option<Instant>) -> bool {
    deadline.is_some_and(|deadline| Instant::now() >= deadline)
}
