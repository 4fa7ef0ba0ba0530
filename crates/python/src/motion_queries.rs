//! Queries on motions: edges, single motions and trajectories.

use std::sync::Arc;

use clearance::checker::Watch;
use clearance::motion::ContinuousDirection;
use clearance::scene::BodyId;
use clearance::{
    MotionOptions, MotionOrder, MotionReport, MotionSegment, MotionVerdict, Trajectory, TrajectoryPoint,
    UndecidedReason,
};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use crate::arrays::{Numbers, Rows, array, broadcast, wrong_shape};
use crate::batches::run;
use crate::certificate::Certificate;
use crate::checker::CheckerCore;
use crate::error::error;
use crate::joint_space::JointSpace;
use crate::recovery::deadline;
use crate::results::{names, result, xyz};
use crate::state_queries::single;
use crate::workspaces::with_memory;

/// Edges that a thread takes at a time.
const EDGES: usize = 4;

/// Options of motion checks, as keyword arguments.
pub struct MotionSettings {
    pub tolerance: f64,
    pub timeout: Option<f64>,
    pub budget: u64,
    pub any_contact: bool,
}

impl Default for MotionSettings {
    fn default() -> Self {
        let MotionOptions { tolerance, budget, .. } = MotionOptions::default();
        Self { tolerance, timeout: None, budget, any_contact: false }
    }
}

impl MotionSettings {
    /// Reads keyword arguments.
    pub fn new(keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut read = Self::default();
        for (keyword, value) in keywords.into_iter().flatten() {
            match keyword.extract::<String>()?.as_str() {
                "tolerance" => read.tolerance = value.extract()?,
                "timeout" => read.timeout = value.extract()?,
                "budget" => read.budget = value.extract()?,
                "any_contact" => read.any_contact = value.extract()?,
                other => {
                    let text = format!(
                        "there is no option '{other}'; there are tolerance, timeout, budget and any_contact"
                    );
                    return Err(pyo3::exceptions::PyTypeError::new_err(text));
                }
            }
        }
        Ok(read)
    }

    fn options(&self, watch: &Watch) -> PyResult<MotionOptions> {
        let Self { tolerance, timeout, budget, any_contact } = *self;
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(error(format!("tolerance is {tolerance}, but must be more than zero metres")));
        }
        Ok(MotionOptions {
            tolerance,
            order: if any_contact { MotionOrder::Any } else { MotionOrder::Earliest },
            deadline: deadline(timeout)?,
            budget,
            watch: Some(watch.clone()),
        })
    }
}

/// Code of a verdict: `Verdict` of `clearance._results`.
fn verdict_code(verdict: &MotionVerdict) -> i8 {
    match verdict {
        MotionVerdict::Free => 1,
        MotionVerdict::Contact { .. } => 0,
        MotionVerdict::Undecided { .. } => -1,
    }
}

/// Code of a reason: `Reason` of `clearance._results`.
fn reason_code(reason: UndecidedReason) -> i8 {
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

/// The parts of an edge's report that arrays hold.
#[derive(Clone, Copy)]
pub struct EdgeVerdict {
    verdict: i8,
    reason: i8,
    t: [f64; 2],
}

impl EdgeVerdict {
    fn new(report: &MotionReport) -> Self {
        let (reason, t) = match report.verdict {
            MotionVerdict::Free => (0, [f64::NAN; 2]),
            MotionVerdict::Contact { t, .. } => (0, t),
            MotionVerdict::Undecided { t, reason, .. } => (reason_code(reason), t),
        };
        Self { verdict: verdict_code(&report.verdict), reason, t }
    }
}

/// Verdicts of straight motions, and the shape of the batch.
pub fn check_edges<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    ends: [&Bound<'py, PyAny>; 2],
    settings: &MotionSettings,
    threads: Option<usize>,
) -> PyResult<(Vec<EdgeVerdict>, Vec<usize>)> {
    let [from, to] = broadcast(ends, ["q0", "q1"])?;
    let ends = [Rows::new(&from, "q0", core.space.names())?, Rows::new(&to, "q1", core.space.names())?];
    let segments = segments(core, &ends)?;
    let watch = Watch::default();
    let options = settings.options(&watch)?;
    let on_stop = || watch.stop();
    let verdicts = run(py, threads, on_stop, |_| {
        let check = |segment: &MotionSegment| {
            with_memory(core, |memory| {
                EdgeVerdict::new(&core.checker.check_motion_with(segment, &options, &mut memory.workspace))
            })
        };
        segments.par_iter().with_min_len(EDGES.min(segments.len() / 16)).map(check).collect()
    })?;
    Ok((verdicts, ends[0].leading().to_vec()))
}

/// The straight motions between two lists of states.
fn segments(core: &CheckerCore, [from, to]: &[Rows<'_>; 2]) -> PyResult<Vec<MotionSegment>> {
    let end = |rows: &Rows<'_>, what: &str, i: usize| {
        let read = core.space.read(rows.table().row(i));
        read.map_err(|why| error(format!("{what}{}: {why}", rows.place(i))))
    };
    let segment = |i: usize| {
        let ends = [end(from, "q0", i)?, end(to, "q1", i)?];
        Ok(MotionSegment::straight(core.space.robot(), &ends[0], &ends[1]))
    };
    (0..from.count()).map(segment).collect()
}

/// Whether edges are proven free: a bool, or an array of them.
pub fn free_flags<'py>(
    py: Python<'py>,
    verdicts: &[EdgeVerdict],
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let free: Vec<bool> = verdicts.iter().map(|edge| edge.verdict == 1).collect();
    match free[..] {
        [free] if shape.is_empty() => Ok(free.into_pyobject(py)?.to_owned().into_any()),
        _ => Ok(array(py, free, shape)?.into_any()),
    }
}

