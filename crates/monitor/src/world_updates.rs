//! Queue of world messages that are received and not yet in use, and when they are overdue.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use super::{Now, Reason};

/// Longest lag of the world behind its messages: one heartbeat by default, and ten times the duration of ordinary
/// updates at 30 Hz. A robot at 1 m/s moves 0.1 m in this time.
const LONGEST_LAG: Duration = Duration::from_millis(100);

/// Times of reception (steady clock).
#[derive(Debug, Default)]
pub(super) struct WorldUpdates {
    /// In the order in which they were recorded. Since there are several topics, the oldest time need not be the first.
    received: VecDeque<Duration>,
    /// How often each time is in `received`.
    counts: BTreeMap<Duration, usize>,
    /// Number of messages that the next world contains.
    completing: usize,
}

impl WorldUpdates {
    pub fn note_received(&mut self, at: Duration) {
        self.received.push_back(at);
        *self.counts.entry(at).or_default() += 1;
    }

    /// The last received message requires no change.
    pub fn note_withdrawn(&mut self) {
        if let Some(at) = self.received.pop_back() {
            self.remove(at);
        }
    }

    /// The next world contains this number of further messages.
    pub fn note_completing(&mut self, updates: usize) {
        self.completing = self.completing.saturating_add(updates);
    }

    /// The next world is in force.
    pub fn complete(&mut self) {
        let count = std::mem::take(&mut self.completing).min(self.received.len());
        for at in self.received.drain(..count).collect::<Vec<_>>() {
            self.remove(at);
        }
    }

    fn remove(&mut self, at: Duration) {
        if let Some(count) = self.counts.get_mut(&at) {
            *count -= 1;
            if *count == 0 {
                self.counts.remove(&at);
            }
        }
    }

    fn oldest(&self) -> Option<Duration> {
        self.counts.first_key_value().map(|(at, _)| *at)
    }

    /// The reason if a message has waited for too long.
    pub fn overdue(&self, now: Now) -> Option<Reason> {
        let age = now.steady.saturating_sub(self.oldest()?);
        let waiting = self.received.len();
        (age >= LONGEST_LAG).then_some(Reason::WorldUpdate { waiting, age: age.as_secs_f64() })
    }

    /// Time at which that will be the case without further changes.
    pub fn due(&self) -> Option<Duration> {
        self.oldest()?.checked_add(LONGEST_LAG)
    }
}
