//! What obstacles stand in while the robot's root moves: a table in a room stays in the room when the robot drives through it.
//!
//! All poses of the world are kept in the root's frame, so an obstacle remembers where it is in the frame that `MoveIt` plans in, the parent of the
//! SRDF's virtual joint, if `tf` connects that with the root, or else in the topmost frame of `tf` above the root. Whenever `tf` says that the
//! root is elsewhere in that frame, the obstacle is put where it belongs. So are the frames that a scene told of.

use clearance_geometry::math::Pose;
use clearance_robot::RobotModel;

use super::Time;
use super::frames::PlacedBy;
use super::{Scene, SceneContext, TransformTree, Way};

/// Less than this (m, rad) is no motion of the root.
const STILL: f64 = 1e-4;

/// Where something is in a frame that is no part of the robot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Anchor {
    frame: String,
    pose_fo: Pose,
    /// Pose of the frame in the root's frame that it was last put by. What it is and where it is do not tell this again: far from the root
    /// that rounds to more than what counts as motion.
    pose_rf: Pose,
    certainty: Certainty,
}

/// A frame that things stand in.
pub(super) struct AnchorFrame {
    pub frame: String,
    /// Its pose in the root's frame now.
    pub pose_rf: Pose,
    pub certainty: Certainty,
}

/// How it is known where a frame is; what says more about where the root may be is greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Certainty {
    /// A virtual joint that never moves puts the root at zero in it.
    Fixed,
    /// As nobody has told, the root counts as standing at zero in it.
    Assumed,
    /// `tf` told it, at least once.
    Told,
}

impl Anchor {
    fn new(AnchorFrame { frame, pose_rf, certainty }: AnchorFrame, pose_ro: &Pose) -> Self {
        Self { frame, pose_fo: pose_rf.inverse() * pose_ro, pose_rf, certainty }
    }

    /// The same place for what was put at a pose of its own.
    fn of(&self, pose_ro: &Pose) -> Self {
        Self { pose_rf: pose_ro * self.pose_fo.inverse(), ..self.clone() }
    }

    /// Where it has to be now, if that is elsewhere than it is.
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
    /// Lets an obstacle, which was placed in a frame just now, stay where it is in what it stands in.
    pub fn anchor(&mut self, name: &str, frame: &str, context: &SceneContext) {
        self.anchors.remove(name);
        let Some(obstacle) = self.world.obstacle_by_name(name) else { return };
        if let Some(ground) = self.ground(frame, context) {
            self.anchors.insert(name.to_owned(), Anchor::new(ground, &obstacle.pose_ro));
        }
    }

    /// The same for a frame that a scene told of.
    pub(super) fn anchor_frame(&mut self, name: &str, parent: &str, context: &SceneContext) {
        self.frame_anchors.remove(name);
        let Some(pose_rf) = self.fixed_frames.get(name) else { return };
        if let Some(ground) = self.ground(parent, context) {
            self.frame_anchors.insert(name.to_owned(), Anchor::new(ground, pose_rf));
        }
    }

    /// What stands in a frame, stands in this.
    fn ground(&self, frame: &str, context: &SceneContext) -> Option<AnchorFrame> {
        let frame = frame.trim_start_matches('/');
        let below = context.placed_by(frame, self).and_then(|placed_by| match placed_by {
            PlacedBy::Obstacle(name) => self.anchors.get(name),
            PlacedBy::FixedFrame(name) => self.frame_anchors.get(name),
        });
        // what is not by tf holds for what was placed in it, too
        let assumed =
            below.filter(|anchor| anchor.certainty != Certainty::Told).map(|anchor| anchor.frame.as_str());
        context.ground(assumed.unwrap_or(frame))
    }

    /// Things of the same names that stood somewhere before stand there still, if `tf` connects that with the root.
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

    /// Puts everything where it belongs now that the root may be elsewhere; whether that changed anything. What stands in nothing yet stands
    /// from now on in what `tf` has come to know.
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
                // it was there right now
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

    /// Obstacles that stand in nothing.
    fn ungrounded(&self) -> impl Iterator<Item = &String> {
        self.world.obstacles().map(|obstacle| &obstacle.name).filter(|name| !self.anchors.contains_key(*name))
    }

    /// What has to be looked at to know whether obstacles are where they belong.
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

/// The frames that obstacles stand in, and where they were in the root's frame when these were put where they are.
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
    /// Whether obstacles have to be put elsewhere now.
    #[must_use]
    pub fn are_elsewhere(&self, transforms: &TransformTree) -> bool {
        let is_one = |Watched { frame, pose_rf, .. }: &Watched| {
            let way = transforms.way(&self.root, frame);
            way.is_some_and(|way| is_elsewhere(pose_rf, &way.pose()))
        };
        (self.any_ungrounded && transforms.topmost_above(&self.root).is_some())
            || self.frames.iter().any(is_one)
    }

    /// Whether there is nothing that may stand in a frame.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty() && !self.any_ungrounded
    }

    /// Why the root might be anywhere in what obstacles stand in: `tf` connected the two once, connects the root with others only, or does not
    /// end above one of the two. A root of which `tf` knows nothing stands at zero.
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

    /// A frame that obstacles stand in, in which the root counts as standing at zero because nobody tells where it is.
    pub fn assumed(&self, transforms: &TransformTree) -> Option<&str> {
        let is_assumed = |watched: &&Watched| {
            watched.certainty == Certainty::Assumed && transforms.way(&self.root, &watched.frame).is_none()
        };
        self.frames.iter().find(is_assumed).map(|watched| watched.frame.as_str())
    }

    /// The frames that `tf` tells of again and again, seen from the root.
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

/// Why nobody knows where the root is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lost<'g> {
    /// `tf` does not connect it with this frame.
    In(&'g str),
    /// Above the root, or what obstacles stand in, `tf` goes in a circle, or has more frames than are looked at.
    Endless,
}

/// A frame that `tf` tells of again and again.
#[derive(Debug)]
pub struct TrackedFrame<'g> {
    pub frame: &'g str,
    /// From the root to it.
    pub way: Way<'g>,
    /// Of the oldest transform on the way that is told again and again.
    pub stamp: Time,
}

/// Whether a frame's pose in the root's frame has changed, as seen from the root.
pub fn is_elsewhere(before: &Pose, now: &Pose) -> bool {
    // far from the root, rounding alone makes a way of a pose back to itself
    let way = now * before.inverse();
    before != now && (way.translation.vector.norm() > STILL || way.rotation.angle() > STILL)
}
