//! Status of one cloud topic: time and report of its last cloud, and the log of its faults.

use std::time::{Duration, Instant};

use clearance_monitor::Observation;

use crate::monitor_events::cloud_report::CloudReport;

/// Status of one cloud topic, without the points.
#[derive(Default)]
pub struct CloudTopicStatus {
    pub seen: Option<Observation>,
    pub report: CloudReport,
    /// Reception time of the message that is being used; taken when it is in use.
    pub since: Option<Instant>,
    logged_at: Option<Instant>,
}

impl CloudTopicStatus {
    /// Logs a fault as one line, with rate limiting.
    pub fn log_fault(&mut self, topic: &str, fault: &str) {
        const PAUSE: Duration = Duration::from_secs(1);
        if self.logged_at.is_none_or(|at| at.elapsed() > PAUSE) {
            self.logged_at = Some(Instant::now());
            log::warn!("a cloud of '{topic}' is not taken: {fault}");
        }
    }
}
