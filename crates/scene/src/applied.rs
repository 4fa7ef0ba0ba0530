//! Result of applying a scene update: whether anything changed, warnings, and rejected parts.

use super::SceneRejection;

/// Result of applying a message.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Applied {
    /// True if anything was changed.
    pub changed: bool,
    /// Warnings about unusual but accepted content.
    pub warnings: Vec<String>,
    /// Accepted settings without effect, such as a matrix entry that names nothing.
    pub ineffective: Vec<String>,
    /// Rejected parts.
    pub refusals: Vec<SceneRejection>,
}

impl Applied {
    pub(super) fn record(&mut self, result: Result<(), SceneRejection>) {
        match result {
            Ok(()) => self.changed = true,
            Err(refusal) => self.refusals.push(refusal),
        }
    }
}
