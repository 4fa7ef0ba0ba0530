//! Rate limiter for log messages about samples that cannot be decoded.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::dds::lock::lock;

/// Minimum time between two log messages of one endpoint.
const PAUSE: Duration = Duration::from_secs(1);

/// Rate limiter of one endpoint.
#[derive(Default)]
pub struct DecodeErrorLog(Mutex<Option<Instant>>);

impl DecodeErrorLog {
    /// Logs a warning, unless the last one was logged less than `PAUSE` ago.
    pub fn warn(&self, text: impl FnOnce() -> String) {
        if self.is_due(Instant::now()) {
            log::warn!("{}", text());
        }
    }

    fn is_due(&self, now: Instant) -> bool {
        let mut last = lock(&self.0);
        let due = last.is_none_or(|at| now.duration_since(at) > PAUSE);
        if due {
            *last = Some(now);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_errors_are_logged_at_intervals() {
        let (decode_errors, start) = (DecodeErrorLog::default(), Instant::now());
        let due = |milliseconds| decode_errors.is_due(start + Duration::from_millis(milliseconds));
        assert_eq!([0, 1, 999, 1001, 1002, 2500].map(due), [true, false, false, true, false, true]);
    }
}
