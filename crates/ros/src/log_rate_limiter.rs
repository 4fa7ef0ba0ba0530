//! Rate limiter for repeated log messages.

use std::time::Duration;

/// Length of one period, and the maximum number of messages in it.
const PERIOD: Duration = Duration::from_secs(1);
const MOST: u32 = 10;

/// Counts the messages of the current period.
#[derive(Debug, Default)]
pub struct LogRateLimiter {
    /// Steady time at which the current period began.
    since: Duration,
    logged: u32,
}

impl LogRateLimiter {
    /// Whether one more message may be logged at this steady time.
    pub fn admit(&mut self, now: Duration) -> bool {
        if now.saturating_sub(self.since) >= PERIOD {
            *self = Self { since: now, logged: 0 };
        }
        self.logged += 1;
        self.logged <= MOST
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_has_room_for_some() {
        let mut flood = LogRateLimiter::default();
        let mut admitted = |from: u64| -> usize {
            (from..from + 900).filter(|ms| flood.admit(Duration::from_millis(*ms))).count()
        };
        assert_eq!([admitted(5000), admitted(6000), admitted(6950)], [10, 10, 10]);
    }
}
