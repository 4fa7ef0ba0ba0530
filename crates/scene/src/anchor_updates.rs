//! Updates of anchors: obstacles keep their poses in world-fixed frames while the robot moves. A table in a room keeps
//! its place in the room while the robot drives.
//!
//! All poses of the world are stored in the root frame. An obstacle therefore also stores its pose in a world-fixed frame. This is
//! MoveIt's planning frame, the parent of the SRDF's virtual joint, if `tf` connects it with the root, or else the topmost `tf` frame
//! above the root. When `tf` reports another pose of the root in that frame, the obstacle's pose in the root frame is updated. Fixed
//! frames of a scene are updated in the same way.

use clearance_robot::RobotModel;

use super::anchor::{Anchor, AnchorFrame, Certainty};
use super::anchor_frames::{AnchorFrames, WatchedFrame};
use super::frame_lookup::PlacedBy;
use super::{Scene, SceneContext};

impl Scene {
    /// Anchors an obstacle that was just placed in `frame` to a world-fixed frame.
    pub fn anchor(&mut self, name: &str, frame: &str, context: &SceneContext) {
        self.anchors.remove(name);
        let Some(obstacle) = self.world.obstacle_by_name(name) else { return };
        if let Some(anchor_frame) = self.anchor_frame_of(frame, context) {
            self.anchors.insert(name.to_owned(), Anchor::new(anchor_frame, &obstacle.pose_ro));
        }
    }

    /// As above, for a fixed frame of a scene.
    pub(super) fn anchor_fixed_frame(&mut self, name: &str, parent: &str, context: &SceneContext) {
        self.frame_anchors.remove(name);
        let Some(pose_rf) = self.fixed_frames.get(name) else { return };
        if let Some(anchor_frame) = self.anchor_frame_of(parent, context) {
            self.frame_anchors.insert(name.to_owned(), Anchor::new(anchor_frame, pose_rf));
        }
    }

    /// The world-fixed frame that objects placed in `frame` are anchored to.
    fn anchor_frame_of(&self, frame: &str, context: &SceneContext) -> Option<AnchorFrame> {
        let frame = frame.trim_start_matches('/');
        let below = context.placed_by(frame, self).and_then(|placed_by| match placed_by {
            PlacedBy::Obstacle(name) => self.anchors.get(name),
            PlacedBy::FixedFrame(name) => self.frame_anchors.get(name),
        });
        // an anchor that does not come from tf also applies to objects placed in its frame
        let assumed =
            below.filter(|anchor| anchor.certainty != Certainty::FromTf).map(|anchor| anchor.frame.as_str());
        context.anchor_frame(assumed.unwrap_or(frame))
    }

    /// Objects that had the same names before keep their earlier anchors, if `tf` connects those with the root.
    pub fn keep_anchors_of(&mut self, before: &Self, context: &SceneContext) {
        let is_known = |(_, anchor): &(&String, &Anchor)| context.pose_by_tf(&anchor.frame).is_some();
        for (name, anchor) in before.anchors.iter().filter(is_known) {
            if let Some(obstacle) = self.world.obstacle_by_name(name) {
                self.anchors.insert(name.clone(), anchor.at_pose(&obstacle.pose_ro));
            }
        }
        for (name, anchor) in before.frame_anchors.iter().filter(is_known) {
            if let Some(pose_rf) = self.fixed_frames.get(name) {
                self.frame_anchors.insert(name.clone(), anchor.at_pose(pose_rf));
            }
        }
    }

    /// Updates all anchored poses after a motion of the root; returns true if anything changed. Obstacles without an anchor are anchored
    /// to a frame that `tf` has since provided.
    pub fn follow_anchor_frames(&mut self, context: &SceneContext) -> bool {
        self.anchors.retain(|name, _| self.world.obstacle_by_name(name).is_some());
        let before = self.anchors.len();
        for name in self.unanchored().cloned().collect::<Vec<String>>() {
            self.anchor(&name, "", context);
        }
        let mut has_changed = self.anchors.len() > before;
        for (name, anchor) in &mut self.anchors {
            if let Some(pose_ro) = anchor.follow(context.pose_by_tf(&anchor.frame)) {
                has_changed = true;
                // cannot fail: the obstacle was just found
                let _ = self.world.move_to(name, pose_ro);
            }
        }
        for (name, pose_rf) in &mut self.fixed_frames {
            let anchor = self.frame_anchors.get_mut(name);
            if let Some(now) = anchor.and_then(|anchor| anchor.follow(context.pose_by_tf(&anchor.frame))) {
                has_changed = true;
                *pose_rf = now;
            }
        }
        has_changed
    }

    /// Obstacles without an anchor.
    fn unanchored(&self) -> impl Iterator<Item = &String> {
        self.world.obstacles().map(|obstacle| &obstacle.name).filter(|name| !self.anchors.contains_key(*name))
    }

    /// The frames to watch, to detect when obstacles need an update.
    #[must_use]
    pub fn anchor_frames(&self, robot: &RobotModel) -> AnchorFrames {
        let mut frames: Vec<WatchedFrame> = Vec::new();
        let is_there = |(name, _): &(&String, &Anchor)| self.world.obstacle_by_name(name).is_some();
        for (_, Anchor { frame, pose_rf, certainty, .. }) in self.anchors.iter().filter(is_there) {
            if let Some(known) = frames.iter_mut().find(|known| known.frame == *frame) {
                known.certainty = known.certainty.max(*certainty);
            } else {
                frames.push(WatchedFrame { frame: frame.clone(), pose_rf: *pose_rf, certainty: *certainty });
            }
        }
        let root = robot.link(robot.root()).name.clone();
        AnchorFrames { root, frames, any_unanchored: self.unanchored().next().is_some() }
    }
}
