//! Options and results of motion checks.

use std::time::Instant;

use clearance_geometry::math::{Extremes, Point};
use clearance_proximity::Work;

use super::watch::Watch;
use clearance_scene::BodyId;

/// Options of a motion check.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionOptions {
    /// An interval in which no body moves more than this (m) may stay undecided: pairs that stay farther apart than
    /// this are always decided.
    pub tolerance: f64,
    /// Distance (m) that pairs must keep, besides their paddings: a pair that is not farther apart counts as touching.
    /// Numbers below zero count as zero.
    pub margin: f64,
    /// Which contact the check searches for.
    pub order: MotionOrder,
    /// Time at which the check stops with its results so far.
    pub deadline: Option<Instant>,
    /// Number of pair evaluations after which the check stops; each takes some microseconds.
    pub budget: u64,
    /// Handle by which another thread observes the progress of the check, and may stop it.
    pub watch: Option<Watch>,
}

/// Which contact the check searches for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionOrder {
    /// The earliest: all before it is proven free.
    #[default]
    Earliest,
    /// Any, as soon as possible.
    Any,
}

impl MotionOptions {
    /// The margin (m) that is checked: with NaN, nothing is free.
    pub(crate) fn kept_margin(&self) -> f64 {
        if self.margin.is_nan() { f64::INFINITY } else { self.margin.greater(0.0) }
    }

    /// The reason to stop now, if the watching thread has stopped the check or the deadline has passed.
    pub(crate) fn stopped_by(&self) -> Option<UndecidedReason> {
        is_over(self.watch.as_ref(), self.deadline)
    }
}

/// The reason to stop now, if the watching thread has stopped the check or the deadline has passed.
pub fn is_over(watch: Option<&Watch>, deadline: Option<Instant>) -> Option<UndecidedReason> {
    if watch.is_some_and(Watch::is_stopped) {
        return Some(UndecidedReason::Canceled);
    }
    let has_passed = deadline.is_some_and(|deadline| Instant::now() >= deadline);
    has_passed.then_some(UndecidedReason::Deadline)
}

impl Default for MotionOptions {
    fn default() -> Self {
        Self {
            tolerance: 5e-4,
            margin: 0.0,
            order: MotionOrder::Earliest,
            deadline: None,
            budget: 10_000_000,
            watch: None,
        }
    }
}

/// Result of a motion check.
#[derive(Clone, Debug, PartialEq)]
pub enum MotionVerdict {
    /// Proven: no pair touches, or is within the [margin](MotionOptions::margin), anywhere in [0, 1].
    Free,
    /// A pair touches, or is within the margin.
    Contact {
        /// The motion is proven free before the first time, and a pair touches, or is within the margin, at the second.
        t: [f64; 2],
        /// The bodies of the pair.
        pair: (BodyId, BodyId),
        /// A point (root frame) of the pair at the second t, if one is known: common to both bodies, with a margin of one of them.
        witness: Option<Point>,
    },
    /// Neither a proof nor a contact was found.
    Undecided {
        /// The motion is proven free before the first time and after the second; a part in between is undecided.
        t: [f64; 2],
        /// The pair of the first undecided interval; `None` if none was evaluated.
        pair: Option<(BodyId, BodyId)>,
        /// Bounds on the pair's distance (m, padding subtracted) in the middle of the interval.
        distance: [f64; 2],
        /// Why nothing was found.
        reason: UndecidedReason,
    },
}

/// Why a motion could not be decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UndecidedReason {
    /// A pair comes nearer than the tolerance, and no contact was found.
    Tolerance,
    /// A pair may touch within the tracking tolerance, or as obstacles may move.
    Tube,
    /// The deadline has passed.
    Deadline,
    /// The watching thread stopped the check.
    Canceled,
    /// The budget of evaluations is used up.
    Budget,
    /// The pair is two planes, for which nothing is proven, or numbers are too large for the computation.
    Overflow,
    /// The motion belongs to another robot, moves an obstacle that is not in the world, or has segments that do not
    /// join.
    Mismatch,
}

impl UndecidedReason {
    /// A stable identifier for programs.
    #[must_use]
    pub fn code(self) -> &'static str {
        match self {
            Self::Tolerance => "tolerance",
            Self::Tube => "tube",
            Self::Deadline => "deadline",
            Self::Canceled => "canceled",
            Self::Budget => "budget",
            Self::Overflow => "overflow",
            Self::Mismatch => "mismatch",
        }
    }
}

impl std::fmt::Display for UndecidedReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Tolerance => "nearer than the tolerance",
            Self::Tube => "may touch within the tracking tolerance, or as obstacles may move",
            Self::Deadline => "deadline exceeded",
            Self::Canceled => "canceled",
            Self::Budget => "budget used up",
            Self::Overflow => "nothing is proven of two planes, or of numbers too large to compute with",
            Self::Mismatch => "the motion is not one of this robot in this world",
        })
    }
}

/// Report on one motion.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionReport {
    /// The result: free, contact or undecided.
    pub verdict: MotionVerdict,
    /// Number of evaluations of a pair in one interval.
    pub evaluations: u64,
    /// Volume tests and primitive tests that the check took.
    pub work: Work,
}

impl MotionReport {
    /// Report on a motion that was not evaluated.
    pub(crate) fn not_evaluated(reason: UndecidedReason) -> Self {
        let (t, distance) = ([0.0, 1.0], [0.0, f64::INFINITY]);
        let verdict = MotionVerdict::Undecided { t, pair: None, distance, reason };
        Self { verdict, evaluations: 0, work: Work::default() }
    }

    /// True only if the motion is proven free.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.verdict == MotionVerdict::Free
    }
}
