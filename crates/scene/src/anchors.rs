//! Anchors: poses of obstacles in world-fixed frames. A table in a room keeps its place in the room while the robot drives.
//!
//! All poses of the world are stored in the root frame. An obstacle therefore also stores its pose in a world-fixed frame. This is
//! MoveIt's planning frame, the parent of the SRDF's virtual joint, if `tf` connects it with the root, or else the topmost `tf` frame
//! above the root. When `tf` reports another pose of the root in that frame, the obstacle's pose in the root frame is updated. Fixed
//! frames of a scene are updated in the same way.

use clearance_geometry::math::Pose;
use clearance_robot::RobotModel;

use super::Time;
use super::frames::PlacedBy;
use super::{Scene, SceneContext, TransformTree, Way};

/// Smaller displacements (m, rad) do not count as motion of the root.
const STILL: f64 = 1e-4;

/// Pose of an object or frame in a world-fixed frame, which is no part of the robot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Anchor {
    frame: String,
    pose_fo: Pose,
    /// Pose of the world-fixed frame in the root frame at the last update. It cannot be computed from the two other poses: far from the
    /// root, rounding exceeds the motion threshold.
    pose_rf: Pose,
    certainty: Certainty,
}

/// A world-fixed frame that objects are anchored to.
pub(super) struct AnchorFrame {
    pub frame: String,
    /// Its present pose in the root frame.
    pub pose_rf: Pose,
    pub certainty: Certainty,
}

/// Source of a world-fixed frame's pose, in ascending order of information about where the root may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Certainty {
    /// A fixed virtual joint puts the root at zero in the frame.
    Fixed,
    /// Without any information, the root is assumed to be at zero in the frame.
    Assumed,
    /// `tf` has given the pose at least once.
    Told,
}

impl Anchor {
    fn new(AnchorFrame { frame, pose_rf, certainty }: AnchorFrame, pose_ro: &Pose) -> Self {
        Self { frame, pose_fo: pose_rf.inverse() * pose_ro, pose_rf, certainty }
    }

    /// The same anchored pose, for an object that was placed at its own pose in the root frame.
    fn of(&self, pose_ro: &Pose) -> Self {
        Self { pose_rf: pose_ro * self.pose_fo.inverse(), ..self.clone() }
    }

    /// The new pose in the root frame, if it differs from the last one.
    fn follow(&mut self, context: &SceneContext) -> Option<Pose> {
        let now = context.pose_by_tf(&self.frame)?;
        self.certainty = Certainty::Told;
        is_elsewhere(&self.pose_rf, &now).then(|| {
            self.pose_rf = now;
            now * self.pose_fo
        })
    }
}

impl Scene {
    /// Anchors an obstacle that was just placed in `frame` to a world-fixed frame.
    pub fn anchor(&mut self, name: &str, frame: &str, context: &SceneContext) {
        self.anchors.remove(name);
        let Some(obstacle) = self.world.obstacle_by_name(name) else { return };
        if let Some(ground) = self.ground(frame, context) {
            self.anchors.insert(name.to_owned(), Anchor::new(ground, &obstacle.pose_ro));
        }
    }

    /// As above, for a fixed frame of a scene.
    pub(super) fn anchor_frame(&mut self, name: &str, parent: &str, context: &SceneContext) {
        self.frame_anchors.remove(name);
        let Some(pose_rf) = self.fixed_frames.get(name) else { return };
        if let Some(ground) = self.ground(parent, context) {
            self.frame_anchors.insert(name.to_owned(), Anchor::new(ground, pose_rf));
        }
    }

    /// The world-fixed frame that objects placed in `frame` are anchored to.
    fn ground(&self, frame: &str, context: &SceneContext) -> Option<AnchorFrame> {
        let frame = frame.trim_start_matches('/');
        let below = context.placed_by(frame, self).and_then(|placed_by| match placed_by {
            PlacedBy::Obstacle(name) => self.anchors.get(name),
            PlacedBy::FixedFrame(name) => self.frame_anchors.get(name),
        });
        // an anchor that does not come from tf also applies to objects placed in its frame
        let assumed =
            below.filter(|anchor| anchor.certainty != Certainty::Told).map(|anchor| anchor.frame.as_str());
        context.ground(assumed.unwrap_or(frame))
    }

    /// Objects that had the same names before keep their earlier anchors, if `tf` connects those with the root.
    pub fn stand_as(&mut self, before: &Self, context: &SceneContext) {
        let is_known = |(_, anchor): &(&String, &Anchor)| context.pose_by_tf(&anchor.frame).is_some();
        for (name, anchor) in before.anchors.iter().filter(is_known) {
            if let Some(obstacle) = self.world.obstacle_by_name(name) {
                self.anchors.insert(name.clone(), anchor.of(&obstacle.pose_ro));
            }
        }
        for (name, anchor) in before.frame_anchors.iter().filter(is_known) {
            if let Some(pose_rf) = self.fixed_frames.get(name) {
                self.frame_anchors.insert(name.clone(), anchor.of(pose_rf));
            }
        }
    }

