//! Results of a search for a free state.

use clearance_robot::Configuration;
use clearance_scene::BodyId;

/// Result of a search for a free state.
#[derive(Clone, Debug, PartialEq)]
pub enum Recovery {
    /// The given state is free, with the clearance that was asked for.
    AlreadyFree,
    /// A free state was found.
    Found(FreeState),
    /// No free state was found within the limits. There may be one.
    NoneFound(NoFreeState),
}

/// A free state near a state that collides. The motion to it is the straight line in joint space, t from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeState {
    /// The free state.
    pub state: Configuration,
    /// Its distance from the given state: the Euclidean norm of the changes of all positions (rad, m).
    pub distance: f64,
    /// t at the first exit from collision: the motion is proven free from here on. Before, all states at equal steps
    /// collide: at most [`Self::MOST_STEPS`] in all, and no longer than [`Self::LONGEST_STEP`] where these suffice.
    pub exit: f64,
    /// Number of states that were checked.
    pub checks: u64,
}

impl FreeState {
    /// Largest displacement (m) of any point in a step.
    pub const LONGEST_STEP: f64 = 0.002;

    /// Largest number of steps of a motion.
    pub const MOST_STEPS: f64 = 4096.0;
}

/// Why no free state was found.
#[derive(Clone, Debug, PartialEq)]
pub struct NoFreeState {
    /// A pair that the joints that may move do not move apart: none of them moves one body relative to the other, or the pair kept the
    /// clearance in none of many random states.
    pub unmoved: Option<(BodyId, BodyId)>,
    /// True if the search ended at its deadline or after the largest number of checks, before all distances were searched.
    pub is_unfinished: bool,
    /// Number of states that were checked.
    pub checks: u64,
}

impl NoFreeState {
    /// The reason as a word: `not_movable`, `unfinished` or `beyond_limits`.
    #[must_use]
    pub fn reason(&self) -> &'static str {
        match self {
            Self { unmoved: Some(_), .. } => "not_movable",
            Self { is_unfinished: true, .. } => "unfinished",
            _ => "beyond_limits",
        }
    }
}
