//! Frames that others publish: the latest transform of each, as `tf` and `tf_static` tell it.

use std::collections::HashMap;

use crate::math::Pose;
use crate::monitor::Time;

/// Frames known at most, so that a hostile network can not fill the memory.
const MOST_FRAMES: usize = 10_000;

/// A frame in its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Transform {
    pub parent: String,
    /// Pose of the frame in its parent.
    pub pose_pf: Pose,
    /// When it was so; `None` if it always is.
    pub stamp: Option<Time>,
}

/// The latest transform of every frame.
#[derive(Clone, Debug, Default)]
pub struct TransformTree {
    by_frame: HashMap<String, Known>,
}

/// What was told last of a frame.
#[derive(Clone, Debug)]
struct Known {
    transform: Transform,
    /// Whether it was ever told anew, with another stamp; what was told once need not be told again.
    is_alive: bool,
}

/// One frame in another.
#[derive(Clone, Debug, PartialEq)]
pub struct Between {
    pub pose: Pose,
    /// Stamp of the oldest transform on the way, if one of them changes.
    pub oldest: Option<Time>,
    /// Oldest and newest stamp of those that are told again and again, if any is.
    pub alive: Option<(Time, Time)>,
}

/// A frame above another one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ancestor<'t> {
    pub name: &'t str,
    /// Pose, in this frame, of the frame that was asked about.
    pub pose_af: Pose,
    /// The oldest transform on the way, if one of them changes: its frame and stamp.
    pub oldest: Option<(&'t str, Time)>,
    /// Oldest and newest stamp of those on the way that are told again and again.
    alive: Option<(Time, Time)>,
}

/// A clock that was set back by more than this (s) starts anew.
const SET_BACK: f64 = 1.0;

impl TransformTree {
    /// Takes note of a transform; one that is older than the known one is passed over. `false` when there are too many frames.
    #[expect(clippy::needless_pass_by_value, reason = "it is kept")]
    pub fn note(&mut self, frame: &str, transform: Transform) -> bool {
        let frame = frame.trim_start_matches('/');
        let known = self.by_frame.get(frame);
        if known.is_none() && self.by_frame.len() >= MOST_FRAMES {
            return false;
        }
        let stamps = known.and_then(|known| known.transform.stamp).zip(transform.stamp);
        let is_older = stamps
            .is_some_and(|(known, new)| (0.0..SET_BACK).contains(&known.seconds_since(new)) && known != new);
        if !is_older {
            let is_anew = stamps.is_some_and(|(known, new)| known != new);
            let is_alive = is_anew || known.is_some_and(|known| known.is_alive);
            let parent = transform.parent.trim_start_matches('/').to_owned();
            let known = Known { transform: Transform { parent, ..transform }, is_alive };
            self.by_frame.insert(frame.to_owned(), known);
        }
        true
    }

    /// The frame `frame` in the frame `reference`; `None` if nothing connects them.
    #[must_use]
    pub fn between(&self, reference: &str, frame: &str) -> Option<Between> {
        let (of_frame, of_reference) = (self.ancestors(frame), self.ancestors(reference));
        let (above, below) =
            of_frame.iter().find_map(|a| Some((a, of_reference.iter().find(|r| r.name == a.name)?)))?;
        let stamps = [above, below].into_iter().filter_map(|a| a.oldest).map(|(_, stamp)| stamp);
        let pose = below.pose_af.inverse() * above.pose_af;
        Some(Between { pose, oldest: stamps.min(), alive: both(above.alive, below.alive) })
    }

    /// The highest frame above another one, if there is one above it.
    #[must_use]
    pub fn topmost_above<'t>(&'t self, frame: &'t str) -> Option<&'t str> {
        let mut above = frame;
        // loops end where they would come around
        for _ in 0..self.by_frame.len() {
            let known = self.by_frame.get(above).filter(|known| known.transform.parent != frame);
            let Some(Known { transform, .. }) = known else { break };
            above = &transform.parent;
        }
        (above != frame).then_some(above)
    }

    /// The frame itself and those above it, nearest first; ends before it would come around.
    pub(super) fn ancestors<'t>(&'t self, frame: &'t str) -> Vec<Ancestor<'t>> {
        let mut above = vec![Ancestor { name: frame, pose_af: Pose::identity(), oldest: None, alive: None }];
        while let Some(last) = above.last()
            && let Some(Known { transform, is_alive }) = self.by_frame.get(last.name)
            && above.iter().all(|a| a.name != transform.parent)
        {
            let stamped = transform.stamp.map(|stamp| (last.name, stamp));
            let oldest = match (last.oldest, stamped) {
                (Some(a), Some(b)) => Some(if b.1 < a.1 { b } else { a }),
                (a, b) => a.or(b),
            };
            let stamp = transform.stamp.filter(|_| *is_alive);
            let alive = both(last.alive, stamp.map(|stamp| (stamp, stamp)));
            let pose_af = transform.pose_pf * last.pose_af;
            above.push(Ancestor { name: &transform.parent, pose_af, oldest, alive });
        }
        above
    }
}

/// Oldest and newest of both.
fn both(a: Option<(Time, Time)>, b: Option<(Time, Time)>) -> Option<(Time, Time)> {
    match (a, b) {
        (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
        (a, b) => a.or(b),
    }
}