/// Arrays of verdicts, reasons and fractions.
pub fn edge_reports<'py>(
    py: Python<'py>,
    verdicts: &[EdgeVerdict],
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let codes = |of: fn(&EdgeVerdict) -> i8| array(py, verdicts.iter().map(of).collect(), shape);
    let t = array(py, verdicts.iter().flat_map(|edge| edge.t).collect(), &[shape, &[2]].concat())?;
    result!(py, "EdgeReports", verdicts: codes(|edge| edge.verdict)?, reasons: codes(|edge| edge.reason)?, t: t)
}

/// Checks one straight motion.
pub fn check_motion<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    [from, to]: [&Bound<'py, PyAny>; 2],
    (with_certificate, tube): (bool, Option<&Bound<'py, PyAny>>),
    settings: &MotionSettings,
) -> PyResult<Bound<'py, PyAny>> {
    let ends = [single(core, from, "q0")?, single(core, to, "q1")?];
    let segment = with_tube(core, MotionSegment::straight(core.space.robot(), &ends[0], &ends[1]), tube)?;
    let watch = Watch::default();
    let options = settings.options(&watch)?;
    let (report, certificate) = run(
        py,
        None,
        || watch.stop(),
        |_| {
            with_memory(core, |memory| {
                if with_certificate {
                    return core.checker.certify_motion(&segment, &options, &mut memory.workspace);
                }
                (core.checker.check_motion_with(&segment, &options, &mut memory.workspace), None)
            })
        },
    )?;
    let fields = verdict_fields(py, core, &report.verdict)?;
    fields.set_item("evaluations", report.evaluations)?;
    fields.set_item("certificate", certificate_object(py, certificate)?)?;
    crate::results::make(py, "MotionReport", &fields)
}

/// Checks a trajectory.
pub fn check_trajectory<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    points: &TrajectoryArrays<'_, 'py>,
    (with_certificate, tube): (bool, Option<&Bound<'py, PyAny>>),
    settings: &MotionSettings,
) -> PyResult<Bound<'py, PyAny>> {
    let trajectory = points.trajectory(&core.space)?.map(|segment| with_tube(core, segment, tube))?;
    let watch = Watch::default();
    let options = settings.options(&watch)?;
    let (report, certificate) = run(
        py,
        None,
        || watch.stop(),
        |_| {
            with_memory(core, |memory| {
                if with_certificate {
                    return core.checker.certify_trajectory(&trajectory, &options, &mut memory.workspace);
                }
                (core.checker.check_trajectory(&trajectory, &options, &mut memory.workspace), None)
            })
        },
    )?;
    let fields = verdict_fields(py, core, &report.verdict)?;
    fields.set_item("segment", report.segment)?;
    fields.set_item("time", report.time.map(|[from, to]| (from, to)))?;
    fields.set_item("evaluations", report.evaluations)?;
    fields.set_item("certificate", certificate_object(py, certificate)?)?;
    crate::results::make(py, "TrajectoryReport", &fields)
}

