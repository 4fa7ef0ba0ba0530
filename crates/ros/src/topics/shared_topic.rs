//! Detects that several publishers send on a topic whose messages replace one another.

use std::time::{Duration, Instant};

use clearance_monitor::SourceId;

/// Shortest time for which a topic counts as shared after its publishers took turns.
const SHORTEST_MEMORY: Duration = Duration::from_secs(10);

/// Longest such time: a publisher that takes over again after a long pause is no rival of the other one for as long.
const LONGEST_MEMORY: Duration = Duration::from_secs(300);

/// Number of turns for which a topic counts as shared after its publishers took turns, so that a slow one is not forgotten.
const REMEMBERED_TURNS: u32 = 3;

/// Largest number of publishers that are remembered.
const MOST_PUBLISHERS: usize = 32;

/// The last publishers of a topic. A publisher that was started again only follows another; those that share the topic
/// take turns.
#[derive(Default)]
pub struct SharedTopic {
    /// In the order of their last messages.
    turns: Vec<Turn>,
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
        let known = self.turns.iter().position(|turn| turn.publisher == publisher);
        let returns = known.filter(|i| i + 1 < self.turns.len()).map(|i| self.turns[i].end);
        if let Some(before) = returns {
            // the turn of a fast publisher does not shorten the memory of a slow one
            let turn = received.saturating_duration_since(before);
            let memory = (turn * REMEMBERED_TURNS).clamp(SHORTEST_MEMORY, LONGEST_MEMORY);
            self.shared_until = self.shared_until.max(received.checked_add(memory));
        }
        if let Some(known) = known {
            self.turns.remove(known);
        }
        self.turns.push(Turn { publisher, end: received });
        if self.turns.len() > MOST_PUBLISHERS {
            self.turns.remove(0);
        }
        self.shared_until.is_some_and(|until| received < until)
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
        assert_eq!(are_shared(&[(1, 0.0), (2, 0.3), (2, 0.6)]), [false; 3], "started again at once");
    }

    #[test]
    fn publishers_that_take_turns_share_their_topic_until_one_has_ended() {
        let found = are_shared(&[(1, 0.0), (2, 0.1), (1, 0.2), (1, 0.3), (2, 0.4), (1, 10.3), (1, 10.5)]);
        assert_eq!(found, [false, false, true, true, true, true, true]);
        let found = are_shared(&[(1, 0.0), (2, 0.1), (1, 0.2), (1, 0.3), (1, 10.1), (1, 10.3)]);
        assert_eq!(found, [false, false, true, true, true, false]);
    }

    #[test]
    fn three_publishers_in_turn_share_their_topic() {
        let turns: Vec<(u8, f64)> =
            (0..30).map(|i| (u8::try_from(i % 3).unwrap(), 1.2 * f64::from(i))).collect();
        assert!(are_shared(&turns)[3..].iter().all(|shared| *shared));
        // a fast one, and two slow ones right after each other
        let message = |i: u32| match i % 14 {
            12 => 1,
            13 => 2,
            _ => 0,
        };
        let mixed: Vec<(u8, f64)> = (0..100).map(|i| (message(i), 0.17 * f64::from(i))).collect();
        assert!(are_shared(&mixed)[14..].iter().all(|shared| *shared));
    }

    #[test]
    fn a_publisher_that_takes_over_again_after_a_long_pause_is_a_rival_for_minutes_only() {
        let found = are_shared(&[(1, 0.0), (2, 3600.0), (1, 7200.0), (1, 7400.0), (1, 7501.0)]);
        assert_eq!(found, [false, false, true, true, false]);
    }

    #[test]
    fn a_slow_publisher_is_not_forgotten() {
        let slow: Vec<(u8, f64)> = (0..100).map(|i| (u8::from(i % 40 == 0), f64::from(i) * 2.0)).collect();
        let found = are_shared(&slow);
        assert!(found[41..].iter().all(|shared| *shared), "{found:?}");
    }
}
