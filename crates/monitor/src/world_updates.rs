//! Messages about the world that were received and are not in force yet.

use std::collections::VecDeque;
use std::time::Duration;

use super::{Now, Reason};

/// Longest lag of the world behind its messages: one heartbeat by default, and ten times the duration of ordinary updates at 30 Hz.
/// A robot at 1 m/s moves 0.1 m in this time.
const LONGEST_LAG: Duration = Duration::from_millis(100);

/// Times of reception (steady clock), in the order in which they were recorded. Since there are several topics, the oldest time
/// need not be the first.
#[derive(Debug, Default)]
pub(super) struct WorldUpdates {
    received: VecDeque<Duration>,
    /// Number of messages that the next world contains.
    completing: usize,
}

impl WorldUpdates {
    pub fn note_received(&mut self, at: Duration) {
        self.received.push_back(at);
    }

    /// The last received message requires no change.
    pub fn note_withdrawn(&mut self) {
        self.received.pop_back();
    }

    /// The next world contains this number of further messages.
    pub fn note_completing(&mut self, updates: usize) {
        self.completing = self.completing.saturating_add(updates);
    }

    /// The next world is in force.
    pub fn complete(&mut self) {
        let count = std::mem::take(&mut self.completing).min(self.received.len());
        self.received.drain(..count);
    }

    /// The reason if a message has waited for too long.
    pub fn overdue(&self, now: Now) -> Option<Reason> {
        let age = now.steady.saturating_sub(*self.received.iter().min()?);
        let waiting = self.received.len();
        (age >= LONGEST_LAG).then_some(Reason::WorldUpdate { waiting, age: age.as_secs_f64() })
    }

    /// Time at which that will be the case without further changes.
    pub fn due(&self) -> Option<Duration> {
        self.received.iter().min()?.checked_add(LONGEST_LAG)
    }
}
