//! What was heard last of every joint, from whoever reports it.

use std::time::Duration;

use super::{JointStateInput, Now, Time};

/// Messages remembered at most: publishers come and go, and memory must not grow with them.
const MOST_MESSAGES: usize = 128;

/// Numbers and names that are read of a message at most: no robot has as many joints.
const MOST_JOINTS: usize = 4096;

/// Bytes of joint names remembered at most, but for those of the last message.
const MOST_TEXT: usize = 1 << 20;

/// A joint state, and when it came.
#[derive(Debug)]
pub(super) struct ReceivedState {
    pub input: JointStateInput,
    /// The stamp that counts: its own, or when it came if it has none.
    pub stamp: Time,
    /// When it came, by the steady clock.
    pub at: Duration,
    /// How much older (s) it is than the newest judged one of its stream, if it is.
    pub behind: Option<f64>,
    /// The newest judged stamp of its stream.
    judged: Option<Time>,
    /// By name: how fast the joint moves (rad/s, m/s), as it says itself or by what its stream said before; no number where that is not known.
    pub rates: Vec<f64>,
}

/// No joint moves so far (rad, m) from one message to the next: what seems to was counted anew, or set.
const LONGEST_WAY: f64 = std::f64::consts::PI;

impl ReceivedState {
    /// How long (s) ago it came.
    pub fn silence(&self, now: Now) -> f64 {
        now.steady.saturating_sub(self.at).as_secs_f64()
    }

    fn text(&self) -> usize {
        self.input.names.iter().map(String::len).sum()
    }
}

/// The last message of every stream, the one that came last at the end. A stream is what one publisher says about the same joints:
/// several drivers may share the topic, and a played bag is one publisher that says what several said.
#[derive(Debug, Default)]
pub(super) struct ReceivedStates(Vec<ReceivedState>);

impl ReceivedStates {
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
        let judged = before.and_then(|before| before.judged);
        let newest = judged.filter(|_| input.stamp != Time::ZERO);
        let behind = newest.map(|newest| newest.seconds_since(stamp)).filter(|&behind| behind > 0.0);
        self.0.push(ReceivedState { input, stamp, at: now.steady, behind, judged, rates });
        let mut text: usize = self.0.iter().map(ReceivedState::text).sum();
        while self.0.len() > MOST_MESSAGES || (text > MOST_TEXT && self.0.len() > 1) {
            text -= self.0.remove(0).text();
        }
    }

    /// The message that came last was judged.
    pub fn note_judged(&mut self) {
        if let Some(last) = self.0.last_mut().filter(|last| last.input.stamp != Time::ZERO) {
            last.judged = Some(last.stamp);
        }
    }

    /// The clock that the stamps refer to was set back: those judged before order nothing any more.
    pub fn forget_order(&mut self) {
        for heard in &mut self.0 {
            heard.judged = None;
        }
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// In the order in which they came.
    pub fn messages(&self) -> &[ReceivedState] {
        &self.0
    }
}

/// How fast the joints of a message move, which may follow another one of its stream.
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
    ways.map(|way| if way.abs() < LONGEST_WAY { way / after } else { f64::NAN }).collect()
}
