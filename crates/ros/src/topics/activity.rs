//! Counters of the node's work: since the last diagnostics report, and since the start.

use std::time::Duration;

use clearance_monitor::Evaluation;

use crate::topics::latencies::Latencies;

/// Counters over one period.
#[derive(Clone, Debug, Default)]
pub struct Counters {
    /// Joint states that were evaluated one by one.
    pub evaluated: u64,
    /// Joint states that a newer one replaced before they were evaluated.
    pub skipped: u64,
    /// Joint states that were published, by the sequence numbers of their publishers, but not received.
    pub lost: u64,
    /// Messages that were not sent because the window of a subscriber was full.
    pub dropped: u64,
    pub checks: u32,
    pub compute_time: Duration,
    pub longest_compute_time: Duration,
    pub latencies: Latencies,
}

impl Counters {
    /// Number of joint states received.
    #[must_use]
    pub fn received(&self) -> u64 {
        self.evaluated + self.skipped
    }

    fn note_evaluated(&mut self, evaluation: &Evaluation, latency: Duration) {
        self.evaluated += 1;
        self.latencies.note(latency);
        if let Some(checked_state) = &evaluation.checked_state {
            self.checks = self.checks.saturating_add(1);
            self.compute_time += checked_state.compute_time;
            self.longest_compute_time = self.longest_compute_time.max(checked_state.compute_time);
        }
    }
}

/// All counters of the node.
#[derive(Clone, Debug, Default)]
pub struct Activity {
    /// Since the last report.
    pub recent: Counters,
    /// Since the start.
    pub total: Counters,
}

impl Activity {
    /// Counts one evaluated joint state. `latency` is the time from its reception to the publication of its result.
    pub fn note_evaluated(&mut self, evaluation: &Evaluation, latency: Duration) {
        self.note(|counters| counters.note_evaluated(evaluation, latency));
    }

    pub fn note_skipped(&mut self) {
        self.note(|counters| counters.skipped += 1);
    }

    pub fn note_lost(&mut self, count: u64) {
        self.note(|counters| counters.lost = counters.lost.saturating_add(count));
    }

    pub fn note_dropped(&mut self, count: u64) {
        self.note(|counters| counters.dropped += count);
    }

    /// Starts a new period for the next report.
    pub fn start_period(&mut self) {
        self.recent = Counters::default();
    }

    fn note(&mut self, note: impl Fn(&mut Counters)) {
        note(&mut self.recent);
        note(&mut self.total);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_reported_is_counted_on_since_the_start_alone() {
        let mut activity = Activity::default();
        activity.note_skipped();
        activity.note_lost(u64::MAX);
        activity.start_period();
        activity.note_lost(3);
        activity.note_dropped(2);
        assert_eq!((activity.recent.received(), activity.recent.lost, activity.recent.dropped), (0, 3, 2));
        assert_eq!(
            (activity.total.received(), activity.total.lost, activity.total.dropped),
            (1, u64::MAX, 2)
        );
    }
}
