//! Data type of the result of the check between the previous evaluated state and the current one.

use std::fmt;

use clearance_checker::{CollisionChecker, UndecidedReason};
use clearance_robot::quoted;
use clearance_scene::BodyId;

use super::Time;

/// Proof or contact: result for the motion from the previous evaluated state to the current one.
///
/// The motion is the straight line in joint space, with tolerances of the joints if the settings give some.
#[derive(Clone, Debug, PartialEq)]
pub enum MotionSincePrevious {
    /// There is no motion to check, or nothing is known about it.
    NotChecked(NoMotion),
    /// Proven: no pair touches between the two states, tolerances of the joints included.
    ProvenFree,
    /// Proven: a pair touches on the straight line, although it touches at neither end.
    PassedThrough(Passage),
    /// Neither a proof nor such a contact was found.
    NotProven {
        /// Why the motion is not proven free.
        why: GapReason,
        /// Where a contact is possible; `None` if the only contact is one of the two states' own.
        gap: Option<Passage>,
    },
}

/// A part of a motion in which a pair touches or may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Passage {
    /// The pair; `None` where no pair was evaluated.
    pub pair: Option<(BodyId, BodyId)>,
    /// The contact is between these fractions of the motion: 0 is the previous state, 1 the current one.
    pub t: [f64; 2],
    /// Stamps of the previous state and of the current one.
    pub stamps: [Time; 2],
}

/// Why no motion was checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoMotion {
    /// The check between states is switched off.
    Off,
    /// No new state was evaluated: the last one is published again.
    NoNewState,
    /// There is no earlier state of this robot model.
    FirstState,
    /// The clock was set back.
    ClockSetBack,
    /// The states are farther apart than `stale_after`.
    Pause {
        /// Time (s) between the two states.
        since: f64,
    },
}

/// Why a motion is not proven free.
#[derive(Clone, Debug, PartialEq)]
pub enum GapReason {
    /// One of the two states collides itself, and no contact of another pair was found.
    StateCollides,
    /// The check of the motion ended without a decision.
    Undecided(UndecidedReason),
    /// The world has changed since the previous state, whose own contacts in this world are not known.
    WorldChanged,
    /// The robot's root moves in a frame that obstacles are placed in, and a body is too near to an obstacle.
    RootMoves {
        /// Name of the frame.
        frame: String,
    },
    /// A body is too near to an obstacle that moves, or may move, by itself.
    ObstacleMoves {
        /// Name of the obstacle.
        name: String,
    },
    /// A joint state in between was not evaluated, because a newer one had come, and it lies beside the checked motion.
    PassedOver,
    /// The status is UNKNOWN.
    UnknownStatus,
}

/// Stable identifier of a proven contact between two states.
pub const PASSED_THROUGH: &str = "passed_through";

/// Stable identifier of the warning about a motion that is not proven free.
pub const GAP_NOT_PROVEN: &str = "gap_not_proven";

impl MotionSincePrevious {
    /// The proven contact, if there is one.
    #[must_use]
    pub fn passed_through(&self) -> Option<&Passage> {
        match self {
            Self::PassedThrough(passage) => Some(passage),
            _ => None,
        }
    }

    /// The proven or possible contact, if there is one.
    #[must_use]
    pub fn passage(&self) -> Option<&Passage> {
        match self {
            Self::PassedThrough(passage) | Self::NotProven { gap: Some(passage), .. } => Some(passage),
            _ => None,
        }
    }

    /// Why nothing is proven; `None` if something is.
    #[must_use]
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::NotChecked(why) => Some(why.to_string()),
            Self::NotProven { why, .. } => Some(why.to_string()),
            Self::ProvenFree | Self::PassedThrough(_) => None,
        }
    }

    /// The warning about a possible contact, which begins with its stable identifier.
    pub(super) fn warning(&self, checker: &CollisionChecker) -> Option<String> {
        let Self::NotProven { why, gap: Some(gap) } = self else { return None };
        let pair = gap.pair.map_or_else(
            || "some pair".to_owned(),
            |(a, b)| [a, b].map(|body| quoted(checker.body_name(body))).join(" and "),
        );
        Some(format!("{GAP_NOT_PROVEN}: {pair} may have touched since the previous state: {why}"))
    }

    /// The same while the status is UNKNOWN: a motion is then never proven free.
    pub(super) fn while_unknown(self) -> Self {
        match self {
            Self::ProvenFree => Self::NotProven { why: GapReason::UnknownStatus, gap: None },
            other => other,
        }
    }
}

impl Default for MotionSincePrevious {
    fn default() -> Self {
        Self::NotChecked(NoMotion::NoNewState)
    }
}

impl fmt::Display for NoMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("check_between_states is off"),
            Self::NoNewState => f.write_str("no new state was evaluated"),
            Self::FirstState => f.write_str("this is the first state of the robot model"),
            Self::ClockSetBack => f.write_str("the clock was set back after the previous state"),
            Self::Pause { since } => {
                write!(f, "the previous state is {since:.3} s older, which is more than stale_after")
            }
        }
    }
}

impl fmt::Display for GapReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StateCollides => f.write_str("one of the two states collides itself"),
            Self::Undecided(why) => why.fmt(f),
            Self::WorldChanged => f.write_str("the world has changed since the previous state"),
            Self::RootMoves { frame } => {
                write!(f, "an obstacle is near, and the robot's root moves in {}", quoted(frame))
            }
            Self::ObstacleMoves { name } => {
                write!(f, "obstacle {} is near and may have moved", quoted(name))
            }
            Self::PassedOver => f.write_str(
                "a joint state in between, which was not evaluated because newer ones had come, lies beside the checked line",
            ),
            Self::UnknownStatus => f.write_str("the status is UNKNOWN"),
        }
    }
}
