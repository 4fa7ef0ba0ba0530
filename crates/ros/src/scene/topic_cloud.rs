//! State of the last point cloud of one topic.

use std::time::{Duration, Instant};

use clearance_monitor::Observation;

use crate::monitor_events::cloud_report::CloudReport;

/// The last cloud of one topic.
#[derive(Default)]
pub struct TopicCloud {
    pub seen: Option<Observation>,
    pub report: CloudReport,
    /// Reception time of the message that is being used; taken when it is in use.
    pub since: Option<Instant>,
    complained: Option<Instant>,
}

impl TopicCloud {
    /// Logs a fault as one line, with rate limiting.
    pub fn complain(&mut self, topic: &str, fault: &str) {
        const PAUSE: Duration = Duration::from_secs(1);
        if self.complained.is_none_or(|at| at.elapsed() > PAUSE) {
            self.complained = Some(Instant::now());
            log::warn!("a cloud of '{topic}' is not taken: {fault}");
        }
    }
}