pub fn certificate_object(
    py: Python<'_>,
    certificate: Option<clearance::Certificate>,
) -> PyResult<Option<Bound<'_, Certificate>>> {
    certificate.map(|inner| Bound::new(py, Certificate { inner: Arc::new(inner) })).transpose()
}

/// Fields that reports on motions and trajectories share.
fn verdict_fields<'py>(
    py: Python<'py>,
    core: &CheckerCore,
    verdict: &MotionVerdict,
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
        Some(tube) => segment.with_tube(core.space.robot(), tube_of(&core.space, tube)?).map_err(error),
    }
}

/// A tracking tolerance (rad, m) for each position of the whole robot.
pub fn tube_of(space: &JointSpace, tube: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let numbers = Numbers::new(tube, "tube")?;
    let count = space.names().len();
    match (numbers.shape(), numbers.values()) {
        ([] | [1], [tolerance]) => Ok(space.expand(&vec![*tolerance; count])),
        ([length], values) if *length == count => Ok(space.expand(values)),
        (shape, _) => Err(wrong_shape("tube", shape, &format!("must be a number or ({count},)"))),
    }
}

/// Points of a trajectory, as arguments.
pub struct TrajectoryArrays<'a, 'py> {
    /// Seconds from the start, shape (N,); none for a path without times.
    pub times: Option<&'a Bound<'py, PyAny>>,
    /// Shape (N, n).
    pub positions: &'a Bound<'py, PyAny>,
    pub velocities: Option<&'a Bound<'py, PyAny>>,
    pub accelerations: Option<&'a Bound<'py, PyAny>>,
    pub shortest: bool,
}

impl TrajectoryArrays<'_, '_> {
    /// The trajectory, with fixed positions of the joints outside of the group.
    pub fn trajectory(&self, space: &JointSpace) -> PyResult<Trajectory> {
        let names = space.names();
        let positions = Rows::new(self.positions, "positions", names)?;
        let &[count] = positions.leading() else {
            let form = format!("must be (N, {}): one row for each point", names.len());
            return Err(wrong_shape("positions", &[positions.leading(), &[names.len()]].concat(), &form));
        };
        let rates = |given: Option<&Bound<'_, PyAny>>, what: &str| match given {
            None => Ok(vec![Vec::new(); count]),
            Some(given) => {
                let rows = Rows::new(given, what, names)?;
                let is_same = rows.leading() == [count];
                let rows = is_same.then(|| (0..count).map(|i| rows.table().row(i).to_vec()).collect());
                rows.ok_or_else(|| PyValueError::new_err(format!("{what} must have the shape of positions")))
            }
        };
        let (velocities, accelerations): (Vec<Vec<f64>>, Vec<Vec<f64>>) =
            (rates(self.velocities, "velocities")?, rates(self.accelerations, "accelerations")?);
        let times = self.times(count)?;
        let points =
            velocities.into_iter().zip(accelerations).enumerate().map(|(i, (velocities, accelerations))| {
                let positions = positions.table().row(i).to_vec();
                TrajectoryPoint { positions, velocities, accelerations, time_from_start: times[i] }
            });
        let points: Vec<_> = points.collect();
        let direction =
            if self.shortest { ContinuousDirection::Shortest } else { ContinuousDirection::AsGiven };
        Trajectory::from_points_with_direction(space.robot(), names, &points, space.rest(), direction)
            .map_err(error)
    }

    fn times(&self, count: usize) -> PyResult<Vec<f64>> {
        let Some(times) = self.times else { return Ok(vec![0.0; count]) };
        let times = Numbers::new(times, "times")?;
        if times.shape() != [count] {
            let form = format!("must be ({count},): one time for each row of positions");
            return Err(wrong_shape("times", times.shape(), &form));
        }
        // to the library, times that are all zero are no times; NaN comes after nothing
        let follows = |pair: &[f64]| pair[1] > pair[0];
        if let Some(i) = times.values().windows(2).position(|pair| !follows(pair)) {
            let values = times.values();
            return Err(PyValueError::new_err(format!(
                "times[{}] is {} s, which does not come after times[{i}], {} s",
                i + 1,
                values[i + 1],
                values[i]
            )));
        }
        Ok(times.values().to_vec())
    }
}
