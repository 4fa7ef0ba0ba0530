//! What obstacles stand in while the robot's root moves: a table in a room stays in the room when the robot drives through it.
//!
//! All poses of the world are kept in the root's frame, so an obstacle remembers where it is in the frame that `MoveIt` plans in, the parent of the
//! SRDF's virtual joint, if `tf` connects that with the root, or else in the topmost frame of `tf` above the root. Whenever `tf` says that the
//! root is elsewhere in that frame, the obstacle is put where it belongs.

use super::{PlanningSceneState, SceneContext, TransformTree};
use crate::math::Pose;
use crate::monitor::Time;
use crate::robot::RobotModel;

/// Less than this (m, rad) is no motion of the root.
const STILL: f64 = 1e-4;

/// Where an obstacle is in a frame that is no part of the robot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Anchor {
    frame: String,
    /// Pose of the obstacle in that frame.
    pose_fo: Pose,
}

impl PlanningSceneState {
    /// Lets an obstacle, which a message placed in a frame just now, stay where it is in what it stands in.
    pub(super) fn anchor(&mut self, name: &str, frame: &str, context: &SceneContext) {
        self.anchors.remove(name);
        let Some(obstacle) = self.world.obstacle_by_name(name) else { return };
        let Some((frame, pose_rf)) = context.ground(frame) else { return };
        let pose_fo = pose_rf.inverse() * obstacle.pose_ro;
        self.anchors.insert(name.to_owned(), Anchor { frame, pose_fo });
    }

    /// Puts obstacles where they belong now that the root may be elsewhere; whether any had to be. Those that stand in nothing yet stand from
    /// now on in what `tf` has come to know.
    pub fn follow_frames(&mut self, context: &SceneContext) -> bool {
        for name in self.ungrounded().cloned().collect::<Vec<String>>() {
            self.anchor(&name, "", context);
        }
        let place = |(name, Anchor { frame, pose_fo }): (&String, &Anchor)| {
            let now = context.pose_by_tf(frame)?;
            let before = self.world.obstacle_by_name(name)?.pose_ro * pose_fo.inverse();
            is_elsewhere(&before, &now).then(|| (name.clone(), now * pose_fo))
        };
        let moved: Vec<(String, Pose)> = self.anchors.iter().filter_map(place).collect();
        for (name, pose_ro) in &moved {
            // it was there right now
            let _ = self.world.move_to(name, *pose_ro);
        }
        !moved.is_empty()
    }

    /// Obstacles that messages and files gave, and that stand in nothing.
    fn ungrounded(&self) -> impl Iterator<Item = &String> {
        let names = self.world.obstacles().map(|obstacle| &obstacle.name);
        names.filter(|name| !self.is_sensed(name) && !self.anchors.contains_key(*name))
    }

    /// What has to be looked at to know whether obstacles are where they belong.
    #[must_use]
    pub fn grounds(&self, robot: &RobotModel) -> Grounds {
        let mut frames: Vec<(String, Pose)> = Vec::new();
        for (name, Anchor { frame, pose_fo }) in &self.anchors {
            if frames.iter().all(|(known, _)| known != frame)
                && let Some(obstacle) = self.world.obstacle_by_name(name)
            {
                frames.push((frame.clone(), obstacle.pose_ro * pose_fo.inverse()));
            }
        }
        let root = robot.link(robot.root()).name.clone();
        Grounds { root, frames, any_ungrounded: self.ungrounded().next().is_some() }
    }
}

/// The frames that obstacles stand in, and where they were in the root's frame when these were put where they are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grounds {
    root: String,
    frames: Vec<(String, Pose)>,
    any_ungrounded: bool,
}

impl Grounds {
    /// Whether obstacles have to be put elsewhere now.
    #[must_use]
    pub fn are_elsewhere(&self, transforms: &TransformTree) -> bool {
        let is_one = |(frame, before): &(String, Pose)| {
            let now = transforms.pose_between(&self.root, frame);
            now.is_some_and(|(now, _)| is_elsewhere(before, &now))
        };
        (self.any_ungrounded && transforms.topmost_above(&self.root).is_some())
            || self.frames.iter().any(is_one)
    }
}

impl Grounds {
    /// Whether anything stands in a frame.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Of the frames whose place changes with time the one that was told of longest ago: its pose in the root's frame, and when.
    pub(in crate::monitor) fn least_known(&self, transforms: &TransformTree) -> Option<(String, Pose, Time)> {
        let known = self.frames.iter().filter_map(|(frame, _)| {
            let (pose, stamp) = transforms.pose_between(&self.root, frame)?;
            Some((frame.clone(), pose, stamp?))
        });
        known.min_by_key(|(.., stamp)| *stamp)
    }
}

fn is_elsewhere(before: &Pose, now: &Pose) -> bool {
    let way = before.inverse() * now;
    way.translation.vector.norm() > STILL || way.rotation.angle() > STILL
}
