//! Checks of single motions and trajectories: reports, certificates, and the first time within a distance.

use std::sync::Arc;

use clearance::checker::Watch;
use clearance::proximity::Work;
use clearance::scene::BodyId;
use clearance::{
    MotionOptions, MotionReport, MotionSegment, MotionVerdict, Trajectory, UndecidedReason, Workspace,
};
use clearance_bindings::JointSpace;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Numbers, wrong_shape};
use crate::batches::{run, run_briefly};
use crate::certificate::Certificate;
use crate::checker_core::CheckerCore;
use crate::error::error;
use crate::motion_options::{MotionSettings, is_over};
use crate::result_builder::{names, xyz};
use crate::state_queries::single;
use crate::trajectory_arrays::TrajectoryArrays;
use crate::workspaces::with_memory;

/// Code of a verdict: `Verdict` of `clearance._results`.
pub fn verdict_code(verdict: &MotionVerdict) -> i8 {
    match verdict {
        MotionVerdict::Free => 1,
        MotionVerdict::Contact { .. } => 0,
        MotionVerdict::Undecided { .. } => -1,
    }
}

/// Code of a reason: `Reason` of `clearance._results`.
pub fn reason_code(reason: UndecidedReason) -> i8 {
    match reason {
        UndecidedReason::Tolerance => 1,
        UndecidedReason::Tube => 2,
        UndecidedReason::Deadline => 3,
        UndecidedReason::Canceled => 4,
        UndecidedReason::Budget => 5,
        UndecidedReason::Overflow => 6,
        UndecidedReason::Mismatch => 7,
    }
}

/// Checks one straight motion.
pub fn check_motion<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    [from, to]: [&Bound<'py, PyAny>; 2],
    (with_certificate, tube): (bool, Option<&Bound<'py, PyAny>>),
    settings: &MotionSettings,
) -> PyResult<Bound<'py, PyAny>> {
    let segment = straight(core, [from, to], tube)?;
    let (report, certificate) = prove(py, core, settings, |options, workspace| {
        if is_over(options.deadline) {
            return (not_begun(), None);
        }
        if with_certificate {
            return core.checker.certify_motion(&segment, options, workspace);
        }
        (core.checker.check_motion_with(&segment, options, workspace), None)
    })?;
    let fields = report_fields(py, core, &report.verdict, certificate)?;
    fields.set_item("evaluations", report.evaluations)?;
    crate::result_builder::make(py, "MotionReport", &fields)
}

/// Checks a trajectory.
pub fn check_trajectory<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    points: &TrajectoryArrays<'_, 'py>,
    (with_certificate, tube): (bool, Option<Vec<f64>>),
    settings: &MotionSettings,
) -> PyResult<Bound<'py, PyAny>> {
    let trajectory = loosened(core, points.trajectory(&core.space)?, tube.as_deref())?;
    let (report, certificate) = prove(py, core, settings, |options, workspace| {
        if with_certificate {
            return core.checker.certify_trajectory(&trajectory, options, workspace);
        }
        (core.checker.check_trajectory(&trajectory, options, workspace), None)
    })?;
    let fields = report_fields(py, core, &report.verdict, certificate)?;
    fields.set_item("evaluations", report.evaluations)?;
    fields.set_item("segment", report.segment)?;
    fields.set_item("time", report.time.map(|[from, to]| (from, to)))?;
    crate::result_builder::make(py, "TrajectoryReport", &fields)
}

/// The first time at which a pair of bodies is not farther apart than `distance` (m) on a straight motion.
pub fn event_distance<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    ends: [&Bound<'py, PyAny>; 2],
    (distance, tube): (f64, Option<&Bound<'py, PyAny>>),
    settings: &MotionSettings,
) -> PyResult<Bound<'py, PyAny>> {
    let segment = straight(core, ends, tube)?;
    let report = prove(py, core, settings, |options, workspace| {
        if is_over(options.deadline) {
            return not_begun();
        }
        core.checker.event_distance(&segment, distance, options, workspace)
    })?;
    let fields = report_fields(py, core, &report.verdict, None)?;
    fields.set_item("evaluations", report.evaluations)?;
    crate::result_builder::make(py, "MotionReport", &fields)
}

