//! Frames of other publishers: the latest transform of each, from `tf` and `tf_static`.

use std::collections::HashMap;

use clearance_geometry::math::{Extremes, Pose};

use super::Time;
use super::frame_ancestor::Ancestor;
use super::frame_path::FramePath;
use super::transform::{StoredTransform, Transform};

/// Maximum number of stored frames, so that a hostile network cannot fill the memory.
const MOST_FRAMES: usize = 10_000;

/// Maximum number of ancestors that a search visits; ends searches in circles.
const MOST_ABOVE: usize = 256;

/// If the clock is set back by more than this (s), older transforms are accepted again.
const SET_BACK: f64 = 1.0;

/// The latest transform of every frame.
#[derive(Clone, Debug, Default)]
pub struct TransformTree {
    by_frame: HashMap<String, StoredTransform>,
}

impl TransformTree {
    /// Stores a transform, unless it is older than the stored one. Returns `false` when there are too many frames.
    pub fn insert(&mut self, frame: &str, transform: Transform) -> bool {
        self.insert_received(frame, transform, None)
    }

    /// As [`Self::insert`], with the time at which the transform was received, where it is known.
    #[expect(clippy::needless_pass_by_value, reason = "it is kept")]
    pub fn insert_received(&mut self, frame: &str, transform: Transform, received: Option<Time>) -> bool {
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
            let times = transform.stamp.zip(received);
            let lead = times.map_or(0.0, |(stamp, received)| stamp.seconds_since(received).greater(0.0));
            let known = StoredTransform { transform: Transform { parent, ..transform }, lead, is_alive };
            self.by_frame.insert(frame.to_owned(), known);
        }
        true
    }

    /// The path from the frame `reference` to the frame `frame`; `None` if they are not connected.
    #[must_use]
    pub fn path<'t>(&'t self, reference: &'t str, frame: &'t str) -> Option<FramePath<'t>> {
        FramePath::between(self.ancestors(reference), self.ancestors(frame))
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

    /// The frame itself and its ancestors, nearest first, up to the search limit.
    pub(super) fn ancestors<'t>(&'t self, frame: &'t str) -> Vec<Ancestor<'t>> {
        let transform_of = |name: &str| self.by_frame.get(name);
        let itself = Ancestor {
            name: frame,
            transform: transform_of(frame),
            pose_af: Pose::identity(),
            oldest: None,
            largest_lead: None,
        };
        let above = std::iter::successors(Some(itself), |last| last.parent(transform_of));
        above.take(MOST_ABOVE + 1).collect()
    }
}
