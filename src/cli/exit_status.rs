//! Exit codes of the commands: what each number means, for the process and for the Python package.

use std::process::ExitCode;

/// Exit code of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExitStatus(u8);

impl ExitStatus {
    /// Everything in the query is free, or the command has done its work.
    pub const SUCCESS: Self = Self(0);
    /// The answer is no, or not proven; what it says depends on the command.
    pub const NEGATIVE: Self = Self(1);
    /// The input is invalid.
    pub const INVALID_INPUT: Self = Self(2);
    /// The program has a fault.
    pub const INTERNAL_ERROR: Self = Self(3);
    /// The node ended as requested, but its recording is incomplete.
    pub const INCOMPLETE_RECORDING: Self = Self(4);
    /// The process exceeded its memory limit.
    pub const OUT_OF_MEMORY: Self = Self(5);

    /// Success, or a negative answer.
    #[must_use]
    pub fn of_answer(is_positive: bool) -> Self {
        if is_positive { Self::SUCCESS } else { Self::NEGATIVE }
    }

    /// The number.
    #[must_use]
    pub fn code(self) -> u8 {
        self.0
    }
}

impl From<ExitStatus> for ExitCode {
    fn from(status: ExitStatus) -> Self {
        Self::from(status.0)
    }
}