    /// Updates all anchored poses after a motion of the root; returns true if anything changed. Obstacles without an anchor are anchored
    /// to a frame that `tf` has since provided.
    pub fn follow_frames(&mut self, context: &SceneContext) -> bool {
        self.anchors.retain(|name, _| self.world.obstacle_by_name(name).is_some());
        let before = self.anchors.len();
        for name in self.ungrounded().cloned().collect::<Vec<String>>() {
            self.anchor(&name, "", context);
        }
        let mut has_changed = self.anchors.len() > before;
        for (name, anchor) in &mut self.anchors {
            if let Some(pose_ro) = anchor.follow(context) {
                has_changed = true;
                // cannot fail: the obstacle was just found
                let _ = self.world.move_to(name, pose_ro);
            }
        }
        for (name, pose_rf) in &mut self.fixed_frames {
            let anchor = self.frame_anchors.get_mut(name);
            if let Some(now) = anchor.and_then(|anchor| anchor.follow(context)) {
                has_changed = true;
                *pose_rf = now;
            }
        }
        has_changed
    }

    /// Obstacles without an anchor.
    fn ungrounded(&self) -> impl Iterator<Item = &String> {
        self.world.obstacles().map(|obstacle| &obstacle.name).filter(|name| !self.anchors.contains_key(*name))
    }

    /// The frames to watch, to detect when obstacles need an update.
    #[must_use]
    pub fn grounds(&self, robot: &RobotModel) -> AnchorFrames {
        let mut frames: Vec<Watched> = Vec::new();
        let is_there = |(name, _): &(&String, &Anchor)| self.world.obstacle_by_name(name).is_some();
        for (_, Anchor { frame, pose_rf, certainty, .. }) in self.anchors.iter().filter(is_there) {
            if let Some(known) = frames.iter_mut().find(|known| known.frame == *frame) {
                known.certainty = known.certainty.max(*certainty);
            } else {
                frames.push(Watched { frame: frame.clone(), pose_rf: *pose_rf, certainty: *certainty });
            }
        }
        let root = robot.link(robot.root()).name.clone();
        AnchorFrames { root, frames, any_ungrounded: self.ungrounded().next().is_some() }
    }
}

/// World-fixed frames that obstacles are anchored to, with their poses in the root frame at the obstacles' last update.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnchorFrames {
    root: String,
    frames: Vec<Watched>,
    any_ungrounded: bool,
}

#[derive(Clone, Debug, PartialEq)]
struct Watched {
    frame: String,
    pose_rf: Pose,
    certainty: Certainty,
}

impl AnchorFrames {
    /// True if the poses of obstacles need an update now.
    #[must_use]
    pub fn are_elsewhere(&self, transforms: &TransformTree) -> bool {
        let is_one = |Watched { frame, pose_rf, .. }: &Watched| {
            let way = transforms.way(&self.root, frame);
            way.is_some_and(|way| is_elsewhere(pose_rf, &way.pose()))
        };
        (self.any_ungrounded && transforms.topmost_above(&self.root).is_some())
            || self.frames.iter().any(is_one)
    }

    /// True if no obstacle is anchored or needs an anchor.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty() && !self.any_ungrounded
    }

    /// The reason why the root's pose relative to anchored obstacles is unknown: `tf` connected the two once, or connects the root with
    /// other frames only, or does not end above one of the two. A root without any `tf` transform counts as being at zero.
    pub fn lost(&self, transforms: &TransformTree) -> Option<Lost<'_>> {
        let is_endless = |watched: &Watched| transforms.is_too_deep(&watched.frame);
        if !self.is_empty() && transforms.is_too_deep(&self.root) || self.frames.iter().any(is_endless) {
            return Some(Lost::Endless);
        }
        let is_lost = |watched: &&Watched| {
            transforms.way(&self.root, &watched.frame).is_none()
                && match watched.certainty {
                    Certainty::Told => true,
                    Certainty::Fixed => false,
                    Certainty::Assumed => transforms.topmost_above(&self.root).is_some(),
                }
        };
        self.frames.iter().find(is_lost).map(|watched| Lost::In(&watched.frame))
    }

    /// A world-fixed frame with obstacles in which the root is assumed to be at zero, because its pose is not available.
    pub fn assumed(&self, transforms: &TransformTree) -> Option<&str> {
        let is_assumed = |watched: &&Watched| {
            watched.certainty == Certainty::Assumed && transforms.way(&self.root, &watched.frame).is_none()
        };
        self.frames.iter().find(is_assumed).map(|watched| watched.frame.as_str())
    }

    /// The world-fixed frames that `tf` publishes repeatedly, relative to the root.
    pub fn tracked_frames<'g>(
        &'g self,
        transforms: &'g TransformTree,
    ) -> impl Iterator<Item = TrackedFrame<'g>> {
        self.frames.iter().filter_map(|Watched { frame, .. }| {
            let way = transforms.way(&self.root, frame)?;
            Some(TrackedFrame { frame, stamp: way.oldest_alive()?, way })
        })
    }
}

/// The reason why the root's pose is unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lost<'g> {
    /// `tf` does not connect it with this frame.
    In(&'g str),
    /// Above the root, or above a frame of anchored obstacles, `tf` contains a circle, or more frames than the search visits.
    Endless,
}

/// A world-fixed frame that `tf` publishes repeatedly.
#[derive(Debug)]
pub struct TrackedFrame<'g> {
    pub frame: &'g str,
    /// The path from the root to the frame.
    pub way: Way<'g>,
    /// Stamp of the oldest repeatedly published transform on the path.
    pub stamp: Time,
}

/// True if a frame's pose in the root frame has changed, as observed from the root.
pub fn is_elsewhere(before: &Pose, now: &Pose) -> bool {
    // far from the root, the product of a pose and its own inverse differs from the identity by rounding
    let way = now * before.inverse();
    before != now && (way.translation.vector.norm() > STILL || way.rotation.angle() > STILL)
}
