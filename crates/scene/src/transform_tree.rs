//! Frames of other publishers: the latest transform of each, from `tf` and `tf_static`.

use std::collections::HashMap;

use clearance_geometry::math::Pose;

use super::Time;
use super::way::Way;

/// Maximum number of stored frames, so that a hostile network cannot fill the memory.
const MOST_FRAMES: usize = 10_000;

/// Maximum number of ancestors that a search visits; ends searches in circles.
const MOST_ABOVE: usize = 256;

/// If the clock is set back by more than this (s), older transforms are accepted again.
const SET_BACK: f64 = 1.0;

/// The transform of a frame relative to its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Transform {
    pub parent: String,
    /// Pose of the frame in its parent.
    pub pose_pf: Pose,
    /// Stamp of the transform; `None` if it is static.
    pub stamp: Option<Time>,
}

/// The latest transform of every frame.
#[derive(Clone, Debug, Default)]
pub struct TransformTree {
    by_frame: HashMap<String, Known>,
}

/// The latest transform of a frame.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub transform: Transform,
    /// True if the frame was received more than once, with different stamps; a frame received only once need not be repeated.
    pub is_alive: bool,
}

/// An ancestor of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ancestor<'t> {
    pub name: &'t str,
    /// Pose, in this ancestor, of the frame that the search started from.
    pub pose_af: Pose,
    /// The oldest transform on the path, if one of them is not static: its frame and stamp.
    pub oldest: Option<(&'t str, Time)>,
    /// The stamp of the oldest repeatedly published transform on the path.
    pub oldest_alive: Option<Time>,
}

impl TransformTree {
    /// Stores a transform, unless it is older than the stored one. Returns `false` when there are too many frames.
    #[expect(clippy::needless_pass_by_value, reason = "it is kept")]
    pub fn note(&mut self, frame: &str, transform: Transform) -> bool {
        let frame = frame.trim_start_matches('/');
        if transform.parent.trim_start_matches('/') == frame {
            // as in tf2: a frame relative to itself has no information
            return true;
        }
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

    /// The path from the frame `reference` to the frame `frame`; `None` if they are not connected.
    #[must_use]
    pub fn way<'t>(&'t self, reference: &'t str, frame: &'t str) -> Option<Way<'t>> {
        Way::find(self, reference, frame)
    }

    /// The topmost ancestor of a frame, if it has one.
    #[must_use]
    pub fn topmost_above<'t>(&'t self, frame: &'t str) -> Option<&'t str> {
        self.ancestors(frame).last().map(|last| last.name).filter(|&topmost| topmost != frame)
    }

    /// True if a frame has more ancestors than a search visits, as in a circle.
    #[must_use]
    pub fn is_too_deep(&self, frame: &str) -> bool {
        self.ancestors(frame).last().is_some_and(|last| self.by_frame.contains_key(last.name))
    }

    pub(super) fn known(&self, frame: &str) -> Option<&Known> {
        self.by_frame.get(frame)
    }

    /// The frame itself and its ancestors, nearest first, up to the search limit.
    pub(super) fn ancestors<'t>(&'t self, frame: &'t str) -> Vec<Ancestor<'t>> {
        let itself = Ancestor { name: frame, pose_af: Pose::identity(), oldest: None, oldest_alive: None };
        let above =
            std::iter::successors(Some(itself), |last| self.known(last.name).map(|known| known.above(last)));
        above.take(MOST_ABOVE + 1).collect()
    }
}

impl Known {
    /// The parent of an ancestor, as the next ancestor.
    fn above<'t>(&'t self, frame: &Ancestor<'t>) -> Ancestor<'t> {
        let transform = &self.transform;
        let stamped = transform.stamp.map(|stamp| (frame.name, stamp));
        let oldest = match (frame.oldest, stamped) {
            (Some(a), Some(b)) => Some(if b.1 < a.1 { b } else { a }),
            (a, b) => a.or(b),
        };
        let alive = transform.stamp.filter(|_| self.is_alive);
        let oldest_alive = [frame.oldest_alive, alive].into_iter().flatten().min();
        Ancestor { name: &transform.parent, pose_af: transform.pose_pf * frame.pose_af, oldest, oldest_alive }
    }
}