/// The straight motion between two states.
pub fn straight(
    core: &CheckerCore,
    [from, to]: [&Bound<'_, PyAny>; 2],
    tube: Option<&Bound<'_, PyAny>>,
) -> PyResult<MotionSegment> {
    let ends = [single(core, from, "q0")?, single(core, to, "q1")?];
    with_tube(core, MotionSegment::straight(core.space.robot(), &ends[0], &ends[1]), tube)
}

/// A trajectory with a tolerance (rad, m) for each position of the whole robot.
pub fn loosened(core: &CheckerCore, trajectory: Trajectory, tube: Option<&[f64]>) -> PyResult<Trajectory> {
    let Some(tube) = tube else { return Ok(trajectory) };
    trajectory.map(|segment| {
        segment.with_tube(core.space.robot(), tube.to_vec()).map_err(|why| error(format!("tube: {why}")))
    })
}

/// Tolerance (rad, m) of each position of the whole robot: of the tracking, and of the motion between samples.
pub fn whole_tube(
    core: &CheckerCore,
    tube: Option<&Bound<'_, PyAny>>,
    deviation: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Vec<f64>>> {
    type Read = fn(&JointSpace, &Bound<'_, PyAny>) -> PyResult<Vec<f64>>;
    let read = |given: Option<&Bound<'_, PyAny>>, name, read: Read| -> PyResult<Option<Vec<f64>>> {
        let Some(given) = given else { return Ok(None) };
        let values = read(&core.space, given)?;
        match values.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
            Some(value) => Err(error(format!("{name} has {value}, but must be finite and zero or more"))),
            None => Ok(Some(values)),
        }
    };
    Ok(match (read(tube, "tube", tube_of)?, read(deviation, "deviation", deviation_of)?) {
        (Some(tube), Some(deviation)) => Some(tube.iter().zip(&deviation).map(|(a, b)| a + b).collect()),
        (tube, deviation) => tube.or(deviation),
    })
}

/// Runs a check: on this thread if it is short, else on one of the pool, so that Ctrl-C ends it.
fn prove<T: Send>(
    py: Python<'_>,
    core: &CheckerCore,
    settings: &MotionSettings,
    check: impl Fn(&MotionOptions, &mut Workspace) -> T + Sync,
) -> PyResult<T> {
    let watch = Watch::default();
    let options = &settings.options(&watch);
    let work = |options: &MotionOptions| with_memory(core, |memory| check(options, &mut memory.workspace));
    match run_briefly(py, options, work) {
        Some(result) => Ok(result),
        None => run(py, None, || watch.stop(), |_| work(options)),
    }
}

/// The report on a motion whose check had no time to begin.
fn not_begun() -> MotionReport {
    let verdict = MotionVerdict::Undecided {
        t: [0.0, 1.0],
        pair: None,
        distance: [0.0, f64::INFINITY],
        reason: UndecidedReason::Deadline,
    };
    MotionReport { verdict, evaluations: 0, work: Work::default() }
}

pub fn certificate_object(
    py: Python<'_>,
    certificate: Option<clearance::Certificate>,
) -> PyResult<Option<Bound<'_, Certificate>>> {
    certificate.map(|inner| Bound::new(py, Certificate { inner: Arc::new(inner) })).transpose()
}

/// Fields that reports on motions and trajectories share.
fn report_fields<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    verdict: &MotionVerdict,
    certificate: Option<clearance::Certificate>,
) -> PyResult<Bound<'py, PyDict>> {
    let pair_names = |(a, b): (BodyId, BodyId)| names(&core.checker, a, b);
    let (t, pair, reason, distance, point) = match *verdict {
        MotionVerdict::Free => (None, None, None, None, None),
        MotionVerdict::Contact { t, pair, witness } => (Some(t), Some(pair), None, None, witness),
        MotionVerdict::Undecided { t, pair, distance, reason } => {
            (Some(t), pair, Some(reason), Some(distance), None)
        }
    };
    let enumeration = |class: &str, code: i8| py.import("clearance._results")?.getattr(class)?.call1((code,));
    let fields = PyDict::new(py);
    fields.set_item("verdict", enumeration("Verdict", verdict_code(verdict))?)?;
    fields.set_item("t", t.map(|[from, to]| (from, to)))?;
    fields.set_item("pair", pair.map(pair_names))?;
    fields
        .set_item("reason", reason.map(|reason| enumeration("Reason", reason_code(reason))).transpose()?)?;
    fields.set_item("distance", distance.map(|[lower, upper]| (lower, upper)))?;
    fields.set_item("point", point.map(|point| PyArray1::from_slice(py, &xyz(&point))))?;
    fields.set_item("certificate", certificate_object(py, certificate)?)?;
    Ok(fields)
}

/// Adds a tracking tolerance: one for every column, or one for each.
fn with_tube(
    core: &CheckerCore,
    segment: MotionSegment,
    tube: Option<&Bound<'_, PyAny>>,
) -> PyResult<MotionSegment> {
    match tube {
        None => Ok(segment),
        Some(tube) => {
            let tube = tube_of(&core.space, tube)?;
            segment.with_tube(core.space.robot(), tube).map_err(|why| error(format!("tube: {why}")))
        }
    }
}

/// A tracking tolerance (rad, m) for each position of the whole robot: one for each position of a state, or one number for every joint,
/// also for mimic joints and for those that are not in the group.
pub fn tube_of(space: &JointSpace, tube: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    tolerances_of(space, tube, "tube", |tolerance| {
        space.robot().uniform_tolerances(tolerance).map_err(|why| error(format!("tube: {why}")))
    })
}

/// A deviation (rad, m) of each position of the whole robot from the motion between samples: one for each position of a state, or one
/// number for all of these. Mimic joints follow, and what is not in the group stands.
fn deviation_of(space: &JointSpace, deviation: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let of_all = |deviation| Ok(space.expand(&vec![deviation; space.names().len()]));
    tolerances_of(space, deviation, "deviation", of_all)
}

/// One number as `of_all` has it, or one for each position of a state.
fn tolerances_of(
    space: &JointSpace,
    given: &Bound<'_, PyAny>,
    name: &'static str,
    of_all: impl FnOnce(f64) -> PyResult<Vec<f64>>,
) -> PyResult<Vec<f64>> {
    let numbers = Numbers::new(given, name)?;
    let count = space.names().len();
    match (numbers.shape(), numbers.values()) {
        ([], [tolerance]) => of_all(*tolerance),
        ([length], values) if *length == count => Ok(space.expand(values)),
        (shape, _) => Err(wrong_shape(name, shape, &format!("must be a number or ({count},)"))),
    }
}
