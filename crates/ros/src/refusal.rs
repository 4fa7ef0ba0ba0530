//! Why a request is not answered, as services say it.

use clearance_files::readable_text::on_one_line;
use clearance_monitor::Reason;

/// Bytes of a message at most: it must not grow with hostile input.
pub const LONGEST_MESSAGE: usize = 480;

/// Why nothing is checked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    #[error("{0}")]
    NoModel(String),
    #[error("there is no joint state to start from: {0}")]
    NoJointState(String),
    /// The world is not known, or known to be incomplete: why, by a code and in words.
    #[error("{1}")]
    UnknownWorld(&'static str, String),
    #[error("{0}")]
    BadRequest(String),
    #[error("{0} requests are waiting already: ask again later")]
    Busy(usize),
    #[error("checking it failed inside the program")]
    Internal,
}

impl Refusal {
    /// A word that programs may compare with; it never changes.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NoModel(_) => "no_model",
            Self::NoJointState(_) => "no_joint_state",
            Self::UnknownWorld(code, _) => code,
            Self::BadRequest(_) => "bad_request",
            Self::Busy(_) => "busy",
            Self::Internal => "internal",
        }
    }

    /// For a world that is not known for this reason.
    #[must_use]
    pub fn of_world(why: &Reason) -> Self {
        let code = match why {
            // the monitor was busy, and a sensor has been silent for too long meanwhile
            Reason::Overdue { .. } => "stale_world",
            _ => why.code(),
        };
        Self::UnknownWorld(code, why.to_string())
    }

    /// What is wrong, as a message.
    #[must_use]
    pub fn message(&self) -> String {
        shortened(on_one_line(&self.to_string()).into_owned())
    }
}

pub fn bad(what: impl Into<String>) -> Refusal {
    Refusal::BadRequest(what.into())
}

/// At most [`LONGEST_MESSAGE`] bytes of a text.
pub fn shortened(mut text: String) -> String {
    if text.len() > LONGEST_MESSAGE {
        let room = 0..=LONGEST_MESSAGE - '…'.len_utf8();
        text.truncate(room.rev().find(|&end| text.is_char_boundary(end)).unwrap_or_default());
        text.push('…');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_messages_are_cut_between_letters() {
        let long = bad("ü".repeat(LONGEST_MESSAGE)).message();
        assert!(long.len() <= LONGEST_MESSAGE && long.ends_with("ü…"), "{long}");
        assert_eq!(shortened("short".to_owned()), "short");
    }
}
