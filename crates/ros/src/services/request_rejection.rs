//! Reasons for which services reject a request.

use clearance_files::readable_text::on_one_line;
use clearance_monitor::Reason;

/// Maximum length of a message (bytes), so that hostile input cannot make it long.
pub const LONGEST_MESSAGE: usize = 480;

/// Reason why a request was rejected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RequestRejection {
    #[error("{0}")]
    NoModel(String),
    #[error("there is no joint state to start from: {0}")]
    NoJointState(String),
    /// The world is unknown or incomplete: reason as a code and as text.
    #[error("{1}")]
    UnknownWorld(&'static str, String),
    #[error("{0}")]
    BadRequest(String),
    #[error("{0} requests are waiting already: ask again later")]
    Busy(usize),
    #[error("checking it failed inside the program")]
    Internal,
}

impl RequestRejection {
    /// Code of the reason, for programs. The codes never change.
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

    /// RequestRejection for a world that is unknown for this reason.
    #[must_use]
    pub fn of_world(why: &Reason) -> Self {
        let code = match why {
            // the monitor was busy, and meanwhile a sensor timed out
            Reason::Overdue { .. } => "stale_world",
            _ => why.code(),
        };
        Self::UnknownWorld(code, why.to_string())
    }

    /// Text of the reason.
    #[must_use]
    pub fn message(&self) -> String {
        shortened(on_one_line(&self.to_string()).into_owned())
    }
}

pub fn bad_request(what: impl Into<String>) -> RequestRejection {
    RequestRejection::BadRequest(what.into())
}

/// Truncates a text to at most [`LONGEST_MESSAGE`] bytes.
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
        let long = bad_request("ü".repeat(LONGEST_MESSAGE)).message();
        assert!(long.len() <= LONGEST_MESSAGE && long.ends_with("ü…"), "{long}");
        assert_eq!(shortened("short".to_owned()), "short");
    }
}
