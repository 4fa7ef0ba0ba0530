//! Snapshot that scene updates are applied against: robot poses, transforms and clock.

use clearance_geometry::math::Pose;
use clearance_robot::{Configuration, LinkId, LinkPoses, RobotModel, VirtualJoint, quoted};

use super::anchor::{AnchorFrame, Certainty};
use super::frame_ancestor::Ancestor;
use super::{StatedPositions, Time, TransformTree};

/// Snapshot of robot poses, transforms and clock that a scene update is applied against.
#[derive(Clone, Debug)]
pub struct SceneContext<'c> {
    /// The robot that the scene belongs to.
    pub robot: &'c RobotModel,
    /// Present poses of the links; `None` until a joint state is received.
    pub poses: Option<&'c LinkPoses>,
    /// Present positions of the joints, if known: what a robot state does not name stays there.
    pub configuration: Option<&'c Configuration>,
    /// Transforms from `tf`.
    pub transforms: &'c TransformTree,
    /// Present time, of the clock that stamps transforms.
    pub now: Option<Time>,
    /// Age (s) beyond which a non-static transform is no longer used.
    pub transform_ttl: f64,
    /// Poses of the links that never move.
    rest: LinkPoses,
    /// True if a robot state that should place the moving links is wrong: nothing is placed by them.
    is_state_wrong: bool,
}

impl<'c> SceneContext<'c> {
    /// A snapshot; see the fields.
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
        Self {
            robot,
            poses,
            configuration: None,
            transforms,
            now,
            transform_ttl,
            rest,
            is_state_wrong: false,
        }
    }

    /// The snapshot with the present positions of the joints.
    #[must_use]
    pub fn at_configuration(self, configuration: Option<&'c Configuration>) -> Self {
        Self { configuration, ..self }
    }

    /// The snapshot with other poses of the links; with none, nothing is placed by moving links.
    pub(super) fn with_poses<'s>(&self, poses: Option<&'s LinkPoses>) -> SceneContext<'s>
    where
        'c: 's,
    {
        SceneContext { poses, is_state_wrong: poses.is_none(), ..self.clone() }
    }

    /// Poses of the links with some joints at other positions. `None` without such joints, and while the others are not known.
    pub(super) fn poses_with(&self, positions: &StatedPositions) -> Option<Result<LinkPoses, String>> {
        let StatedPositions { single, with_transforms, fault } = positions;
        if let Some(fault) = fault {
            return Some(Err(fault.clone()));
        }
        // transforms of virtual joints are about the place of the root
        if let Some(joint) = with_transforms.iter().find(|name| self.robot.joint_by_name(name).is_some()) {
            let joint = quoted(joint);
            return Some(Err(format!(
                "joint {joint} has a transform, which is not read here: give its positions in joint_state"
            )));
        }
        let present = self.configuration.filter(|_| !single.is_empty())?;
        let named = single.iter().map(|(name, position)| (name.as_str(), *position));
        let configuration = self.robot.configuration_over(present, named).map_err(|error| error.to_string());
        Some(configuration.map(|q| {
            let mut poses = LinkPoses::new(self.robot);
            self.robot.forward_kinematics(&q, &mut poses);
            poses
        }))
    }

    /// Pose of a link in the root frame, if it is known at present.
    #[must_use]
    pub fn link_pose(&self, link: LinkId) -> Option<Pose> {
        if self.never_moves(link) {
            return Some(*self.rest.pose(link));
        }
        self.poses.map(|poses| *poses.pose(link))
    }

    pub(super) fn never_moves(&self, link: LinkId) -> bool {
        self.robot.same_rigid_body(link, self.robot.root())
    }

    pub(super) fn pose_of_link(&self, link: LinkId) -> Result<Pose, String> {
        let name = &self.robot.link(link).name;
        let why = if self.is_state_wrong {
            "the robot_state of the message is wrong"
        } else {
            "no fresh joint state gives its pose"
        };
        self.link_pose(link).ok_or_else(|| format!("link '{name}' moves, and {why}"))
    }

    /// World-fixed frame that objects placed in `frame` are anchored to, if `frame` does not move with the robot. It is the parent of the
    /// virtual joint, or, where `tf` does not connect that parent with the root and `frame` is not below it, the topmost frame above the
    /// root; `None` if there is none.
    pub(super) fn anchor_frame(&self, frame: &str) -> Option<AnchorFrame> {
        let planning = self.virtual_joints();
        let known = |name: &str| {
            let pose_rf = self.pose_by_tf(name)?;
            Some(AnchorFrame { frame: name.to_owned(), pose_rf, certainty: Certainty::FromTf })
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
        self.transforms.path(self.root_name(), frame).map(|path| path.pose())
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

    /// Pose by the nearest ancestor that is a link with a known pose, or by a common ancestor with the root.
    pub(super) fn by_tf(&self, above: &[Ancestor]) -> Option<Result<Pose, String>> {
        let place = |name: &str| self.link_pose(self.robot.link_by_name(name)?);
        let nearest_link = || above.iter().find_map(|a| self.robot.link_by_name(a.name));
        if let Some(link) = nearest_link().filter(|link| self.is_state_wrong && !self.never_moves(*link)) {
            return Some(self.pose_of_link(link));
        }
        if let Some((ancestor, pose_rl)) = above.iter().find_map(|a| Some((a, place(a.name)?))) {
            return Some(self.check_age(ancestor).map(|()| pose_rl * ancestor.pose_af));
        }
        let of_root = self.transforms.ancestors(self.root_name());
        let (ancestor, root) =
            above.iter().find_map(|a| Some((a, of_root.iter().find(|r| r.name == a.name)?)))?;
        let fresh = self.check_age(ancestor).and_then(|()| self.check_age(root));
        Some(fresh.map(|()| root.pose_af.inverse() * ancestor.pose_af))
    }

    pub(super) fn check_age(&self, ancestor: &Ancestor) -> Result<(), String> {
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
        match ancestor.largest_lead {
            Some((frame, lead)) if lead > self.transform_ttl => Err(format!(
                "the stamp of the last transform of frame {} on tf was {lead:.3} s in the future when it was received, and transform_ttl \
                 is {} s: synchronise the clocks",
                quoted(frame),
                self.transform_ttl
            )),
            _ => Ok(()),
        }
    }
}
