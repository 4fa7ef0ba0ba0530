//! C interface of least distances along motions and trajectories.

use std::ptr;

use clearance::checker::{LeastClearance, MotionClearance, MotionClearanceOptions, NearestMoment};
use clearance::{MotionSegment, Trajectory};
use clearance_bindings::JointSpace;

use crate::arguments::Arguments;
use crate::checker::clearance_checker;
use crate::motion_options::{clearance_reason, deadline, tube_of};
use crate::motion_queries::{clearance_trajectory, edge_ends};
use crate::status::{Failure, Outcome, clearance_status};
use crate::structs::{clearance_edge, clearance_pair, xyz};
use crate::workspace::{clearance_workspace, query};

/// Options of searches for the least distances along a motion. Start with `clearance_along_options_default`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_along_options {
    /// The search ends when lower and upper bound differ by at most this (m). Default 1e-3.
    pub absolute_tolerance: f64,
    /// The same, relative to the upper bound; the larger of the two applies. Default 0.01.
    pub relative_tolerance: f64,
    /// Larger distances (m) do not matter: the search ends when the lower bound has reached it. Default infinity.
    pub max_distance: f64,
    /// Time (s) after which a search ends with its results so far. Default infinity.
    pub timeout: f64,
    /// Number of evaluations of a pair after which a search ends. Default 10 000 000.
    pub budget: u64,
    /// Tracking tolerance (rad, m) of each position of a state: lower bounds hold anywhere within it. Default null: none.
    pub tube: *const f64,
    /// Number of tracking tolerances: the number of positions, 1 for the same tolerance of every joint, or 0.
    pub tube_count: usize,
}

impl Default for clearance_along_options {
    fn default() -> Self {
        let MotionClearanceOptions { absolute_tolerance, relative_tolerance, limit, budget, .. } =
            MotionClearanceOptions::default();
        Self {
            absolute_tolerance,
            relative_tolerance,
            max_distance: limit,
            timeout: f64::INFINITY,
            budget,
            tube: ptr::null(),
            tube_count: 0,
        }
    }
}

/// The default options: no tracking tolerance, no time limit.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_along_options_default() -> clearance_along_options {
    clearance_along_options::default()
}

/// Options, read.
struct ReadAlongOptions {
    options: MotionClearanceOptions,
    /// Tracking tolerances of the whole robot.
    tube: Option<Vec<f64>>,
}

impl ReadAlongOptions {
    /// Reads options; null is the default. The time limit begins here.
    fn new(
        arguments: Arguments<'_>,
        options: *const clearance_along_options,
        space: &JointSpace,
    ) -> Outcome<Self> {
        let given = arguments.object_or_none(options, "options")?.copied().unwrap_or_default();
        let clearance_along_options { absolute_tolerance, relative_tolerance, max_distance, .. } = given;
        for (name, value) in
            [("absolute_tolerance", absolute_tolerance), ("relative_tolerance", relative_tolerance)]
        {
            let is_tolerance = value >= 0.0 && value.is_finite();
            if !is_tolerance {
                return Err(Failure::rejected(format!(
                    "{name} is {value}, but must be finite and zero or more"
                )));
            }
        }
        let is_distance = max_distance >= 0.0;
        if !is_distance {
            return Err(Failure::rejected(format!(
                "max_distance is {max_distance}, but must be zero or more metres"
            )));
        }
        let options = MotionClearanceOptions {
            absolute_tolerance,
            relative_tolerance,
            limit: max_distance,
            deadline: deadline(given.timeout)?,
            budget: given.budget,
            watch: None,
        };
        Ok(Self { options, tube: tube_of(arguments, given.tube, given.tube_count, space)? })
    }

    fn with_tube(&self, space: &JointSpace, segment: MotionSegment) -> Outcome<MotionSegment> {
        match &self.tube {
            None => Ok(segment),
            Some(tube) => segment.with_tube(space.robot(), tube.clone()).map_err(Failure::rejected),
        }
    }
}

