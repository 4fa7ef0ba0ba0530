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
    by_frame: HashMap<String, Transform>,
}

/// A frame above another one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ancestor<'t> {
    pub name: &'t str,
    /// Pose, in this frame, of the frame that was asked about.
    pub pose_af: Pose,
    /// The oldest transform on the way, if one of them changes: its frame and stamp.
    pub oldest: Option<(&'t str, Time)>,
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
        let older = known.is_some_and(|known| match (known.stamp, transform.stamp) {
            (Some(known), Some(new)) => (0.0..SET_BACK).contains(&known.seconds_since(new)) && known != new,
            _ => false,
        });
        if !older {
            self.by_frame.insert(
                frame.to_owned(),
                Transform { parent: transform.parent.trim_start_matches('/').to_owned(), ..transform },
            );
        }
        true
    }

    /// Pose of `frame` in the frame `reference`, and the stamp of the oldest transform on the way, if one of them changes; `None` if
    /// nothing connects them.
    #[must_use]
    pub fn pose_between(&self, reference: &str, frame: &str) -> Option<(Pose, Option<Time>)> {
        let (of_frame, of_reference) = (self.ancestors(frame), self.ancestors(reference));
        let (above, below) =
            of_frame.iter().find_map(|a| Some((a, of_reference.iter().find(|r| r.name == a.name)?)))?;
        let stamps = [above, below].into_iter().filter_map(|a| a.oldest).map(|(_, stamp)| stamp);
        Some((below.pose_af.inverse() * above.pose_af, stamps.min()))
    }

    /// The highest frame above another one, if there is one above it.
    #[must_use]
    pub fn topmost_above<'t>(&'t self, frame: &'t str) -> Option<&'t str> {
        let mut above = frame;
        // loops end where they would come around
        for _ in 0..self.by_frame.len() {
            let Some(transform) = self.by_frame.get(above).filter(|t| t.parent != frame) else { break };
            above = &transform.parent;
        }
        (above != frame).then_some(above)
    }

    /// The frame itself and those above it, nearest first; ends before it would come around.
    pub(super) fn ancestors<'t>(&'t self, frame: &'t str) -> Vec<Ancestor<'t>> {
        let mut above = vec![Ancestor { name: frame, pose_af: Pose::identity(), oldest: None }];
        while let Some(last) = above.last()
            && let Some(transform) = self.by_frame.get(last.name)
            && above.iter().all(|a| a.name != transform.parent)
        {
            let stamped = transform.stamp.map(|stamp| (last.name, stamp));
            let oldest = match (last.oldest, stamped) {
                (Some(a), Some(b)) => Some(if b.1 < a.1 { b } else { a }),
                (a, b) => a.or(b),
            };
            let pose_af = transform.pose_pf * last.pose_af;
            above.push(Ancestor { name: &transform.parent, pose_af, oldest });
        }
        above
    }
}
