//! Counters of the node's work: since the last diagnostics report, and since the start.

use std::time::Duration;

use clearance_monitor::Evaluation;
use hdrhistogram::Histogram;

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

/// Distribution of response times. Its memory does not grow with the number of samples.
#[derive(Clone, Debug)]
pub struct Latencies(Histogram<u64>);

/// Upper limit (µs): longer times are counted with this value.
const LONGEST: u64 = 60_000_000;

impl Default for Latencies {
    /// Quantiles have two significant digits and are rounded up.
    fn default() -> Self {
        Self(Histogram::new_with_bounds(1, LONGEST, 2).expect("the bounds of the distribution are valid"))
    }
}

impl Latencies {
    pub fn note(&mut self, latency: Duration) {
        self.0.saturating_record(u64::try_from(latency.as_nanos().div_ceil(1000)).unwrap_or(LONGEST));
    }

    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Smallest duration that this fraction of all responses did not exceed.
    #[must_use]
    pub fn quantile(&self, part: f64) -> Duration {
        Duration::from_micros(self.0.value_at_quantile(part))
    }

    #[must_use]
    pub fn max(&self) -> Duration {
        Duration::from_micros(self.0.max())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_all_that_was_noted() {
        let mut latencies = Latencies::default();
        assert!(latencies.is_empty());
        for milliseconds in 1..=1000 {
            latencies.note(Duration::from_millis(milliseconds));
        }
        let near = |told: Duration, meant: f64| {
            let told = told.as_secs_f64();
            assert!(told >= 0.999_99 * meant && told <= 1.01 * meant, "{told} for {meant}");
        };
        near(latencies.quantile(0.5), 0.500);
        near(latencies.quantile(0.99), 0.990);
        near(latencies.max(), 1.0);
    }

    #[test]
    fn one_that_takes_too_long_is_the_longest_there_is() {
        let mut latencies = Latencies::default();
        for latency in [Duration::MAX, Duration::ZERO] {
            latencies.note(latency);
        }
        assert!(latencies.max() >= Duration::from_secs(60));
        assert_eq!(latencies.quantile(0.5), Duration::ZERO);
    }

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