/// Bounds on the least distance of the pairs of one kind along a motion (m, padding subtracted).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_least_distance {
    /// Proven: no pair is nearer at any time; 0 if some pair touches, or if nothing is proven. Infinite if no such pairs are checked.
    pub lower: f64,
    /// Distance of the pair at t: the least distance is not larger. Infinite if there is no pair.
    pub upper: f64,
    /// The pair at which `upper` is attained; its names are valid as long as the checker.
    pub pair: clearance_pair,
    /// Nearest points of the pair (m, root frame), without padding; NaN if there is no pair.
    pub points: [[f64; 3]; 2],
    /// Fraction of the motion, or of the segment, at which `upper` is attained; NaN if there is no pair.
    pub t: f64,
    /// Trajectory: index of the segment.
    pub segment: usize,
    /// Trajectory with times: time (s) from the start; otherwise NaN.
    pub time: f64,
}

impl clearance_least_distance {
    /// `None` if no such pairs are checked.
    fn new(checker: &clearance_checker, least: Option<&LeastClearance>) -> Self {
        let bounds = Self {
            lower: f64::INFINITY,
            upper: f64::INFINITY,
            pair: clearance_pair::NONE,
            points: [[f64::NAN; 3]; 2],
            t: f64::NAN,
            segment: 0,
            time: f64::NAN,
        };
        let Some(LeastClearance { lower, upper, nearest }) = least else { return bounds };
        let bounds = Self { lower: *lower, upper: *upper, ..bounds };
        let Some(NearestMoment { segment, t, time, pair }) = nearest else { return bounds };
        Self {
            pair: checker.pair((pair.a, pair.b)),
            points: pair.witness_points.each_ref().map(xyz),
            t: *t,
            segment: *segment,
            time: time.unwrap_or(f64::NAN),
            ..bounds
        }
    }
}

/// The least distances along a motion.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_motion_distances {
    /// Of two bodies of the robot.
    pub nearest_self: clearance_least_distance,
    /// Of the robot and an obstacle.
    pub nearest_world: clearance_least_distance,
    /// Why the bounds differ by more than the tolerance, or none.
    pub reason: clearance_reason,
    /// Number of evaluations of a pair.
    pub evaluations: u64,
}

impl clearance_motion_distances {
    fn new(checker: &clearance_checker, found: &MotionClearance) -> Self {
        Self {
            nearest_self: clearance_least_distance::new(checker, found.nearest_self.as_ref()),
            nearest_world: clearance_least_distance::new(checker, found.nearest_world.as_ref()),
            reason: found.unfinished.map_or(clearance_reason::None, clearance_reason::new),
            evaluations: found.evaluations,
        }
    }
}

/// Proven bounds on the least distances along a straight motion. Null `options` are the defaults.
///
/// Rejected: positions, tolerances and times that are not finite or out of their range.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_clearance_along(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    edge: clearance_edge,
    options: *const clearance_along_options,
    distances: *mut clearance_motion_distances,
) -> clearance_status {
    query(checker, workspace, |arguments, checker, memory| {
        let read = ReadAlongOptions::new(arguments, options, &checker.space)?;
        let [from, to] = edge_ends(arguments, &checker.space, edge)?;
        let segment = read.with_tube(&checker.space, MotionSegment::straight(checker.model(), &from, &to))?;
        let found = checker.checker.clearance_along(&segment, &read.options, &mut memory.workspace);
        arguments.write(distances, clearance_motion_distances::new(checker, &found), "distances")
    })
}

/// Proven bounds on the least distances along a trajectory. Null `options` are the defaults.
///
/// Rejected: as for `clearance_checker_check_trajectory`.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_checker_clearance_along_trajectory(
    checker: *const clearance_checker,
    workspace: *mut clearance_workspace,
    trajectory: *const clearance_trajectory,
    options: *const clearance_along_options,
    distances: *mut clearance_motion_distances,
) -> clearance_status {
    query(checker, workspace, |arguments, checker, memory| {
        let read = ReadAlongOptions::new(arguments, options, &checker.space)?;
        let given: Trajectory =
            arguments.object(trajectory, "trajectory")?.read(arguments, &checker.space)?;
        let given = given.map(|segment| read.with_tube(&checker.space, segment))?;
        let found = checker.checker.clearance_along_trajectory(&given, &read.options, &mut memory.workspace);
        arguments.write(distances, clearance_motion_distances::new(checker, &found), "distances")
    })
}
