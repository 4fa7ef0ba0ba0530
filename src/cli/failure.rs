//! Why a command ended without an answer.

use std::borrow::Cow;
use std::process::ExitCode;

/// Longest line (characters) of a message.
const LONGEST_LINE: usize = 4000;

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
            Self::Input(message) | Self::OutOfMemory(message) => f.write_str(&bounded(message)),
            Self::Internal(message) => write!(f, "internal error: {}", bounded(message)),
        }
    }
}

/// The message with each line cut: what inputs hold must not flood a terminal.
fn bounded(message: &str) -> Cow<'_, str> {
    let is_long = |line: &str| line.len() > LONGEST_LINE;
    if !message.split('\n').any(is_long) {
        return Cow::Borrowed(message);
    }
    let cut = |line: &str| match line.char_indices().nth(LONGEST_LINE) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line.to_owned(),
    };
    Cow::Owned(message.split('\n').map(cut).collect::<Vec<_>>().join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_without_end_are_cut() {
        let message = Failure::Input(format!("a\n{}\nb", "ü".repeat(1_000_000))).to_string();
        assert!(message.starts_with("a\nüü") && message.ends_with("ü…\nb"));
        assert!(message.len() < 10_000);
        assert_eq!(Failure::Input("short".to_owned()).to_string(), "short");
    }
}
