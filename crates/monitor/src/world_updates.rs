//! Messages about the world that have been received and are not in force yet.

use std::collections::VecDeque;
use std::time::Duration;

use super::{Now, Reason};

/// How long the world may lag behind its messages: one heartbeat by default, and ten times what ordinary updates at 30 Hz take. A robot
/// at 1 m/s moves 0.1 m in it.
const LONGEST_LAG: Duration = Duration::from_millis(100);

/// When messages about the world were received, by the steady clock, in the order in which they were noted: of several topics, the oldest
/// need not be the first.
#[derive(Debug, Default)]
pub(super) struct WorldUpdates {
    received: VecDeque<Duration>,
    /// How many of them the next world has.
    completing: usize,
}

impl WorldUpdates {
    pub fn note_received(&mut self, at: Duration) {
        self.received.push_back(at);
    }

    /// The message that was received last asks for nothing.
    pub fn note_withdrawn(&mut self) {
        self.received.pop_back();
    }

    /// The world that comes next has so many more messages.
    pub fn note_completing(&mut self, updates: usize) {
        self.completing = self.completing.saturating_add(updates);
    }

    /// The world that has them came.
    pub fn complete(&mut self) {
        let count = std::mem::take(&mut self.completing).min(self.received.len());
        self.received.drain(..count);
    }

    /// Why the world is not known now, if a message has waited for too long.
    pub fn overdue(&self, now: Now) -> Option<Reason> {
        let age = now.steady.saturating_sub(*self.received.iter().min()?);
        let waiting = self.received.len();
        (age >= LONGEST_LAG).then_some(Reason::WorldUpdate { waiting, age: age.as_secs_f64() })
    }

    /// When that will be so, if nothing changes.
    pub fn due(&self) -> Option<Duration> {
        self.received.iter().min()?.checked_add(LONGEST_LAG)
    }
}
