//! Distribution of response times, with quantiles.

use std::time::Duration;

use hdrhistogram::Histogram;

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
}
