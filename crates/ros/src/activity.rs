//! What the node did: lately, and since its start.

use std::time::Duration;

use clearance_monitor::Evaluation;
use hdrhistogram::Histogram;

/// What happened in some stretch of time.
#[derive(Clone, Debug, Default)]
pub struct Stretch {
    /// Joint states that were judged, each by itself.
    pub judged: u64,
    /// Joint states that a newer one overtook before they could be judged.
    pub passed_over: u64,
    /// Joint states that their publishers numbered and that never came.
    pub lost: u64,
    /// Messages that a subscriber's full window kept from being sent.
    pub dropped: u64,
    pub checks: u32,
    pub compute_time: Duration,
    pub longest_compute_time: Duration,
    pub latencies: Latencies,
}

impl Stretch {
    /// Joint states that came.
    #[must_use]
    pub fn heard(&self) -> u64 {
        self.judged + self.passed_over
    }

    fn note_judged(&mut self, evaluation: &Evaluation, latency: Duration) {
        self.judged += 1;
        self.latencies.note(latency);
        if let Some(checked_state) = &evaluation.checked_state {
            self.checks = self.checks.saturating_add(1);
            self.compute_time += checked_state.compute_time;
            self.longest_compute_time = self.longest_compute_time.max(checked_state.compute_time);
        }
    }
}

/// Everything that is counted.
#[derive(Clone, Debug, Default)]
pub struct Activity {
    /// Since the last report.
    pub lately: Stretch,
    /// Since the start.
    pub ever: Stretch,
}

impl Activity {
    /// A joint state was judged, and what was said about it was said `latency` after it had come.
    pub fn note_judged(&mut self, evaluation: &Evaluation, latency: Duration) {
        self.note(|stretch| stretch.note_judged(evaluation, latency));
    }

    pub fn note_passed_over(&mut self) {
        self.note(|stretch| stretch.passed_over += 1);
    }

    pub fn note_lost(&mut self, count: u64) {
        self.note(|stretch| stretch.lost = stretch.lost.saturating_add(count));
    }

    pub fn note_dropped(&mut self, count: u64) {
        self.note(|stretch| stretch.dropped += count);
    }

    /// What is noted from now on is for the next report.
    pub fn begin_anew(&mut self) {
        self.lately = Stretch::default();
    }

    fn note(&mut self, note: impl Fn(&mut Stretch)) {
        note(&mut self.lately);
        note(&mut self.ever);
    }
}

/// How long answers took: a distribution that takes the same memory however many there are.
#[derive(Clone, Debug)]
pub struct Latencies(Histogram<u64>);

/// Longer ones count as this long (µs).
const LONGEST: u64 = 60_000_000;

impl Default for Latencies {
    /// Quantiles are told to two digits, never less than they were.
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

    /// The least duration that this part of all answers did not exceed.
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
        activity.note_passed_over();
        activity.note_lost(u64::MAX);
        activity.begin_anew();
        activity.note_lost(3);
        activity.note_dropped(2);
        assert_eq!((activity.lately.heard(), activity.lately.lost, activity.lately.dropped), (0, 3, 2));
        assert_eq!((activity.ever.heard(), activity.ever.lost, activity.ever.dropped), (1, u64::MAX, 2));
    }
}
