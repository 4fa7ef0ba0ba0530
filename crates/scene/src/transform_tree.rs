//! Tree of `tf` frames: the latest transform of each frame, its replaced transforms, and paths between frames.

use std::collections::{HashMap, VecDeque};

use clearance_geometry::math::{Extremes, Pose};

use super::Time;
use super::frame_ancestor::Ancestor;
use super::frame_path::FramePath;
use super::transform::{StoredTransform, Transform};

/// Maximum number of stored frames, so that a hostile network cannot fill the memory.
const MOST_FRAMES: usize = 10_000;

/// Maximum number of ancestors that a search visits; ends searches in circles.
const MOST_ABOVE: usize = 256;

/// Time (s) by which the stamp of a transform may be later than the clock. A later one is of a clock that was set back.
const LARGEST_LEAD: f64 = 1.0;

/// Maximum number of replaced transforms that are kept, for each frame and in all.
const MOST_REPLACED: usize = 256;
const MOST_REPLACED_IN_ALL: usize = 50_000;

/// Number that is kept for each frame in any case.
const LEAST_REPLACED: usize = 16;

/// The latest transform of every frame, and a few before it, for readers that come late.
#[derive(Clone, Debug, Default)]
pub struct TransformTree {
    by_frame: HashMap<String, StoredTransform>,
    replaced: HashMap<String, ReplacedTransforms>,
    /// Number of replaced transforms that are kept.
    kept: usize,
    /// Number of transforms that were stored.
    stored: u64,
}

/// The last transforms of a frame in its parent that newer ones have replaced, oldest first.
#[derive(Clone, Debug, Default)]
struct ReplacedTransforms {
    poses: VecDeque<NumberedPose>,
    /// Number of the last one that is not kept.
    lost: u64,
}

/// Pose of a frame in its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberedPose {
    /// Number of the transform in the order of reception.
    pub number: u64,
    /// Stamp of the transform.
    pub stamp: Time,
    /// The pose.
    pub pose_pf: Pose,
}

impl ReplacedTransforms {
    /// Adds a pose; at most `most` are kept.
    fn push(&mut self, pose: NumberedPose, most: usize) {
        self.poses.push_back(pose);
        while self.poses.len() > most {
            self.lost = self.poses.pop_front().map_or(self.lost, |lost| lost.number);
        }
    }
}

impl TransformTree {
    /// Stores a transform, unless it is older than the stored one. Returns `false` when there are too many frames.
    ///
    /// As in tf2, an older transform never replaces a newer one, whatever its age.
    pub fn insert(&mut self, frame: &str, transform: Transform) -> bool {
        self.insert_received(frame, transform, None)
    }

    /// As [`Self::insert`], with the time at which the transform was received, where it is known. If the clock was set back since the
    /// stored transform was received, an older one replaces it.
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
        let is_set_back = |known: Time| received.is_some_and(|now| known.seconds_since(now) > LARGEST_LEAD);
        let is_older = stamps.is_some_and(|(known, new)| new < known && !is_set_back(known));
        if !is_older {
            let is_anew = stamps.is_some_and(|(known, new)| known != new);
            let is_alive = is_anew || known.is_some_and(|known| known.is_alive);
            let parent = transform.parent.trim_start_matches('/').to_owned();
            let times = transform.stamp.zip(received);
            let lead = times.map_or(0.0, |(stamp, received)| stamp.seconds_since(received).greater(0.0));
            self.stored += 1;
            let transform = Transform { parent, ..transform };
            let new = StoredTransform { transform, lead, is_alive, number: self.stored };
            let replaced = self.by_frame.insert(frame.to_owned(), new);
            if let Some(replaced) = replaced {
                self.note_replaced(frame, &replaced);
            }
        }
        true
    }

    /// Keeps a transform that a newer one has replaced, where both have a parent and an order.
    fn note_replaced(&mut self, frame: &str, before: &StoredTransform) {
        let now = &self.by_frame[frame].transform;
        let Transform { parent, pose_pf, stamp } = &before.transform;
        let is_same = (parent, pose_pf) == (&now.parent, &now.pose_pf);
        if is_same && (now.stamp.is_none() || stamp == &now.stamp) {
            return;
        }
        let is_in_order = *parent == now.parent && now.stamp.is_some() && *stamp != now.stamp;
        let replaced = self.replaced.entry(frame.to_owned()).or_default();
        self.kept -= replaced.poses.len();
        match stamp.filter(|_| is_in_order) {
            Some(stamp) => {
                let left = MOST_REPLACED_IN_ALL.saturating_sub(self.kept);
                let pose = NumberedPose { number: before.number, stamp, pose_pf: *pose_pf };
                replaced.push(pose, left.clamp(LEAST_REPLACED, MOST_REPLACED));
            }
            None => *replaced = ReplacedTransforms { poses: VecDeque::new(), lost: before.number },
        }
        self.kept += replaced.poses.len();
    }

    /// Number of transforms that were stored so far.
    #[must_use]
    pub fn stored(&self) -> u64 {
        self.stored
    }

    /// The poses of a frame in its parent that were received after the transform with this number, oldest first, and the one before
    /// them, if it is kept; `None` if some are not kept any more.
    #[must_use]
    pub fn poses_since(&self, frame: &str, number: u64) -> Option<Vec<NumberedPose>> {
        let replaced = self.replaced.get(frame);
        if replaced.is_some_and(|replaced| replaced.lost > number) {
            return None;
        }
        let latest = self.by_frame.get(frame).and_then(|StoredTransform { transform, number, .. }| {
            Some(NumberedPose { number: *number, stamp: transform.stamp?, pose_pf: transform.pose_pf })
        });
        let poses: Vec<NumberedPose> =
            replaced.iter().flat_map(|replaced| &replaced.poses).copied().chain(latest).collect();
        let first = poses.iter().rposition(|pose| pose.number <= number).unwrap_or(0);
        Some(poses[first..].to_vec())
    }

    /// The latest transforms, without those before them.
    #[must_use]
    pub fn latest(&self) -> Self {
        let by_frame = self.by_frame.clone();
        Self { by_frame, stored: self.stored, ..Self::default() }
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
