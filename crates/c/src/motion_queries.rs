//! C interface of motion checks: edges, also in batches, single motions and trajectories.

use std::ffi::c_int;
use std::ptr;

use clearance::motion::ContinuousDirection;
use clearance::{Certificate, MotionSegment, MotionVerdict, Trajectory, TrajectoryPoint};
use clearance_bindings::JointSpace;

use crate::arguments::Arguments;
use crate::certificate::clearance_certificate;
use crate::checker::clearance_checker;
use crate::motion_options::{
    ReadOptions, VerdictDetails, clearance_motion_options, clearance_reason, clearance_verdict,
};
use crate::rows;
use crate::state_queries::read_rows;
use crate::status::{Failure, Outcome, clearance_status};
use crate::structs::{clearance_edge, clearance_edges, clearance_pair};
use crate::thread_pools::batch_pool;
use crate::workspace::{clearance_workspace, query};

/// Whether a straight motion is proven free, at every point: false for a contact, or if undecided. `clearance_checker_check_motion` has
/// the reason. Null `options` are the defaults; `any_contact` and `certificate` have no effect.
///
/// Rejected: positions that are not finite.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_is_motion_free(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    edge: clearance_edge,
    options: *const clearance_motion_options,
    is_free: *mut bool,
) -> clearance_status {
    query(checker, workspace, |arguments, checker, memory| {
        let read = ReadOptions::new(arguments, options, &checker.space)?;
        let segment = segment(arguments, checker, edge, &read)?;
        let free = checker.checker.is_motion_free_with(&segment, &read.options, &mut memory.workspace);
        arguments.write(is_free, free, "is_free")
    })
}

/// Writes for each of many straight motions 1 if it is proven free, and otherwise 0: `edges.count` results.
///
/// Options as for `clearance_checker_is_motion_free`; `options.threads` is the number of threads. Results do not depend on it, unless
/// there is a timeout. Rejected: positions that are not finite; the text names the row.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_are_motions_free(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    edges: clearance_edges,
    options: *const clearance_motion_options,
    are_free: *mut u8,
) -> clearance_status {
    query(checker, workspace, |arguments, checker, memory| {
        let read = ReadOptions::new(arguments, options, &checker.space)?;
        arguments.check_room(are_free, edges.count, "are_free")?;
        let segments = segments(arguments, checker, edges, &read)?;
        let mut free = vec![false; segments.len()];
        let on = &checker.checker;
        if read.threads == 1 {
            on.are_motions_free_with(&segments, &read.options, &mut memory.workspace, &mut free);
        } else {
            free = batch_pool(read.threads)?.install(|| on.are_motions_free(&segments, &read.options));
        }
        let free: Vec<u8> = free.into_iter().map(u8::from).collect();
        arguments.write_array(are_free, free.len(), &free, "are_free")
    })
}

/// The straight motion of the caller.
fn segment(
    arguments: Arguments<'_>,
    checker: &clearance_checker,
    edge: clearance_edge,
    options: &ReadOptions,
) -> Outcome<MotionSegment> {
    let [from, to] = edge_ends(arguments, &checker.space, edge)?;
    let segment = MotionSegment::straight(checker.model(), &from, &to);
    options.with_tube(&checker.space, segment)
}

/// Both ends of a straight motion.
pub fn edge_ends(
    arguments: Arguments<'_>,
    space: &JointSpace,
    edge: clearance_edge,
) -> Outcome<[clearance::Configuration; 2]> {
    let end = |row: *const f64, name: &'static str| {
        rows::read(space, arguments.array(row, edge.n, name)?, &|| name.to_owned())
    };
    Ok([end(edge.from, "from")?, end(edge.to, "to")?])
}

fn segments(
    arguments: Arguments<'_>,
    checker: &clearance_checker,
    edges: clearance_edges,
    options: &ReadOptions,
) -> Outcome<Vec<MotionSegment>> {
    let clearance_edges { from, to, count, n } = edges;
    let ends = [
        read_rows(arguments, checker, (from, count, n), "from")?,
        read_rows(arguments, checker, (to, count, n), "to")?,
    ];
    let straight = |(from, to)| MotionSegment::straight(checker.model(), from, to);
    let segments = ends[0].iter().zip(&ends[1]).map(straight);
    segments.map(|segment| options.with_tube(&checker.space, segment)).collect()
}

