//! Line of the log, and its message for `/rosout`.

use clearance_monitor::Time;
use log::Level;
use ros2_client::builtin_interfaces::Time as StampMessage;
use ros2_client::log::Log as LogMessage;

/// One line of this program's log.
#[derive(Clone, Debug)]
pub struct LogLine {
    pub level: Level,
    pub text: String,
    pub file: &'static str,
    pub line: u32,
}

impl LogLine {
    /// Message of the logger with this name.
    pub(super) fn to_message(&self, logger: &str, stamp: Time) -> LogMessage {
        LogMessage {
            stamp: StampMessage::from_nanos(stamp.nanoseconds()),
            level: match self.level {
                Level::Error => LogMessage::ERROR,
                Level::Warn => LogMessage::WARN,
                Level::Info => LogMessage::INFO,
                Level::Debug | Level::Trace => LogMessage::DEBUG,
            },
            name: logger.to_owned(),
            msg: self.text.clone(),
            file: self.file.to_owned(),
            function: String::new(),
            line: self.line,
        }
    }
}
