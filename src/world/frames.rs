//! Names of frames to poses.

use std::collections::HashMap;

use super::World;
use crate::math::Pose;
use crate::robot::{LinkPoses, RobotModel, VirtualJoint};

/// Everything that gives poses in a frame but the world itself, whose objects and subframes are frames too.
#[derive(Clone, Copy, Debug)]
pub struct Frames<'a> {
    pub robot: &'a RobotModel,
    /// Where the links are: for poses given in the frame of a link that moves.
    pub poses: &'a LinkPoses,
    /// Pose of the robot's root in the parent frame of the SRDF's virtual joint; `None` when it is not told.
    pub pose_vr: Option<&'a Pose>,
    /// Other frames by name, each with its pose in the root frame, such as those of tf.
    pub others: &'a HashMap<String, Pose>,
}

/// Where a frame is.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundFrame {
    /// Pose of the frame in the root frame.
    pub pose_rf: Pose,
    /// Why the frame may not stay there, as a clause.
    pub caution: Option<String>,
}

impl Frames<'_> {
    /// Looks a frame up as `MoveIt` does: a link, the frame of the virtual joint, an attached object, an object, a subframe
    /// of either (`object/subframe`), any other frame. No name at all is the root frame.
    ///
    /// # Errors
    /// When nothing bears the name.
    pub fn find(&self, name: &str, world: &World) -> Result<FoundFrame, String> {
        let name = name.strip_prefix('/').unwrap_or(name);
        let still = |pose_rf| Ok(FoundFrame { pose_rf, caution: None });
        if name.is_empty() {
            return still(Pose::identity());
        }
        if let Some(link) = self.robot.link_by_name(name) {
            let moves = !self.robot.same_rigid_body(link, self.robot.root());
            let caution = moves.then(|| {
                format!("link '{name}' moves: what is given in its frame stays where the robot's state puts it now")
            });
            return Ok(FoundFrame { pose_rf: *self.poses.pose(link), caution });
        }
        if let Some(joint) = self.virtual_joint_from(name) {
            return Ok(self.virtual_parent(joint));
        }
        if let Some((link, pose_lf)) = attached_frame(name, world) {
            let link =
                self.robot.link_by_name(link).ok_or_else(|| format!("the robot has no link '{link}'"))?;
            let caution =
                format!("'{name}' is held by the robot: what is given in its frame stays where it is now");
            return Ok(FoundFrame { pose_rf: self.poses.pose(link) * pose_lf, caution: Some(caution) });
        }
        match object_frame(name, world).or_else(|| self.others.get(name).copied()) {
            Some(pose_rf) => still(pose_rf),
            None => Err(format!(
                "unknown frame '{name}'; the root frame is '{}'",
                self.robot.link(self.robot.root()).name
            )),
        }
    }

    /// The frame that `MoveIt` plans in: that of the virtual joint, or else the root.
    #[must_use]
    pub fn planning_frame(&self) -> FoundFrame {
        let joints = self.robot.srdf().map_or(&[][..], |srdf| &srdf.virtual_joints[..]);
        match joints.iter().find(|j| j.child_link == self.robot.root()) {
            Some(joint) => self.virtual_parent(joint),
            None => FoundFrame { pose_rf: Pose::identity(), caution: None },
        }
    }

    fn virtual_parent(&self, joint: &VirtualJoint) -> FoundFrame {
        if let Some(pose_vr) = self.pose_vr {
            return FoundFrame { pose_rf: pose_vr.inverse(), caution: None };
        }
        let caution = (joint.kind != "fixed").then(|| {
            let VirtualJoint { kind, parent_frame, .. } = joint;
            format!("the {kind} virtual joint from frame '{parent_frame}' is taken at zero, so that it is the root frame")
        });
        FoundFrame { pose_rf: Pose::identity(), caution }
    }

    /// The SRDF's virtual joint that ties the root to `frame`.
    fn virtual_joint_from(&self, frame: &str) -> Option<&VirtualJoint> {
        let mut joints = self.robot.srdf()?.virtual_joints.iter();
        joints.find(|j| j.parent_frame == frame && j.child_link == self.robot.root())
    }
}

/// The link that carries an attached object, and the pose of the object or its subframe in the link's frame.
fn attached_frame<'w>(name: &str, world: &'w World) -> Option<(&'w str, Pose)> {
    if let Some(object) = world.attached_by_name(name) {
        return Some((&object.link, object.pose_lo));
    }
    world.attached().iter().find_map(|object| {
        let pose_of = subframe(name, &object.name, &object.subframes)?;
        Some((object.link.as_str(), object.pose_lo * pose_of))
    })
}

/// Pose of an object or its subframe in the root frame.
fn object_frame(name: &str, world: &World) -> Option<Pose> {
    if let Some(object) = world.obstacle_by_name(name) {
        return Some(object.pose_ro);
    }
    // names may hold slashes, so each part before one may be an object's
    let objects = name.match_indices('/').filter_map(|(slash, _)| world.obstacle_by_name(&name[..slash]));
    let mut found = objects.filter_map(|o| Some(o.pose_ro * subframe(name, &o.name, &o.subframes)?));
    found.next()
}

fn subframe(name: &str, object: &str, subframes: &[(String, Pose)]) -> Option<Pose> {
    let wanted = name.strip_prefix(object)?.strip_prefix('/')?;
    subframes.iter().find(|(name, _)| name == wanted).map(|(_, pose_of)| *pose_of)
}
