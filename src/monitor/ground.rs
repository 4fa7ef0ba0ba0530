//! Whether it is known where the robot's root is in what obstacles stand in: a root that has been seen to move may be anywhere once `tf` falls
//! silent.

use std::time::Duration;

use super::scene::{Grounds, TransformTree};
use super::world_source::{Sight, WorldSource};
use super::{Now, Reason, Time};
use crate::math::Pose;

/// What `tf` told last of the frames that obstacles stand in.
#[derive(Debug, Default)]
pub(super) struct GroundWatch {
    seen: Option<Seen>,
}

#[derive(Debug)]
struct Seen {
    frame: String,
    /// Pose of the frame in the root's.
    pose: Pose,
    stamp: Time,
    /// When that was first judged by, on the steady clock: a clock that stands lets nothing grow old.
    since: Option<Duration>,
    /// Whether the root was ever somewhere else in it.
    has_moved: bool,
}

impl GroundWatch {
    /// What `tf` tells now; a frame in which the root always stands where it does needs no watch.
    pub fn look(&mut self, grounds: &Grounds, tree: &TransformTree) {
        let Some((frame, pose, stamp)) = grounds.least_known(tree) else {
            self.seen = None;
            return;
        };
        let before = self.seen.take().filter(|seen| seen.frame == frame);
        let has_moved = before.as_ref().is_some_and(|seen| seen.has_moved || seen.pose != pose);
        let since = before.filter(|seen| seen.stamp == stamp).and_then(|seen| seen.since);
        self.seen = Some(Seen { frame, pose, stamp, since, has_moved });
    }

    /// What was looked at is judged by now.
    pub fn note_seen(&mut self, now: Now) {
        if let Some(seen) = &mut self.seen {
            seen.since.get_or_insert(now.steady);
        }
    }

    /// Whether the root's place is known, or why not; `ttl` (s) is the age that a transform may have.
    pub fn freshness(&self, now: Now, ttl: f64) -> Result<(), Reason> {
        let Some(seen) = self.seen.as_ref().filter(|seen| seen.has_moved) else { return Ok(()) };
        let sight = Sight { stamp: seen.stamp, at: seen.since.unwrap_or(now.steady) };
        let name = format!("tf of the robot's root in {}", seen.frame);
        WorldSource { name, seen: Some(sight), ttl }.freshness(now)
    }
}