/// Report on a motion.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_motion_report {
    /// The verdict: free, contact or undecided.
    pub verdict: clearance_verdict,
    /// Why the motion is undecided.
    pub reason: clearance_reason,
    /// Contact: the motion is proven free before the first t, and collides at the second. Undecided: it is proven free before the first
    /// and after the second, and a part in between is undecided. Free: NaN. t is 0 at the start and 1 at the end of the motion, or of the
    /// segment.
    pub t: [f64; 2],
    /// The pair that touches, or that is undecided; its names are valid as long as the checker.
    pub pair: clearance_pair,
    /// Undecided: bounds on the distance of the pair (m, padding subtracted); otherwise NaN.
    pub distance: [f64; 2],
    /// Contact: a common point (m, root frame) at the second t, NaN if none is known.
    pub point: [f64; 3],
    /// Trajectory: index of the segment that the verdict refers to; the last one if all are free.
    pub segment: usize,
    /// Trajectory with times: times (s from the start) of t; NaN if it is free.
    pub time: [f64; 2],
    /// Number of evaluations of a pair.
    pub evaluations: u64,
    /// The proof, if it was asked for and the motion is free; otherwise null. The caller frees it with `clearance_certificate_free`.
    pub certificate: *mut clearance_certificate,
}

impl clearance_motion_report {
    fn new(checker: &clearance_checker, verdict: &MotionVerdict, evaluations: u64) -> Self {
        let VerdictDetails { verdict, reason, t, pair, distance, point } =
            VerdictDetails::new(checker, verdict);
        let (segment, time, certificate) = (0, [f64::NAN; 2], ptr::null_mut());
        Self { verdict, reason, t, pair, distance, point, segment, time, evaluations, certificate }
    }

    /// Writes the report; the certificate becomes the caller's.
    fn write(self, arguments: Arguments<'_>, report: *mut Self, certificate: Option<Certificate>) -> Outcome {
        // checks the place first: a certificate without a place for its handle would be lost
        arguments.write(report, self, "report")?;
        if let Some(certificate) = certificate {
            let report = arguments.object_mut(report, "report")?;
            arguments.write_handle(
                &raw mut report.certificate,
                clearance_certificate::new(certificate),
                "certificate",
            )?;
        }
        Ok(())
    }
}

/// Checks a straight motion. The verdict FREE is a proof for the whole motion. Null `options` are the defaults.
///
/// Rejected: positions, tolerances and times that are not finite or out of their range.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_check_motion(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    edge: clearance_edge,
    options: *const clearance_motion_options,
    report: *mut clearance_motion_report,
) -> clearance_status {
    query(checker, workspace, |arguments, checker, memory| {
        let read = ReadOptions::new(arguments, options, &checker.space)?;
        let segment = segment(arguments, checker, edge, &read)?;
        let (on, workspace) = (&checker.checker, &mut memory.workspace);
        let (found, certificate) = if read.certificate {
            on.certify_motion(&segment, &read.options, workspace)
        } else {
            (on.check_motion_with(&segment, &read.options, workspace), None)
        };
        let made = clearance_motion_report::new(checker, &found.verdict, found.evaluations);
        made.write(arguments, report, certificate)
    })
}

/// A trajectory: `count` points, at least two.
///
/// Between two points the motion is linear, cubic if there are velocities, quintic if there are accelerations, too, as in
/// `trajectory_msgs/JointTrajectory`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_trajectory {
    /// count x n positions (rad, m), row by row.
    pub positions: *const f64,
    /// Number of points.
    pub count: usize,
    /// Number of positions of a state.
    pub n: usize,
    /// count times (s from the start), each later than the one before; null for a path without times.
    pub times: *const f64,
    /// count x n velocities (rad/s, m/s), or null.
    pub velocities: *const f64,
    /// count x n accelerations (rad/s², m/s²), or null; they need velocities.
    pub accelerations: *const f64,
    /// If not 0, continuous joints go the shortest way.
    pub shortest: c_int,
}

