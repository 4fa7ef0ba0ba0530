//! Why a command ended without an answer.

use std::process::ExitCode;

/// A failure and the exit code it means.
#[derive(Debug)]
pub enum Failure {
    /// Something the user gave is wrong: exit code 2.
    Input(String),
    /// Something here is wrong: exit code 3.
    Internal(String),
    /// The process took more memory than it may: exit code 5.
    OutOfMemory(String),
}

impl Failure {
    pub fn input(error: impl std::fmt::Display) -> Self {
        Self::Input(error.to_string())
    }

    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(2),
            Self::Internal(_) => ExitCode::from(3),
            Self::OutOfMemory(_) => ExitCode::from(5),
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Input(message) | Self::OutOfMemory(message) => f.write_str(message),
            Self::Internal(message) => write!(f, "internal error: {message}"),
        }
    }
}
