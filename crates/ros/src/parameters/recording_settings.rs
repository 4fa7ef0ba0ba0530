//! Settings of a recording.

use std::path::PathBuf;

/// Settings of a recording: file and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingSettings {
    pub file: PathBuf,
    /// Size (MB) at which the recording ends; 0 means never.
    pub max_size: f64,
    /// Time (s) after which the recording ends; 0 means never.
    pub max_duration: f64,
}
