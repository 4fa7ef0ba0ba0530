//! What is asked of a motion, and what is answered.

use std::time::Instant;

use clearance_geometry::math::Point;
use clearance_proximity::Work;

use super::watch::Watch;
use clearance_scene::BodyId;

/// How a motion is to be checked.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionOptions {
    /// Within an interval in which no body moves more than this (m) an open question may stay open: whatever keeps farther apart is
    /// always decided.
    pub tolerance: f64,
    pub order: MotionOrder,
    /// When to stop with what is known so far.
    pub deadline: Option<Instant>,
    /// After how many looks at a pair to stop; some microseconds each.
    pub budget: u64,
    /// By which another thread sees how far the check has come, and may stop it.
    pub watch: Option<Watch>,
}

/// Which contact is looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionOrder {
    /// The earliest: all before it is proven free.
    #[default]
    Earliest,
    /// Any, as soon as possible.
    Any,
}

impl MotionOptions {
    /// Why nothing more is to be looked at, if whoever watches wants no more or the deadline has passed.
    #[must_use]
    pub fn stopped_by(&self) -> Option<UndecidedReason> {
        if self.watch.as_ref().is_some_and(Watch::is_stopped) {
            return Some(UndecidedReason::Canceled);
        }
        let is_over = self.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        is_over.then_some(UndecidedReason::Deadline)
    }
}

impl Default for MotionOptions {
    fn default() -> Self {
        Self {
            tolerance: 5e-4,
            order: MotionOrder::Earliest,
            deadline: None,
            budget: 10_000_000,
            watch: None,
        }
    }
}

/// Whether a motion is free.
#[derive(Clone, Debug, PartialEq)]
pub enum MotionVerdict {
    /// Proven: no pair touches anywhere in [0, 1].
    Free,
    /// A pair touches.
    Contact {
        /// Free before the first, proven; colliding at the second.
        t: [f64; 2],
        pair: (BodyId, BodyId),
        /// A common point (root frame) at the second t, if one is known.
        witness: Option<Point>,
    },
    /// Neither was found.
    Undecided {
        /// Free before the first, proven, and after the second; in between a part of it is open.
        t: [f64; 2],
        /// The pair that is open first; `None` if none was looked at.
        pair: Option<(BodyId, BodyId)>,
        /// In the middle of the interval the pair's distance (m, padding taken off) is between these.
        distance: [f64; 2],
        reason: UndecidedReason,
    },
}

/// Why a motion could not be decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UndecidedReason {
    /// A pair comes nearer than the tolerance, and no contact was found.
    Tolerance,
    /// Within the tracking tolerance a pair may touch.
    Tube,
    Deadline,
    /// Whoever watches has stopped it.
    Canceled,
    Budget,
    /// The pair is two planes, of which nothing is proven, or numbers are too large to be computed with.
    Overflow,
    /// The motion is of another robot, moves an obstacle that the world has not, or has segments that do not join.
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
            Self::Tube => "may touch within the tracking tolerance",
            Self::Deadline => "deadline exceeded",
            Self::Canceled => "canceled",
            Self::Budget => "budget used up",
            Self::Overflow => "nothing is proven of two planes, or of numbers too large to compute with",
            Self::Mismatch => "the motion is not one of this robot in this world",
        })
    }
}

/// The answer about one motion.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionReport {
    pub verdict: MotionVerdict,
    /// How often a pair was looked at, one interval at a time.
    pub looks: u64,
    /// Volume tests and primitive tests that the answer took.
    pub work: Work,
}

impl MotionReport {
    /// About a motion that is not looked at any more.
    pub(super) fn not_looked_at(reason: UndecidedReason) -> Self {
        let (t, distance) = ([0.0, 1.0], [0.0, f64::INFINITY]);
        let verdict = MotionVerdict::Undecided { t, pair: None, distance, reason };
        Self { verdict, looks: 0, work: Work::default() }
    }

    #[must_use]
    pub fn is_free(&self) -> bool {
        self.verdict == MotionVerdict::Free
    }
}
