//! Whether it is known where the robot's root is in what obstacles stand in: once `tf`, which told of it again and again, falls silent, or does not
//! connect the two any more, the root may be anywhere.

use std::collections::BTreeMap;
use std::time::Duration;

use super::drift::{Drift, Track};
use super::scene::{Grounds, TransformTree};
use super::world_source::{Sight, WorldSource};
use super::{Now, Reason, Time};

/// What `tf` told last of the frames that obstacles stand in.
#[derive(Debug, Default)]
pub(super) struct GroundWatch {
    seen: BTreeMap<String, Seen>,
    /// A frame that `tf` does not connect with the root.
    lost: Option<String>,
    late: Option<Late>,
}

#[derive(Debug)]
struct Seen {
    stamp: Time,
    /// When that was first judged by, on the steady clock: a clock that stands lets nothing grow old.
    since: Option<Duration>,
    /// Whether it was ever told anew; of what was told once it need not be.
    is_alive: bool,
    track: Track,
}

/// Obstacles that are not where `tf` has them: they are being put there.
#[derive(Debug)]
struct Late {
    grounds: Grounds,
    since: Option<Duration>,
}

impl GroundWatch {
    /// What `tf` tells now.
    pub fn look(&mut self, grounds: &Grounds, tree: &TransformTree) {
        self.lost = grounds.lost(tree).map(str::to_owned);
        let mut before = std::mem::take(&mut self.seen);
        for (frame, pose_rf, stamp) in grounds.told_of(tree) {
            let seen = before.remove(frame);
            let is_alive = seen.as_ref().is_some_and(|seen| seen.is_alive || seen.stamp != stamp);
            let since = seen.as_ref().filter(|seen| seen.stamp == stamp).and_then(|seen| seen.since);
            let track = seen.map(|seen| seen.track).unwrap_or_default().to(pose_rf);
            self.seen.insert(frame.to_owned(), Seen { stamp, since, is_alive, track });
        }
        let late = self.late.take();
        self.late = grounds.are_elsewhere(tree).then(|| match late {
            Some(late) if late.grounds == *grounds => late,
            _ => Late { grounds: grounds.clone(), since: None },
        });
    }

    /// What was looked at is judged by now.
    pub fn note_seen(&mut self, now: Now) {
        for seen in self.seen.values_mut() {
            seen.track.note(now.steady);
        }
        let frames = self.seen.values_mut().map(|seen| &mut seen.since);
        for since in frames.chain(self.late.as_mut().map(|late| &mut late.since)) {
            since.get_or_insert(now.steady);
        }
    }

    /// How what stands in these frames moves past the root just now.
    pub fn drifts(&self) -> Vec<Drift> {
        self.seen.iter().map(|(frame, seen)| seen.track.drift(frame)).collect()
    }

    /// Whether the places of obstacles are known, or why not; `ttl` (s) is the age that a transform may have.
    pub fn freshness(&self, now: Now, ttl: f64) -> Result<(), Reason> {
        let of_root = |frame: &str| format!("tf of the robot's root in {frame}");
        if let Some(frame) = &self.lost {
            return Err(Reason::StaleWorld { source: of_root(frame), age: None, ttl });
        }
        for (frame, seen) in self.seen.iter().filter(|(_, seen)| seen.is_alive) {
            let sight = Sight { stamp: seen.stamp, at: seen.since.unwrap_or(now.steady) };
            WorldSource { name: of_root(frame), seen: Some(sight), ttl }.freshness(now)?;
        }
        let since = self.late.as_ref().and_then(|late| late.since);
        let lag = since.map_or(0.0, |since| now.steady.saturating_sub(since).as_secs_f64());
        if lag > ttl {
            let source = "whoever puts obstacles where tf has them".to_owned();
            return Err(Reason::StaleWorld { source, age: Some(lag), ttl });
        }
        Ok(())
    }
}
