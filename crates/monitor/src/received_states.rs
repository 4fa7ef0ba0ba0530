//! Store of the last received joint states of all publishers.

use std::time::Duration;

use super::{JointStateInput, Now, Time};

/// Largest number of stored messages: publishers come and go, and the memory must not grow with them.
const MOST_MESSAGES: usize = 128;

/// Largest number of values and names that are read from a message: no robot has as many joints.
const MOST_JOINTS: usize = 4096;

/// Largest total size (bytes) of the stored joint names, without those of the last message.
const MOST_TEXT: usize = 1 << 20;

/// Time (s) within which two publishers report a joint at almost the same time.
pub(super) const SAME_TIME: f64 = 0.1;

/// Largest lag (s) of a publisher that relays another publisher's messages ten times a second.
pub(super) const LAG: f64 = 0.2;

/// A joint state and its time of reception.
#[derive(Debug)]
pub(super) struct ReceivedState {
    pub input: JointStateInput,
    /// Stamp in use: the stamp of the message, or the time of reception if it has none.
    pub stamp: Time,
    /// Time of reception (steady clock).
    pub at: Duration,
    /// How much older (s) it is than the newest evaluated message of its stream, if it is older.
    pub behind: Option<f64>,
    /// Newest evaluated stamp of its stream.
    evaluated: Option<Time>,
    /// Whether an evaluation has read it, or another message came before.
    is_read: bool,
    /// By name: velocity of the joint (rad/s, m/s), from the message or from the previous message of the stream; NaN if
    /// unknown.
    pub rates: Vec<f64>,
}

/// Largest motion (rad, m) between two messages. A larger difference is a wrap-around or a reset.
const LONGEST_MOTION: f64 = std::f64::consts::PI;

impl ReceivedState {
    /// Time (s) since the reception.
    pub fn since_reception(&self, now: Now) -> f64 {
        now.steady.saturating_sub(self.at).as_secs_f64()
    }

    fn text(&self) -> usize {
        self.input.names.iter().map(String::len).sum()
    }
}

/// The last message of each stream, in the order of reception. A stream is a publisher with a set of joint names:
/// several drivers may share the topic, and a played bag is one publisher with the messages of several.
#[derive(Debug, Default)]
pub(super) struct ReceivedStates(Vec<ReceivedState>);

impl ReceivedStates {
    /// Stores a joint state.
    pub fn receive(&mut self, mut input: JointStateInput, now: Now) {
        input.names.truncate(MOST_JOINTS);
        input.positions.truncate(MOST_JOINTS);
        input.velocities.truncate(MOST_JOINTS);
        let stamp = match (input.stamp, now.ros) {
            (Time::ZERO, Some(now)) => now,
            (stamp, _) => stamp,
        };
        let before =
            self.0.iter().position(|h| h.input.source == input.source && h.input.names == input.names);
        let before = before.map(|place| self.0.remove(place));
        let rates = rates(&input, stamp, before.as_ref());
        let evaluated = before.as_ref().and_then(|before| before.evaluated);
        let newest = evaluated.filter(|_| input.stamp != Time::ZERO);
        let behind = newest.map(|newest| newest.seconds_since(stamp)).filter(|&behind| behind > 0.0);
        self.0.push(ReceivedState { input, stamp, at: now.steady, behind, evaluated, is_read: false, rates });
        let mut text: usize = self.0.iter().map(ReceivedState::text).sum();
        while self.0.len() > MOST_MESSAGES || (text > MOST_TEXT && self.0.len() > 1) {
            text -= self.0.remove(0).text();
        }
    }

    /// The last message, once, if no evaluation has read it.
    pub fn take_unread(&mut self) -> Option<&JointStateInput> {
        let last = self.0.last_mut().filter(|last| !last.is_read)?;
        last.is_read = true;
        Some(&last.input)
    }

    /// Marks the last received message as evaluated.
    pub fn note_evaluated(&mut self) {
        if let Some(last) = self.0.last_mut() {
            last.is_read = true;
        }
        if let Some(last) = self.0.last_mut().filter(|last| last.input.stamp != Time::ZERO) {
            last.evaluated = Some(last.stamp);
        }
    }

    /// The clock of the stamps was set back: stamps evaluated before no longer define an order.
    pub fn discard_order(&mut self) {
        for received in &mut self.0 {
            received.evaluated = None;
        }
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// The messages in the order of reception.
    pub fn messages(&self) -> &[ReceivedState] {
        &self.0
    }
}

/// Velocities of the joints in a message; `before` is the previous message of its stream.
fn rates(input: &JointStateInput, stamp: Time, before: Option<&ReceivedState>) -> Vec<f64> {
    let JointStateInput { names, positions, velocities, .. } = input;
    if velocities.len() == names.len() {
        return velocities.clone();
    }
    let unknown = || vec![f64::NAN; names.len()];
    let Some(before) = before.filter(|before| before.input.positions.len() == positions.len()) else {
        return unknown();
    };
    let after = stamp.seconds_since(before.stamp);
    if after == 0.0 {
        return before.rates.clone();
    }
    if after < 0.0 || positions.len() != names.len() {
        return unknown();
    }
    let ways = positions.iter().zip(&before.input.positions).map(|(now, then)| now - then);
    ways.map(|way| if way.abs() < LONGEST_MOTION { way / after } else { f64::NAN }).collect()
}
