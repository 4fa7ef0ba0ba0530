//! Detects that two publishers send on a topic whose messages replace one another.

use std::time::{Duration, Instant};

use clearance_monitor::SourceId;

/// A publisher that follows another one within this time was not started in its place.
const RESTART: Duration = Duration::from_secs(1);

/// Shortest time for which a topic counts as shared after its publishers took turns.
const SHORTEST_MEMORY: Duration = Duration::from_secs(10);

/// Number of turns for which a topic counts as shared after its publishers took turns, so that a slow one is not forgotten.
const REMEMBERED_TURNS: u32 = 3;

/// The last publishers of a topic. A publisher that was started again only follows another; two that share the topic
/// take turns.
#[derive(Default)]
pub struct SharedTopic {
    last: Option<Turn>,
    before: Option<Turn>,
    shared_until: Option<Instant>,
}

/// Successive messages of one publisher.
#[derive(Clone, Copy)]
struct Turn {
    publisher: SourceId,
    /// Time of its last message.
    end: Instant,
}

impl SharedTopic {
    /// Adds a message. Returns `true` if other publishers send on the topic too.
    pub fn note(&mut self, publisher: SourceId, received: Instant) -> bool {
        let turn = Turn { publisher, end: received };
        let Some(last) = self.last.replace(turn).filter(|last| last.publisher != publisher) else {
            return self.shared_until.is_some_and(|until| received < until);
        };
        let returned_after = self
            .before
            .replace(last)
            .filter(|before| before.publisher == publisher)
            .map(|before| received.saturating_duration_since(before.end));
        if let Some(turn) = returned_after {
            // the turn of a fast publisher does not shorten the memory of a slow one
            let until = received.checked_add(SHORTEST_MEMORY.max(turn * REMEMBERED_TURNS));
            self.shared_until = self.shared_until.max(until);
        }
        returned_after.is_some() || received.saturating_duration_since(last.end) < RESTART
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether each message, of a publisher and at a time (s), is of a shared topic.
    fn are_shared(messages: &[(u8, f64)]) -> Vec<bool> {
        let (start, mut topic) = (Instant::now(), SharedTopic::default());
        let at = |seconds| start + Duration::from_secs_f64(seconds);
        messages.iter().map(|(id, seconds)| topic.note(SourceId([*id; 16]), at(*seconds))).collect()
    }

    #[test]
    fn one_publisher_shares_its_topic_with_nobody_also_when_started_again() {
        assert_eq!(are_shared(&[(1, 0.0), (1, 0.1), (2, 2.0), (2, 2.1), (3, 9.0)]), [false; 5]);
    }

    #[test]
    fn publishers_that_take_turns_share_their_topic_until_one_has_ended() {
        let found = are_shared(&[(1, 0.0), (2, 0.1), (1, 0.2), (1, 0.3), (2, 0.4), (1, 10.3), (1, 10.5)]);
        assert_eq!(found, [false, true, true, true, true, true, true]);
        let found = are_shared(&[(1, 0.0), (2, 0.1), (1, 0.2), (1, 0.3), (1, 10.1), (1, 10.3)]);
        assert_eq!(found, [false, true, true, true, true, false]);
    }

    #[test]
    fn a_slow_publisher_is_not_forgotten() {
        let slow: Vec<(u8, f64)> = (0..100).map(|i| (u8::from(i % 40 == 0), f64::from(i) * 2.0)).collect();
        let found = are_shared(&slow);
        assert!(found[41..].iter().all(|shared| *shared), "{found:?}");
    }
}
