//! Error type: reasons why a text is not a trajectory.

use super::{StartMismatch, TrajectoryError};

/// Reason why a text is not a trajectory.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum TrajectoryTextError {
    /// The message of the parser contains the location.
    #[error("{0}")]
    Text(String),
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
    #[error(transparent)]
    Start(#[from] StartMismatch),
}
