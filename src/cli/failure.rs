//! Errors that end a command without a result, and their exit codes.

use std::borrow::Cow;

use clearance_files::readable_text::on_one_line;

use super::exit_status::ExitStatus;

/// Maximum length (characters) of one line of a message.
const LONGEST_LINE: usize = 4000;

/// A failure, which determines the exit code.
#[derive(Debug)]
pub enum Failure {
    /// Invalid user input: exit code 2. One line.
    Input(String),
    /// Invalid user input with several faults, one line each: exit code 2.
    Faults(Vec<String>),
    /// Internal error: exit code 3.
    Internal(String),
    /// The process exceeded its memory limit: exit code 5.
    #[cfg_attr(not(feature = "ros"), allow(dead_code, reason = "only the node has a memory limit"))]
    OutOfMemory(String),
    /// The node ended as requested, but its recording is incomplete: exit code 4.
    #[cfg_attr(not(feature = "ros"), allow(dead_code, reason = "only the node records"))]
    IncompleteRecording(String),
}

impl Failure {
    pub fn input(error: impl std::fmt::Display) -> Self {
        Self::Input(error.to_string())
    }

    pub fn exit_code(&self) -> ExitStatus {
        match self {
            Self::Input(_) | Self::Faults(_) => ExitStatus::INVALID_INPUT,
            Self::Internal(_) => ExitStatus::INTERNAL_ERROR,
            Self::IncompleteRecording(_) => ExitStatus::INCOMPLETE_RECORDING,
            Self::OutOfMemory(_) => ExitStatus::OUT_OF_MEMORY,
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Input(message) | Self::OutOfMemory(message) | Self::IncompleteRecording(message) => {
                f.write_str(&line(message))
            }
            Self::Faults(messages) => {
                let lines: Vec<_> = messages.iter().map(|message| line(message)).collect();
                f.write_str(&lines.join("\n"))
            }
            Self::Internal(message) => write!(f, "internal error: {}", line(message)),
        }
    }
}

/// The message on one line of limited length: input must not flood a terminal or control it.
fn line(message: &str) -> Cow<'_, str> {
    let message = on_one_line(message);
    match message.char_indices().nth(LONGEST_LINE) {
        Some((end, _)) => Cow::Owned(format!("{}…", &message[..end])),
        None => message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_without_end_are_cut() {
        let long = "ü".repeat(1_000_000);
        let message = Failure::Faults(vec!["a".to_owned(), long.clone(), "b".to_owned()]).to_string();
        assert!(message.starts_with("a\nüü") && message.ends_with("ü…\nb"));
        assert!(message.len() < 10_000);
        assert!(Failure::Input(long).to_string().len() < 10_000);
        assert_eq!(Failure::Input("short".to_owned()).to_string(), "short");
    }

    #[test]
    fn a_message_of_one_line_stays_one_line() {
        let raw = || "object 'a\nb\u{1b}[31m\u{202e}'".to_owned();
        let expected = r"object 'a\nb\u{1b}[31m\u{202e}'";
        assert_eq!(Failure::Input(raw()).to_string(), expected);
        assert_eq!(Failure::OutOfMemory(raw()).to_string(), expected);
        assert_eq!(Failure::IncompleteRecording(raw()).to_string(), expected);
        assert_eq!(Failure::Faults(vec![raw(), raw()]).to_string(), format!("{expected}\n{expected}"));
    }
}
