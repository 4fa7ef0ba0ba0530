//! Function `verify`: checks that a certificate proves a motion of a robot in a world free.

use std::sync::Arc;

use clearance::motion::MotionSegment;
use clearance::verifier::ExpectedMotion;
use clearance::{Trajectory, Verifier};
use clearance_bindings::JointSpace;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::arrays::Rows;
use crate::batches;
use crate::certificate::Certificate;
use crate::error::error;
use crate::motion_queries::tube_of;
use crate::options;
use crate::result_builder::result;
use crate::robot::Robot;
use crate::settings::CheckSettings;
use crate::trajectory_arrays::TrajectoryArrays;
use crate::world::World;

/// Verifies that a certificate proves a motion of this robot in this world free, with code that is independent of the checker.
///
/// A certificate proves one motion. Say which one you expect: `edge=(q0, q1)` for a straight motion, or
/// `trajectory=(times, positions[, velocities[, accelerations]])`, both with all positions of the robot, in the order of
/// `Robot.joint_names`, of shapes (n,) and (N, n). A certificate of another motion is rejected. Without them, only the proof is checked:
/// compare the motion in the certificate with yours. `shortest` is that of `check_trajectory`. `tube` is the tracking tolerance (rad, m) that is expected, (n,), or one number for every joint,
/// mimic joints included;
/// `tolerance` (m) that of the check; `margin` (m) is the least distance that the proof has to keep, besides paddings. The settings are
/// those of `Checker`, and must be the same as for the check.
///
/// Runs without the GIL on one thread; Ctrl-C ends it.
///
/// Returns a `Verification`, which is true only if the proof holds; otherwise its `reason` says why not.
#[pyfunction]
#[pyo3(
    signature = (certificate, robot, world=None, *, edge=None, trajectory=None, shortest=false, tube=None, tolerance=None, margin=None, **settings),
    text_signature = "(certificate, robot, world=None, *, edge=None, trajectory=None, shortest=False, tube=None, tolerance=None, margin=None, **settings)"
)]
#[allow(clippy::too_many_arguments)] // one for each keyword
pub fn verify<'py>(
    py: Python<'py>,
    certificate: &Bound<'py, Certificate>,
    robot: &Bound<'py, Robot>,
    world: Option<PyRef<'py, World>>,
    edge: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    trajectory: Option<Bound<'py, PyTuple>>,
    shortest: bool,
    tube: Option<Bound<'py, PyAny>>,
    #[pyo3(from_py_with = options::tolerance_if_any)] tolerance: Option<f64>,
    #[pyo3(from_py_with = options::margin_if_any)] margin: Option<f64>,
    settings: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let model = &robot.get().model;
    let space = JointSpace::whole(Arc::clone(model));
    let scene = world.map(|world| world.scene.clone()).unwrap_or_default();
    let settings = CheckSettings::new(settings)?;
    settings.check_names(model, &scene)?;
    let matrix = settings.matrix(model, &scene);
    let settings = settings.settings.with_scene(&scene);
    let tube = tube.map(|tube| tube_of(&space, &tube)).transpose()?;
    if shortest && trajectory.is_none() {
        return Err(PyTypeError::new_err("shortest belongs to trajectory, and there is none"));
    }
    let motion = match (edge, trajectory) {
        (Some(_), Some(_)) => return Err(PyTypeError::new_err("give edge or trajectory, not both")),
        (Some((from, to)), None) => Some(straight(&space, [&from, &to])?),
        (None, Some(points)) => Some(trajectory_of(&space, &points, shortest)?),
        (None, None) => None,
    };
    let expected_tube = |segment: MotionSegment| match &tube {
        Some(tube) => segment.with_tube(model, tube.clone()).map_err(error),
        None => Ok(segment),
    };
    let motion = motion.map(|motion| motion.map(expected_tube)).transpose()?;
    let expected =
        ExpectedMotion { motion, any_obstacle_motion: false, tube: tube.clone(), tolerance, margin };
    let certificate = Arc::clone(&certificate.get().inner);
    let verified = batches::run(
        py,
        Some(1),
        || {},
        |stop| {
            let verifier = Verifier::new(model, &scene.world, &settings, matrix.as_ref())?;
            verifier.stopped_by(stop.flag()).verify_expected(&certificate, &expected)
        },
    )?;
    let reason = verified.as_ref().err().map(ToString::to_string);
    let counts = verified.unwrap_or_default();
    result!(py, "Verification",
        valid: reason.is_none(), reason: &reason, segments: counts.segments, pairs: counts.pairs, proofs: counts.proofs)
}

fn straight(space: &JointSpace, ends: [&Bound<'_, PyAny>; 2]) -> PyResult<Trajectory> {
    let read = |end: &Bound<'_, PyAny>, what: &str| {
        let rows = Rows::new(end, what, space.names())?;
        if !rows.is_single() {
            return Err(error(format!("{what} must be one state of shape ({},)", space.names().len())));
        }
        space.read(rows.table().row(0)).map_err(|why| error(format!("{what}: {why}")))
    };
    let [from, to] = [read(ends[0], "edge[0]")?, read(ends[1], "edge[1]")?];
    Trajectory::of_segments(vec![MotionSegment::straight(space.robot(), &from, &to)]).map_err(error)
}

fn trajectory_of(space: &JointSpace, points: &Bound<'_, PyTuple>, shortest: bool) -> PyResult<Trajectory> {
    let item = |i: usize| points.get_item(i).ok().filter(|item| !item.is_none());
    let (times, velocities, accelerations) = (item(0), item(2), item(3));
    let (Some(positions), true) = (item(1), points.len() <= 4) else {
        let form =
            "trajectory must be (times, positions), with velocities and accelerations if there are some";
        return Err(PyTypeError::new_err(form));
    };
    let arrays = TrajectoryArrays {
        times: times.as_ref(),
        positions: &positions,
        velocities: velocities.as_ref(),
        accelerations: accelerations.as_ref(),
        shortest,
    };
    arrays.trajectory(space)
}
