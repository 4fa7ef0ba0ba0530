//! Limits of the computation of a matrix.

use std::time::Instant;

/// Limits of the search. Without a deadline, the result is the same for any number of threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatrixOptions {
    /// Largest number of boxes of joint positions for one pair.
    pub most_boxes: u64,
    /// Time at which the search ends; pairs without a decision are undecided.
    pub deadline: Option<Instant>,
    /// Seed of the random states.
    pub seed: u64,
}

impl MatrixOptions {
    /// Default of [`Self::most_boxes`].
    pub const MOST_BOXES: u64 = 4_000_000;
}

impl Default for MatrixOptions {
    fn default() -> Self {
        Self { most_boxes: Self::MOST_BOXES, deadline: None, seed: 1 }
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
