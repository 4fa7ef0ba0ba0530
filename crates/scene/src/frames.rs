//! Frame look-up: poses of named frames in the root frame.

use clearance_geometry::math::Pose;
use clearance_robot::{LinkId, LinkPoses, RobotModel, VirtualJoint, quoted};

use super::anchors::{AnchorFrame, Certainty};
use super::transform_tree::{Ancestor, TransformTree};
use super::{Obstacle, Scene, Time};

/// Snapshot of robot poses, transforms and clock that a scene update is applied against.
#[derive(Clone, Debug)]
pub struct SceneContext<'c> {
    pub robot: &'c RobotModel,
    /// Present poses of the links; `None` until a joint state is received.
    pub poses: Option<&'c LinkPoses>,
    pub transforms: &'c TransformTree,
    /// Present time, of the clock that stamps transforms.
    pub now: Option<Time>,
    /// Age (s) beyond which a non-static transform is no longer used.
    pub transform_ttl: f64,
    /// Poses of the links that never move.
    rest: LinkPoses,
}

impl<'c> SceneContext<'c> {
    #[must_use]
    pub fn new(
        robot: &'c RobotModel,
        poses: Option<&'c LinkPoses>,
        transforms: &'c TransformTree,
        now: Option<Time>,
        transform_ttl: f64,
    ) -> Self {
        let mut rest = LinkPoses::new(robot);
        robot.forward_kinematics(&robot.default_configuration(), &mut rest);
        Self { robot, poses, transforms, now, transform_ttl, rest }
    }

    /// Pose of a link in the root frame, if it is known at present.
    #[must_use]
    pub fn link_pose(&self, link: LinkId) -> Option<Pose> {
        if self.never_moves(link) {
            return Some(*self.rest.pose(link));
        }
        self.poses.map(|poses| *poses.pose(link))
    }

    fn never_moves(&self, link: LinkId) -> bool {
        self.robot.same_rigid_body(link, self.robot.root())
    }

    pub(super) fn pose_of_link(&self, link: LinkId) -> Result<Pose, String> {
        let name = &self.robot.link(link).name;
        self.link_pose(link)
            .ok_or_else(|| format!("link '{name}' moves, and no fresh joint state tells where it is"))
    }

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
        let told = self.by_tf(&above);
        // as in MoveIt: a tf transform takes precedence over an earlier one from a scene
        if let (Some(pose), None) = (scene.fixed_frames.get(frame), &told) {
            return Ok(*pose);
        }
        let found = told.or_else(|| {
            if self.transforms.is_too_deep(frame) {
                return None;
            }
            let (ancestor, pose_ra) =
                above.iter().find_map(|a| Some((a, self.standing_pose(a.name, scene)?)))?;
            Some(self.fresh(ancestor).map(|()| pose_ra * ancestor.pose_af))
        });
        found.unwrap_or_else(|| {
            Err(format!(
                "unknown frame {}: neither a link, an object, a fixed frame nor a frame that tf connects with the root frame '{}'",
                quoted(frame),
                self.root_name()
            ))
        })
    }

    /// World-fixed frame that objects placed in `frame` are anchored to, if `frame` does not move with the robot. It is the parent of the
    /// virtual joint, or, where `tf` does not connect that parent with the root and `frame` is not below it, the topmost frame above the
    /// root; `None` if there is none.
    pub(super) fn ground(&self, frame: &str) -> Option<AnchorFrame> {
        let planning = self.virtual_joints();
        let known = |name: &str| {
            let pose_rf = self.pose_by_tf(name)?;
            Some(AnchorFrame { frame: name.to_owned(), pose_rf, certainty: Certainty::Told })
        };
        let assumed = || {
            let above = self.transforms.ancestors(frame);
            let joint = planning.clone().find(|joint| above.iter().any(|a| a.name == joint.parent_frame))?;
            let certainty = if joint.kind == "fixed" { Certainty::Fixed } else { Certainty::Assumed };
            Some(AnchorFrame { frame: joint.parent_frame.clone(), pose_rf: Pose::identity(), certainty })
        };
        let topmost = || self.transforms.topmost_above(self.root_name()).and_then(known);
        planning.clone().find_map(|joint| known(&joint.parent_frame)).or_else(assumed).or_else(topmost)
    }

    /// Pose of a frame in the root frame from `tf`, whatever the age of its transforms.
    pub(super) fn pose_by_tf(&self, frame: &str) -> Option<Pose> {
        self.transforms.way(self.root_name(), frame).map(|way| way.pose())
    }

    /// True if a frame never moves relative to the root because of a moving link or an attached object.
    pub(super) fn stands_still(&self, frame: &str, scene: &Scene) -> bool {
        let above = self.transforms.ancestors(frame.trim_start_matches('/'));
        // the nearest ancestor that is a part of the robot decides
        let part = above.iter().find_map(|a| match self.robot.link_by_name(a.name) {
            Some(link) => Some(self.never_moves(link)),
            None => Self::attached_frame(a.name, scene).map(|_| false),
        });
        part.unwrap_or(true)
    }

    /// MoveIt's planning frame: the parent frame of the root's virtual joint, or else the root link.
    #[must_use]
    pub fn planning_frame(&self) -> &str {
        self.virtual_joints().next().map_or(self.root_name(), |joint| &joint.parent_frame)
    }

    /// True if a frame is MoveIt's planning frame.
    pub(super) fn is_planning_frame(&self, frame: &str) -> bool {
        frame.trim_start_matches('/') == self.planning_frame()
    }

    /// The virtual joint of the root link that has this parent frame.
    pub(super) fn virtual_joint_from(&self, frame: &str) -> Option<&'c VirtualJoint> {
        self.virtual_joints().find(|joint| joint.parent_frame == frame)
    }

    /// The virtual joints of the root link.
    fn virtual_joints(&self) -> impl Iterator<Item = &'c VirtualJoint> + Clone {
        let (root, srdf) = (self.robot.root(), self.robot.srdf());
        srdf.into_iter().flat_map(|srdf| &srdf.virtual_joints).filter(move |joint| joint.child_link == root)
    }

    pub(super) fn root_name(&self) -> &str {
        &self.robot.link(self.robot.root()).name
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

    /// Pose by the nearest ancestor that is a link with a known pose, or by a common ancestor with the root.
    fn by_tf(&self, above: &[Ancestor]) -> Option<Result<Pose, String>> {
        let place = |name: &str| self.link_pose(self.robot.link_by_name(name)?);
        if let Some((ancestor, pose_rl)) = above.iter().find_map(|a| Some((a, place(a.name)?))) {
            return Some(self.fresh(ancestor).map(|()| pose_rl * ancestor.pose_af));
        }
        let of_root = self.transforms.ancestors(self.root_name());
        let (ancestor, root) =
            above.iter().find_map(|a| Some((a, of_root.iter().find(|r| r.name == a.name)?)))?;
        let fresh = self.fresh(ancestor).and_then(|()| self.fresh(root));
        Some(fresh.map(|()| root.pose_af.inverse() * ancestor.pose_af))
    }

    fn fresh(&self, ancestor: &Ancestor) -> Result<(), String> {
        let Some((frame, stamp)) = ancestor.oldest else { return Ok(()) };
        let now = self.now.ok_or_else(|| "there is no time yet: nothing arrived on /clock".to_owned())?;
        let age = now.seconds_since(stamp);
        if age > self.transform_ttl {
            return Err(format!(
                "the last transform of frame {} on tf is {age:.3} s old, and transform_ttl is {} s",
                quoted(frame),
                self.transform_ttl
            ));
        }
        Ok(())
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
