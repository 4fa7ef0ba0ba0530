//! Where frames are that messages name.

use super::PlanningSceneState;
use super::anchors::{Certainty, Ground};
use super::transform_tree::{Ancestor, TransformTree};
use crate::math::Pose;
use crate::monitor::Time;
use crate::monitor::status::quoted;
use crate::robot::{LinkId, LinkPoses, RobotModel};

/// What has to be known to understand a message about the world.
#[derive(Clone, Debug)]
pub struct SceneContext<'c> {
    pub robot: &'c RobotModel,
    /// Where the links are now; `None` while no joint state is known.
    pub poses: Option<&'c LinkPoses>,
    pub transforms: &'c TransformTree,
    /// Of the clock in which transforms are stamped.
    pub now: Option<Time>,
    /// Age (s) beyond which a transform that changes says nothing any more.
    pub transform_ttl: f64,
    /// Where links are that never move.
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

    /// Pose of a link in the root frame, if it is known now.
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

    /// Pose of a frame in the root frame: links first, then objects and their subframes, `tf`, fixed frames, the parent frame of the
    /// virtual joint.
    pub fn frame_pose(&self, frame: &str, scene: &PlanningSceneState) -> Result<Pose, String> {
        let frame = frame.trim_start_matches('/');
        if frame.is_empty() {
            return Ok(Pose::identity());
        }
        if let Some(link) = self.robot.link_by_name(frame) {
            return self.pose_of_link(link);
        }
        if let Some(pose) = self.object_pose(frame, scene) {
            return pose;
        }
        let above = self.transforms.ancestors(frame);
        let told = self.by_tf(&above);
        // as in MoveIt: what tf says comes before what a scene said of the frame once
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

    /// What stands in a frame that stays where it is, stands in this: the parent of the virtual joint or, where `tf` does not connect that with the
    /// root and the frame is not below it, the topmost frame above the root; `None` if there is none.
    pub(super) fn ground(&self, frame: &str) -> Option<Ground> {
        let joints = self.robot.srdf().into_iter().flat_map(|srdf| &srdf.virtual_joints);
        let planning = joints.filter(|joint| joint.child_link == self.robot.root());
        let known = |name: &str| {
            let pose_rf = self.pose_by_tf(name)?;
            Some(Ground { frame: name.to_owned(), pose_rf, certainty: Certainty::Told })
        };
        let assumed = || {
            let above = self.transforms.ancestors(frame);
            let joint = planning.clone().find(|joint| above.iter().any(|a| a.name == joint.parent_frame))?;
            let certainty = if joint.kind == "fixed" { Certainty::Fixed } else { Certainty::Assumed };
            Some(Ground { frame: joint.parent_frame.clone(), pose_rf: Pose::identity(), certainty })
        };
        let topmost = || self.transforms.topmost_above(self.root_name()).and_then(known);
        planning.clone().find_map(|joint| known(&joint.parent_frame)).or_else(assumed).or_else(topmost)
    }

    /// Pose of a frame in the root frame, however old what `tf` says of it is.
    pub(super) fn pose_by_tf(&self, frame: &str) -> Option<Pose> {
        self.transforms.way(self.root_name(), frame).map(|way| way.pose())
    }

    /// Whether a frame always stays where it is against the root, as far as it is a part of the robot or of what it holds.
    pub(super) fn stands_still(&self, frame: &str, scene: &PlanningSceneState) -> bool {
        let frame = frame.trim_start_matches('/');
        match self.robot.link_by_name(frame) {
            Some(link) => self.never_moves(link),
            None => Self::attached_frame(frame, scene).is_none(),
        }
    }

    pub(super) fn root_name(&self) -> &str {
        &self.robot.link(self.robot.root()).name
    }

    /// An object, or a place on it as `object/subframe`.
    fn object_pose(&self, frame: &str, scene: &PlanningSceneState) -> Option<Result<Pose, String>> {
        if let Some((link, pose_lf)) = Self::attached_frame(frame, scene) {
            let Some(link) = self.robot.link_by_name(link) else {
                return Some(Err(format!("frame {}: the robot has no link '{link}'", quoted(frame))));
            };
            return Some(self.pose_of_link(link).map(|pose_rl| pose_rl * pose_lf));
        }
        if let Some(object) = scene.world.obstacle_by_name(frame) {
            return Some(Ok(object.pose_ro));
        }
        let (name, place) = frame.rsplit_once('/')?;
        let object = scene.world.obstacle_by_name(name)?;
        let (_, pose_of) = object.subframes.iter().find(|(subframe, _)| subframe == place)?;
        Some(Ok(object.pose_ro * pose_of))
    }

    /// The link that carries a frame along, and the frame's pose on it.
    fn attached_frame<'s>(frame: &str, scene: &'s PlanningSceneState) -> Option<(&'s str, Pose)> {
        if let Some(object) = scene.world.attached_by_name(frame) {
            return Some((&object.link, object.pose_lo));
        }
        let (name, place) = frame.rsplit_once('/')?;
        let object = scene.world.attached_by_name(name)?;
        let (_, pose_of) = object.subframes.iter().find(|(subframe, _)| subframe == place)?;
        Some((&object.link, object.pose_lo * pose_of))
    }

    /// A frame outside of the robot whose place is known without `tf`.
    fn standing_pose(&self, frame: &str, scene: &PlanningSceneState) -> Option<Pose> {
        if let Some(pose) = scene.fixed_frames.get(frame) {
            return Some(*pose);
        }
        let joints = self.robot.srdf().into_iter().flat_map(|srdf| &srdf.virtual_joints);
        let ties =
            |j: &&crate::robot::VirtualJoint| j.parent_frame == frame && j.child_link == self.robot.root();
        // a virtual joint that moves, and about which tf knows nothing, stands at zero as in scene files
        joints.into_iter().find(ties).map(|_| Pose::identity())
    }

    /// By the nearest link above whose place is known, or by an ancestor in common with the root.
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
