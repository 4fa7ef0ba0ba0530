//! Error of a node that did not start or did not end normally.

/// Reason why a node did not start, or did not end normally.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// Invalid user input.
    #[error("{0}")]
    Input(String),
    /// Error of the network or of this program.
    #[error("{0}")]
    Internal(String),
    /// The process exceeded its memory limit.
    #[error("{0}")]
    OutOfMemory(String),
    /// The node ended as requested, but its recording is incomplete.
    #[error("{0}")]
    IncompleteRecording(String),
}
