//! Limits of the computation of a matrix, and its error type.

use std::time::Instant;

use clearance_checker::Watch;

/// Limits of the search. Without a deadline, the result is the same for any number of threads.
#[derive(Clone, Debug, PartialEq)]
pub struct MatrixOptions {
    /// Largest number of boxes of joint positions for one pair.
    pub most_boxes: u64,
    /// Time at which the search ends; pairs without a decision are undecided.
    pub deadline: Option<Instant>,
    /// Ends the search from another thread, as the deadline does.
    pub watch: Option<Watch>,
    /// Seed of the random states.
    pub seed: u64,
}

impl MatrixOptions {
    /// Default of [`Self::most_boxes`].
    pub const MOST_BOXES: u64 = 4_000_000;

    /// True if the deadline has passed, or the search was stopped.
    pub(crate) fn is_over(&self) -> bool {
        self.watch.as_ref().is_some_and(Watch::is_stopped)
            || self.deadline.is_some_and(|end| Instant::now() >= end)
    }
}

impl Default for MatrixOptions {
    fn default() -> Self {
        Self { most_boxes: Self::MOST_BOXES, deadline: None, watch: None, seed: 1 }
    }
}

/// Reason why no matrix can be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MatrixFailure {
    /// The shape of a link cannot be scaled.
    #[error("link '{link}': {why}")]
    CannotScale {
        /// Name of the link.
        link: String,
        /// The reason.
        why: String,
    },
    /// The checker rejects the settings.
    #[error("{0}")]
    Settings(String),
    /// The robot has no pair of links with collision geometry.
    #[error("robot '{0}' has no two links with collision geometry: there is no pair to decide")]
    NoPairs(String),
}