impl clearance_trajectory {
    /// Reads a trajectory, with fixed positions of the joints outside of the group.
    pub fn read(&self, arguments: Arguments<'_>, space: &JointSpace) -> Outcome<Trajectory> {
        let n = space.names().len();
        if self.n != n {
            return Err(Failure::argument(format!(
                "trajectory.n is {}, but must be {n}: one position for each of {}",
                self.n,
                space.names().join(", ")
            )));
        }
        let rows = |values: *const f64, name: &str| {
            if values.is_null() && self.count > 0 {
                return Ok(vec![Vec::new(); self.count]);
            }
            let values = arguments.array(values, self.count.saturating_mul(n), name)?;
            Ok(values.chunks_exact(n.max(1)).map(<[f64]>::to_vec).collect::<Vec<_>>())
        };
        if self.velocities.is_null() && !self.accelerations.is_null() {
            return Err(Failure::rejected(
                "trajectory.accelerations are given without trajectory.velocities: give both, or only velocities, or none of them",
            ));
        }
        arguments.array(self.positions, self.count.saturating_mul(n), "trajectory.positions")?;
        let positions = rows(self.positions, "trajectory.positions")?;
        let mut velocities = rows(self.velocities, "trajectory.velocities")?.into_iter();
        let mut accelerations = rows(self.accelerations, "trajectory.accelerations")?.into_iter();
        let times = self.times(arguments)?;
        let points: Vec<_> = positions
            .into_iter()
            .zip(times)
            .map(|(positions, time_from_start)| {
                let velocities = velocities.next().unwrap_or_default();
                let accelerations = accelerations.next().unwrap_or_default();
                TrajectoryPoint { positions, velocities, accelerations, time_from_start }
            })
            .collect();
        let direction =
            if self.shortest == 0 { ContinuousDirection::AsGiven } else { ContinuousDirection::Shortest };
        let (robot, names) = (space.robot(), space.names());
        Trajectory::from_points_with_direction(robot, names, &points, space.rest(), direction)
            .map_err(|why| Failure::rejected(format!("trajectory: {why}")))
    }

    fn times(&self, arguments: Arguments<'_>) -> Outcome<Vec<f64>> {
        if self.times.is_null() {
            return Ok(vec![0.0; self.count]);
        }
        let times = arguments.array(self.times, self.count, "trajectory.times")?;
        // to the library, times that are all zero are no times; NaN comes after nothing
        let follows = |pair: &[f64]| pair[1] > pair[0];
        match times.windows(2).position(|pair| !follows(pair)) {
            None => Ok(times.to_vec()),
            Some(i) => Err(Failure::rejected(format!(
                "trajectory.times[{}] is {} s, which does not come after times[{i}], {} s",
                i + 1,
                times[i + 1],
                times[i]
            ))),
        }
    }
}

/// Checks a trajectory: the report is on its first segment that is not free, if there is one. Null `options` are the defaults.
///
/// Rejected: numbers that are not finite, times that do not increase, fewer than two points.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_check_trajectory(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    trajectory: *const clearance_trajectory,
    options: *const clearance_motion_options,
    report: *mut clearance_motion_report,
) -> clearance_status {
    query(checker, workspace, |arguments, checker, memory| {
        let read = ReadOptions::new(arguments, options, &checker.space)?;
        let given = arguments.object(trajectory, "trajectory")?.read(arguments, &checker.space)?;
        let with_tube = |segment| read.with_tube(&checker.space, segment);
        let given = given.map(with_tube)?;
        let (on, workspace) = (&checker.checker, &mut memory.workspace);
        let (found, certificate) = if read.certificate {
            on.certify_trajectory(&given, &read.options, workspace)
        } else {
            (on.check_trajectory(&given, &read.options, workspace), None)
        };
        let made = clearance_motion_report::new(checker, &found.verdict, found.evaluations);
        let time = found.time.unwrap_or([f64::NAN; 2]);
        clearance_motion_report { segment: found.segment, time, ..made }.write(arguments, report, certificate)
    })
}
