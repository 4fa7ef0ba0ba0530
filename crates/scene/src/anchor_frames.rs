//! World-fixed frames that obstacles are anchored to, and whether the root's pose in them is known.

use clearance_geometry::math::Pose;

use super::anchor::{Certainty, is_elsewhere};
use super::{FramePath, TransformTree};

/// World-fixed frames that obstacles are anchored to, with their poses in the root frame at the obstacles' last update.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnchorFrames {
    pub(super) root: String,
    pub(super) frames: Vec<WatchedFrame>,
    pub(super) any_unanchored: bool,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct WatchedFrame {
    pub frame: String,
    pub pose_rf: Pose,
    pub certainty: Certainty,
}

impl AnchorFrames {
    /// True if the poses of obstacles need an update now.
    #[must_use]
    pub fn are_elsewhere(&self, transforms: &TransformTree) -> bool {
        let is_one = |WatchedFrame { frame, pose_rf, .. }: &WatchedFrame| {
            let path = transforms.path(&self.root, frame);
            path.is_some_and(|path| is_elsewhere(pose_rf, &path.pose()))
        };
        (self.any_unanchored && transforms.topmost_above(&self.root).is_some())
            || self.frames.iter().any(is_one)
    }

    /// True if no obstacle is anchored or needs an anchor.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty() && !self.any_unanchored
    }

    /// The reason why the root's pose relative to anchored obstacles is unknown: `tf` connected the two once, or connects the root with
    /// other frames only, or does not end above one of the two. A root without any `tf` transform counts as being at zero.
    pub fn root_pose_loss(&self, transforms: &TransformTree) -> Option<RootPoseLoss<'_>> {
        let is_endless = |watched: &WatchedFrame| transforms.is_too_deep(&watched.frame);
        if !self.is_empty() && transforms.is_too_deep(&self.root) || self.frames.iter().any(is_endless) {
            return Some(RootPoseLoss::Endless);
        }
        let is_lost = |watched: &&WatchedFrame| {
            transforms.path(&self.root, &watched.frame).is_none()
                && match watched.certainty {
                    Certainty::FromTf => true,
                    Certainty::Fixed => false,
                    Certainty::Assumed => transforms.topmost_above(&self.root).is_some(),
                }
        };
        self.frames.iter().find(is_lost).map(|watched| RootPoseLoss::In(&watched.frame))
    }

    /// A world-fixed frame with obstacles in which the root is assumed to be at zero, because its pose is not available.
    pub fn assumed_frame(&self, transforms: &TransformTree) -> Option<&str> {
        let is_assumed = |watched: &&WatchedFrame| {
            watched.certainty == Certainty::Assumed && transforms.path(&self.root, &watched.frame).is_none()
        };
        self.frames.iter().find(is_assumed).map(|watched| watched.frame.as_str())
    }

    /// A world-fixed frame with obstacles in which `tf` has placed the root by a transform that was received only once and is not
    /// static.
    pub fn singly_placed_frame(&self, transforms: &TransformTree) -> Option<&str> {
        let is_single = |watched: &&WatchedFrame| {
            transforms.path(&self.root, &watched.frame).is_some_and(|path| path.has_single_transform())
        };
        self.frames.iter().find(is_single).map(|watched| watched.frame.as_str())
    }

    /// The world-fixed frames that `tf` publishes repeatedly, relative to the root.
    pub fn tracked_frames<'g>(
        &'g self,
        transforms: &'g TransformTree,
    ) -> impl Iterator<Item = TrackedFrame<'g>> {
        self.frames.iter().filter_map(|WatchedFrame { frame, .. }| {
            let path = transforms.path(&self.root, frame)?;
            path.live_links().next()?;
            Some(TrackedFrame { frame, path })
        })
    }
}

/// The reason why the root's pose is unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RootPoseLoss<'g> {
    /// `tf` does not connect it with this frame.
    In(&'g str),
    /// Above the root, or above a frame of anchored obstacles, `tf` contains a circle, or more frames than the search visits.
    Endless,
}

/// A world-fixed frame that `tf` publishes repeatedly.
#[derive(Debug)]
pub struct TrackedFrame<'g> {
    /// Name of the frame.
    pub frame: &'g str,
    /// The path from the root to the frame.
    pub path: FramePath<'g>,
}
