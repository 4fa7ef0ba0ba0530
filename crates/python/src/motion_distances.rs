//! Least distances along motions and trajectories.

use clearance::checker::{
    LeastClearance, MotionClearance, MotionClearanceOptions, NearestMoment, UndecidedReason, Watch,
};
use clearance::{Trajectory, Workspace};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::batches::run;
use crate::checker_core::CheckerCore;
use crate::motion_options::ClearanceSettings;
use crate::motion_queries::{loosened, reason_code, straight};
use crate::result_builder::{names, result, xyz};
use crate::trajectory_arrays::TrajectoryArrays;
use crate::workspaces::with_memory;

/// The least distances along a straight motion.
pub fn along_motion<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    ends: [&Bound<'py, PyAny>; 2],
    tube: Option<&Bound<'py, PyAny>>,
    settings: &ClearanceSettings,
) -> PyResult<Bound<'py, PyAny>> {
    let segment = straight(core, ends, tube)?;
    search(py, core, settings, |options, workspace| {
        core.checker.clearance_along(&segment, options, workspace)
    })
}

/// The least distances along a trajectory.
pub fn along_trajectory<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    points: &TrajectoryArrays<'_, 'py>,
    tube: Option<Vec<f64>>,
    settings: &ClearanceSettings,
) -> PyResult<Bound<'py, PyAny>> {
    let trajectory: Trajectory = loosened(core, points.trajectory(&core.space)?, tube.as_deref())?;
    search(py, core, settings, |options, workspace| {
        core.checker.clearance_along_trajectory(&trajectory, options, workspace)
    })
}

/// Runs a search on a thread of the pool, so that Ctrl-C ends it.
fn search<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    settings: &ClearanceSettings,
    search: impl Fn(&MotionClearanceOptions, &mut Workspace) -> MotionClearance + Sync,
) -> PyResult<Bound<'py, PyAny>> {
    let watch = Watch::default();
    let options = settings.options(&watch);
    let found = run(
        py,
        None,
        || watch.stop(),
        |_| with_memory(core, |memory| search(&options, &mut memory.workspace)),
    )?;
    let of_kind =
        |least: Option<LeastClearance>| least.map(|least| least_object(py, core, &least)).transpose();
    let reason = found.unfinished.map(|reason| reason_object(py, reason)).transpose()?;
    result!(
        py, "MotionClearance",
        nearest_self: of_kind(found.nearest_self)?,
        nearest_world: of_kind(found.nearest_world)?,
        reason: reason,
        evaluations: found.evaluations,
    )
}

fn reason_object(py: Python<'_>, reason: UndecidedReason) -> PyResult<Bound<'_, PyAny>> {
    py.import("clearance._results")?.getattr("Reason")?.call1((reason_code(reason),))
}

fn least_object<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    LeastClearance { lower, upper, nearest }: &LeastClearance,
) -> PyResult<Bound<'py, PyAny>> {
    let pair = nearest.map(|NearestMoment { pair, .. }| names(&core.checker, pair.a, pair.b));
    let points = nearest.map(|NearestMoment { pair, .. }| {
        let rows: Vec<Vec<f64>> = pair.witness_points.iter().map(|point| xyz(point).to_vec()).collect();
        PyArray2::from_vec2(py, &rows)
    });
    result!(
        py, "LeastClearance",
        lower: *lower,
        upper: *upper,
        pair: pair,
        t: nearest.map(|nearest| nearest.t),
        segment: nearest.map(|nearest| nearest.segment),
        time: nearest.and_then(|nearest| nearest.time),
        points: points.transpose()?,
    )
}
