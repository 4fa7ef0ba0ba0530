//! C types of the options and verdicts of motion checks, and their conversion.

use std::ffi::c_int;
use std::ptr;
use std::time::{Duration, Instant};

use clearance::{MotionOptions, MotionOrder, MotionSegment, MotionVerdict, UndecidedReason};
use clearance_bindings::JointSpace;

use crate::arguments::Arguments;
use crate::checker::clearance_checker;
use crate::status::{Failure, Outcome};
use crate::structs::{clearance_pair, xyz};

/// Options of motion checks. Start with `clearance_motion_options_default`. Flags are 0 or 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_motion_options {
    /// Pairs that stay farther apart than this (m) are always decided. Default 5e-4.
    pub tolerance: f64,
    /// Time (s) after which a check ends with its results so far. Default infinity.
    pub timeout: f64,
    /// Number of evaluations of a pair after which a check ends. Default 10 000 000.
    pub budget: u64,
    /// Tracking tolerance (rad, m) of each position of a state: the robot may be anywhere within it. Default null: none.
    pub tube: *const f64,
    /// Number of tracking tolerances: the number of positions, 1 for the same tolerance of every joint, or 0.
    pub tube_count: usize,
    /// The check ends at any contact, not at the earliest. Default 0.
    pub any_contact: c_int,
    /// A motion that is free gets a certificate. Default 0. The search differs: the time of a contact may be another one than without it,
    /// and the verdict, too, if a distance is within the tolerance. Both results are right.
    pub certificate: c_int,
    /// Threads of `clearance_checker_are_motions_free`: 0 for all cores, 1 for the calling thread. Default 0.
    pub threads: usize,
    /// Distance (m) that pairs have to keep, besides their paddings: a pair that is not farther apart counts as touching. The first t
    /// of a contact is then the time until which all pairs keep it. Default 0.
    pub margin: f64,
}

impl Default for clearance_motion_options {
    fn default() -> Self {
        let MotionOptions { tolerance, budget, .. } = MotionOptions::default();
        Self {
            tolerance,
            timeout: f64::INFINITY,
            budget,
            tube: ptr::null(),
            tube_count: 0,
            any_contact: 0,
            certificate: 0,
            threads: 0,
            margin: 0.0,
        }
    }
}

/// The default options: no tracking tolerance, no time limit, the earliest contact, no certificate.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_motion_options_default() -> clearance_motion_options {
    clearance_motion_options::default()
}

/// Options, read.
#[derive(Debug)]
pub struct ReadOptions {
    /// Those of the library.
    pub options: MotionOptions,
    /// Tracking tolerances of the whole robot.
    pub tube: Option<Vec<f64>>,
    /// True if a free motion gets a certificate.
    pub certificate: bool,
    /// Number of threads; 0 for all cores.
    pub threads: usize,
}

impl ReadOptions {
    /// Reads options; null is the default. The time limit begins here.
    pub fn new(
        arguments: Arguments<'_>,
        options: *const clearance_motion_options,
        space: &JointSpace,
    ) -> Outcome<Self> {
        let given = arguments.object_or_none(options, "options")?.copied().unwrap_or_default();
        let clearance_motion_options { tolerance, timeout, budget, tube, tube_count, margin, .. } = given;
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(Failure::rejected(format!(
                "tolerance is {tolerance}, but must be finite and more than zero metres"
            )));
        }
        let is_margin = margin >= 0.0 && margin.is_finite();
        if !is_margin {
            return Err(Failure::rejected(format!(
                "margin is {margin}, but must be finite and zero or more metres"
            )));
        }
        let order = if given.any_contact == 0 { MotionOrder::Earliest } else { MotionOrder::Any };
        let deadline = deadline(timeout)?;
        Ok(Self {
            options: MotionOptions { tolerance, margin, order, deadline, budget, ..MotionOptions::default() },
            tube: tube_of(arguments, tube, tube_count, space)?,
            certificate: given.certificate != 0,
            threads: given.threads,
        })
    }

    /// Adds the tracking tolerance.
    pub fn with_tube(&self, space: &JointSpace, segment: MotionSegment) -> Outcome<MotionSegment> {
        match &self.tube {
            None => Ok(segment),
            Some(tube) => segment.with_tube(space.robot(), tube.clone()).map_err(Failure::rejected),
        }
    }
}

