//! Search for a free state near a given state, such as a way out of a collision.

use std::time::Instant;

use clearance::checker::{FreeState, NoFreeState, Recovery, RecoveryOptions};
use clearance::robot::JointId;
use clearance_bindings::find_joint;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::checker_core::CheckerCore;
use crate::error::error;
use crate::result_builder::{names, result};
use crate::workspaces::with_memory;

/// Limits of a search, as arguments.
pub struct SearchLimits {
    pub max_distance: f64,
    pub clearance: f64,
    pub max_checks: u64,
    pub deadline: Option<Instant>,
    pub locked: Vec<String>,
}

/// Searches a free state near `q`.
pub fn find_free_state<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    q: &Bound<'py, PyAny>,
    limits: SearchLimits,
) -> PyResult<Bound<'py, PyAny>> {
    let q = crate::state_queries::single(core, q, "q")?;
    let robot = core.space.robot();
    let joint = |name: &String| find_joint(robot, name).map_err(|why| error(format!("locked: {why}")));
    let options = RecoveryOptions {
        joints: core.space.is_group().then(|| core.space.joints()),
        locked: limits.locked.iter().map(joint).collect::<PyResult<Vec<JointId>>>()?,
        largest_distance: limits.max_distance,
        clearance: limits.clearance,
        most_checks: limits.max_checks,
        deadline: limits.deadline,
    };
    let search =
        || with_memory(core, |memory| core.checker.find_free_state(&q, &options, &mut memory.workspace));
    let found = py.detach(search).map_err(error)?;
    let state = |positions: &[f64]| PyArray1::from_vec(py, core.space.select(positions));
    match found {
        Recovery::AlreadyFree => result!(py, "FreeState",
            found: true, state: state(q.positions()), distance: 0.0, exit: 0.0, reason: "already_free",
            pair: None::<(String, String)>, checks: 1),
        Recovery::Found(FreeState { state: free, distance, exit, checks }) => result!(py, "FreeState",
            found: true, state: state(free.positions()), distance: distance, exit: exit, reason: "found",
            pair: None::<(String, String)>, checks: checks),
        Recovery::NoneFound(none) => {
            let NoFreeState { unmoved, checks, .. } = &none;
            result!(py, "FreeState",
                found: false, state: None::<Vec<f64>>, distance: None::<f64>, exit: None::<f64>, reason: none.reason(),
                pair: unmoved.map(|(a, b)| names(&core.checker, a, b)), checks: *checks)
        }
    }
}
