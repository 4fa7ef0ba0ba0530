//! Frame look-up in a scene: poses of named frames in the root frame, and whether robot links can move a frame.

use clearance_geometry::math::Pose;
use clearance_robot::quoted;

use super::{Obstacle, Scene, SceneContext};

impl<'c> SceneContext<'c> {
    /// Pose of a frame in the root frame, searched in the order of MoveIt's `getFrameTransform`: the planning frame, links, attached
    /// objects and their subframes, objects and their subframes, `tf`, fixed frames. An empty name is the root frame.
    ///
    /// # Errors
    /// If the frame is unknown, or its pose is not known at present.
    pub fn frame_pose(&self, frame: &str, scene: &Scene) -> Result<Pose, String> {
        let frame = frame.trim_start_matches('/');
        if frame.is_empty() {
            return Ok(Pose::identity());
        }
        if self.virtual_joint_from(frame).is_none() {
            if let Some(link) = self.robot.link_by_name(frame) {
                return self.pose_of_link(link);
            }
            if let Some(pose) = self.object_pose(frame, scene) {
                return pose;
            }
        }
        let above = self.transforms.ancestors(frame);
        let by_tf = self.by_tf(&above);
        // as in MoveIt: a tf transform takes precedence over an earlier one from a scene
        if let (Some(pose), None) = (scene.fixed_frames.get(frame), &by_tf) {
            return Ok(*pose);
        }
        let found = by_tf.or_else(|| {
            if self.transforms.is_too_deep(frame) {
                return None;
            }
            let (ancestor, pose_ra) =
                above.iter().find_map(|a| Some((a, self.standing_pose(a.name, scene)?)))?;
            Some(self.check_age(ancestor).map(|()| pose_ra * ancestor.pose_af))
        });
        found.unwrap_or_else(|| {
            Err(format!(
                "unknown frame {}: neither a link, an object, a fixed frame nor a frame that tf connects with the root frame '{}'",
                quoted(frame),
                self.root_name()
            ))
        })
    }

    /// True if a frame never moves relative to the root because of a moving link or an attached object.
    #[must_use]
    pub fn stands_still(&self, frame: &str, scene: &Scene) -> bool {
        let above = self.transforms.ancestors(frame.trim_start_matches('/'));
        // the nearest ancestor that is a part of the robot decides
        let part = above.iter().find_map(|a| match self.robot.link_by_name(a.name) {
            Some(link) => Some(self.never_moves(link)),
            None => Self::attached_frame(a.name, scene).map(|_| false),
        });
        part.unwrap_or(true)
    }

    /// Pose of an object, or of a subframe named `object/subframe`.
    fn object_pose(&self, frame: &str, scene: &Scene) -> Option<Result<Pose, String>> {
        if let Some((link, pose_lf)) = Self::attached_frame(frame, scene) {
            let Some(link) = self.robot.link_by_name(link) else {
                return Some(Err(format!("frame {}: the robot has no link '{link}'", quoted(frame))));
            };
            return Some(self.pose_of_link(link).map(|pose_rl| pose_rl * pose_lf));
        }
        Self::obstacle_frame(frame, scene).map(|(_, pose_ro)| Ok(pose_ro))
    }

    /// The obstacle that a frame belongs to, as its own frame or a subframe, and the frame's pose in the root frame.
    fn obstacle_frame<'s>(frame: &str, scene: &'s Scene) -> Option<(&'s Obstacle, Pose)> {
        if let Some(object) = scene.world.obstacle_by_name(frame) {
            return Some((object, object.pose_ro));
        }
        // names may contain slashes: every prefix before a slash may be the name of an object
        let objects = frame.match_indices('/').filter_map(|(i, _)| scene.world.obstacle_by_name(&frame[..i]));
        let mut found =
            objects.filter_map(|o| Some((o.as_ref(), o.pose_ro * subframe(frame, &o.name, &o.subframes)?)));
        found.next()
    }

    /// The part of the scene that places a frame, in the search order of [`Self::frame_pose`]: an obstacle, or the fixed frame that is
    /// the frame or one of its ancestors. `None` for the robot, the planning frame and `tf`.
    pub(super) fn placed_by<'s>(&self, frame: &'s str, scene: &'s Scene) -> Option<PlacedBy<'s>>
    where
        'c: 's,
    {
        let is_of_robot = self.virtual_joint_from(frame).is_some()
            || self.robot.link_by_name(frame).is_some()
            || Self::attached_frame(frame, scene).is_some();
        if is_of_robot {
            return None;
        }
        if let Some((obstacle, _)) = Self::obstacle_frame(frame, scene) {
            return Some(PlacedBy::Obstacle(&obstacle.name));
        }
        let above = self.transforms.ancestors(frame);
        if self.by_tf(&above).is_some() {
            return None;
        }
        let fixed = above.iter().find_map(|a| scene.fixed_frames.get_key_value(a.name));
        fixed.map(|(name, _)| PlacedBy::FixedFrame(name))
    }

    /// The link that a frame is attached to, and the frame's pose in that link.
    pub(super) fn attached_frame<'s>(frame: &str, scene: &'s Scene) -> Option<(&'s str, Pose)> {
        if let Some(object) = scene.world.attached_by_name(frame) {
            return Some((&object.link, object.pose_lo));
        }
        scene.world.attached().iter().find_map(|object| {
            let pose_of = subframe(frame, &object.name, &object.subframes)?;
            Some((object.link.as_str(), object.pose_lo * pose_of))
        })
    }

    /// Pose of a frame outside of the robot that is known without `tf`.
    fn standing_pose(&self, frame: &str, scene: &Scene) -> Option<Pose> {
        if let Some(pose) = scene.fixed_frames.get(frame) {
            return Some(*pose);
        }
        // a moving virtual joint without a tf transform counts as zero
        self.virtual_joint_from(frame).map(|_| Pose::identity())
    }
}

/// A part of a scene that places frames.
pub(super) enum PlacedBy<'s> {
    Obstacle(&'s str),
    FixedFrame(&'s str),
}

/// Pose of a subframe in its object, if `frame` is the object's name, a slash and the subframe's name.
fn subframe(frame: &str, object: &str, subframes: &[(String, Pose)]) -> Option<Pose> {
    let wanted = frame.strip_prefix(object)?.strip_prefix('/')?;
    subframes.iter().find(|(name, _)| name == wanted).map(|(_, pose_of)| *pose_of)
}