/// Tracking tolerances (rad, m) for each position of the whole robot. One number is for every joint, also for mimic joints and for those
/// that are not in the group.
pub fn tube_of(
    arguments: Arguments<'_>,
    tube: *const f64,
    count: usize,
    space: &JointSpace,
) -> Outcome<Option<Vec<f64>>> {
    let n = space.names().len();
    match arguments.array(tube, count, "tube")? {
        [] => Ok(None),
        [tolerance] => {
            let tolerances = space.robot().uniform_tolerances(*tolerance);
            tolerances.map(Some).map_err(|why| Failure::rejected(format!("tube: {why}")))
        }
        values if values.len() == n => Ok(Some(space.expand(values))),
        values => Err(Failure::argument(format!(
            "tube has {} tolerances, but must have {n}, or 1 for all positions",
            values.len()
        ))),
    }
}

/// Time after so many seconds; none for infinity.
pub fn deadline(timeout: f64) -> Outcome<Option<Instant>> {
    if timeout == f64::INFINITY {
        return Ok(None);
    }
    let is_span = timeout >= 0.0;
    if !is_span {
        return Err(Failure::rejected(format!(
            "timeout is {timeout}, but must be zero or more seconds, or infinity"
        )));
    }
    // a time that the clock does not reach is no deadline
    let span = Duration::try_from_secs_f64(timeout).ok();
    Ok(span.and_then(|span| Instant::now().checked_add(span)))
}

/// Verdict on a motion.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum clearance_verdict {
    /// Neither a proof nor a contact was found; there is a reason.
    Undecided = -1,
    /// A pair touches.
    Contact = 0,
    /// Proven free, at every point of the motion.
    Free = 1,
}

/// Reason why a motion is undecided.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum clearance_reason {
    /// The motion is not undecided.
    None = 0,
    /// A pair comes nearer than the tolerance, and no contact was found.
    Tolerance = 1,
    /// A pair may touch within the tracking tolerance.
    Tube = 2,
    /// The time is over.
    Deadline = 3,
    /// The check was stopped.
    Canceled = 4,
    /// The budget of evaluations is used up.
    Budget = 5,
    /// The pair is two planes, for which nothing is proven, or numbers are too large for the computation.
    Overflow = 6,
    /// The motion has segments that do not join.
    Mismatch = 7,
}

impl clearance_reason {
    /// The reason as C has it.
    pub fn new(reason: UndecidedReason) -> Self {
        match reason {
            UndecidedReason::Tolerance => Self::Tolerance,
            UndecidedReason::Tube => Self::Tube,
            UndecidedReason::Deadline => Self::Deadline,
            UndecidedReason::Canceled => Self::Canceled,
            UndecidedReason::Budget => Self::Budget,
            UndecidedReason::Overflow => Self::Overflow,
            UndecidedReason::Mismatch => Self::Mismatch,
        }
    }
}

/// A verdict with its details, as in reports.
#[derive(Clone, Copy, Debug)]
pub struct VerdictDetails {
    pub verdict: clearance_verdict,
    pub reason: clearance_reason,
    pub t: [f64; 2],
    pub pair: clearance_pair,
    pub distance: [f64; 2],
    pub point: [f64; 3],
}

impl VerdictDetails {
    /// The details, with names that are valid as long as the checker.
    pub fn new(checker: &clearance_checker, verdict: &MotionVerdict) -> Self {
        let none = Self {
            verdict: clearance_verdict::Free,
            reason: clearance_reason::None,
            t: [f64::NAN; 2],
            pair: clearance_pair::NONE,
            distance: [f64::NAN; 2],
            point: [f64::NAN; 3],
        };
        match *verdict {
            MotionVerdict::Free => none,
            MotionVerdict::Contact { t, pair, witness } => Self {
                verdict: clearance_verdict::Contact,
                t,
                pair: checker.pair(pair),
                point: witness.as_ref().map_or(none.point, xyz),
                ..none
            },
            MotionVerdict::Undecided { t, pair, distance, reason } => Self {
                verdict: clearance_verdict::Undecided,
                reason: clearance_reason::new(reason),
                t,
                pair: pair.map_or(clearance_pair::NONE, |pair| checker.pair(pair)),
                distance,
                ..none
            },
        }
    }
}
