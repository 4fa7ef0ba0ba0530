//! Objects as scenes and messages describe them, and what they do to a world.
//!
//! All as `MoveIt` does it with `moveit_msgs/CollisionObject` and `moveit_msgs/AttachedCollisionObject`. What it drops with
//! a line in its log is an error here.

use super::frames::Frames;
use super::{AttachedObject, Obstacle, ObstacleShape, World, WorldError};
use crate::math::Pose;
use crate::robot::check_name_length;

/// The name of the octomap among the objects; no other object may bear it.
pub const OCTOMAP_NAME: &str = "<octomap>";

/// What is to happen to an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Operation {
    /// It comes to be; one of its name is replaced.
    #[default]
    Add,
    /// It goes; without a name, all go.
    Remove,
    /// It gets more shapes; without one of its name, it comes to be.
    Append,
    /// It gets another pose.
    Move,
}

/// An object of a scene or a message.
#[derive(Clone, Debug)]
pub struct SceneObject {
    pub id: String,
    /// The frame of its pose; empty for the root frame.
    pub frame: String,
    /// Pose of the object in that frame.
    pub pose_fo: Pose,
    pub shapes: Vec<ObstacleShape>,
    /// For [`Operation::Move`]: where in the object its shapes are from now on; they stay where they are if none is given.
    pub shape_poses: Vec<Pose>,
    pub subframes: Vec<(String, Pose)>,
    pub operation: Operation,
}

/// An object that a link carries, or is to carry.
#[derive(Clone, Debug)]
pub struct SceneAttachment {
    pub link: String,
    pub object: SceneObject,
    /// Links that may touch it beside the one that carries it.
    pub touch_links: Vec<String>,
}

/// Why an object does nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ObjectError {
    #[error("id is missing or empty")]
    NoId,
    #[error("id: '{OCTOMAP_NAME}' is the octomap's name; give the object another")]
    ReservedId,
    #[error("id: the robot has a link '{0}'; give the object another name")]
    NameOfLink(String),
    #[error("{0}: {1}")]
    LongName(&'static str, String),
    #[error("header.frame_id: {0}")]
    Frame(String),
    #[error("no shapes: give primitives, meshes or planes")]
    NoShapes,
    #[error("operation: there is no object '{0}' to move")]
    Unknown(String),
    #[error("the robot holds an object '{0}': detach it first")]
    Held(String),
    #[error("{given} poses of shapes are given, but the object has {has} shapes: give as many, or none")]
    ShapePoses { given: usize, has: usize },
    #[error("link_name: the robot has no link '{0}'")]
    UnknownLink(String),
    #[error("operation: no object '{0}' is attached")]
    NotAttached(String),
    #[error("link_name: object '{object}' is attached to '{link}', not to '{named}'")]
    OtherLink { object: String, link: String, named: String },
    #[error("operation: an attached object cannot be moved; attach it again")]
    MoveAttached,
    #[error(transparent)]
    World(#[from] WorldError),
}

impl Operation {
    /// By its constant in `moveit_msgs/CollisionObject`.
    #[must_use]
    pub fn from_number(number: i64) -> Option<Self> {
        match number {
            0 => Some(Self::Add),
            1 => Some(Self::Remove),
            2 => Some(Self::Append),
            3 => Some(Self::Move),
            _ => None,
        }
    }
}

impl SceneObject {
    /// With one shape and no pose of its own, the shape's pose becomes the object's.
    fn with_own_pose(mut self) -> Self {
        if let [only] = &mut self.shapes[..]
            && self.pose_fo == Pose::identity()
        {
            std::mem::swap(&mut only.pose_os, &mut self.pose_fo);
        }
        self
    }
}

impl SceneObject {
    /// Names are checked before anything quotes them.
    fn check_name_lengths(&self) -> Result<(), ObjectError> {
        let fields = [("id", &self.id), ("header.frame_id", &self.frame)];
        let subframes = self.subframes.iter().map(|(name, _)| ("subframe_names", name));
        fields.into_iter().chain(subframes).try_for_each(checked)
    }
}

impl SceneAttachment {
    fn check_name_lengths(&self) -> Result<(), ObjectError> {
        self.object.check_name_lengths()?;
        let touched = self.touch_links.iter().map(|name| ("touch_links", name));
        touched.chain([("link_name", &self.link)]).try_for_each(checked)
    }
}

fn checked((field, name): (&'static str, &String)) -> Result<(), ObjectError> {
    check_name_length(name).map_err(|excess| ObjectError::LongName(field, excess))
}

impl World {
    /// Does what an object asks for; answers with what was odd, each a clause.
    pub fn apply(&mut self, object: SceneObject, frames: &Frames) -> Result<Vec<String>, ObjectError> {
        object.check_name_lengths()?;
        if object.id == OCTOMAP_NAME {
            return Err(ObjectError::ReservedId);
        }
        if object.id.is_empty() && object.operation != Operation::Remove {
            return Err(ObjectError::NoId);
        }
        match object.operation {
            Operation::Add => self.apply_add(object, frames),
            Operation::Append => match self.obstacle_by_name(&object.id) {
                Some(_) => self.apply_append(object),
                None => self.apply_add(object, frames),
            },
            Operation::Remove => self.apply_remove(&object.id),
            Operation::Move => self.apply_move(&object, frames),
        }
    }

    fn apply_add(&mut self, object: SceneObject, frames: &Frames) -> Result<Vec<String>, ObjectError> {
        if frames.robot.link_by_name(&object.id).is_some() {
            return Err(ObjectError::NameOfLink(object.id));
        }
        if object.shapes.is_empty() {
            return Err(ObjectError::NoShapes);
        }
        if self.attached_by_name(&object.id).is_some() {
            return Err(ObjectError::Held(object.id));
        }
        let object = object.with_own_pose();
        let found = frames.find(&object.frame, self).map_err(ObjectError::Frame)?;
        self.replace(Obstacle {
            name: object.id,
            pose_ro: found.pose_rf * object.pose_fo,
            shapes: object.shapes.into(),
            subframes: object.subframes,
        })?;
        Ok(found.caution.into_iter().collect())
    }

    /// The shapes are in the frame of the object that is there, whose pose stays.
    fn apply_append(&mut self, object: SceneObject) -> Result<Vec<String>, ObjectError> {
        if object.shapes.is_empty() {
            return Err(ObjectError::NoShapes);
        }
        let mut remarks = Vec::new();
        if object.pose_fo != Pose::identity() {
            remarks.push("its pose is not used: appended shapes are in the frame of the object".to_owned());
        }
        self.append(&object.id, object.shapes)?;
        if let Some(known) = self.obstacle_by_name(&object.id)
            && !object.subframes.is_empty()
        {
            let changed = Obstacle { subframes: object.subframes, ..known.as_ref().clone() };
            self.replace(changed)?;
        }
        Ok(remarks)
    }

    fn apply_remove(&mut self, id: &str) -> Result<Vec<String>, ObjectError> {
        if !id.is_empty() {
            // one that was just attached is no object of the world any more, and is often removed all the same
            let gone = self.remove(id).is_err();
            return Ok(gone.then(|| "there is no such object to remove".to_owned()).into_iter().collect());
        }
        let names: Vec<String> = self.obstacles().map(|o| o.name.clone()).collect();
        for name in names.iter().filter(|name| *name != OCTOMAP_NAME) {
            self.remove(name)?;
        }
        Ok(vec![])
    }

    fn apply_move(&mut self, object: &SceneObject, frames: &Frames) -> Result<Vec<String>, ObjectError> {
        if self.id(&object.id).is_none() {
            return Err(ObjectError::Unknown(object.id.clone()));
        }
        let found = frames.find(&object.frame, self).map_err(ObjectError::Frame)?;
        let mut remarks: Vec<String> = found.caution.into_iter().collect();
        if !object.shapes.is_empty() {
            remarks.push("its shapes are not used: it is only moved".to_owned());
        }
        let known =
            self.obstacle_by_name(&object.id).ok_or_else(|| ObjectError::Unknown(object.id.clone()))?;
        let (given, has) = (object.shape_poses.len(), known.shapes.len());
        let moved =
            known.with_shapes_at(&object.shape_poses).ok_or(ObjectError::ShapePoses { given, has })?;
        self.replace(Obstacle { pose_ro: found.pose_rf * object.pose_fo, ..moved })?;
        Ok(remarks)
    }

    /// Attaches or detaches an object; answers with what was odd, each a clause.
    pub fn apply_attachment(
        &mut self,
        attachment: SceneAttachment,
        frames: &Frames,
    ) -> Result<Vec<String>, ObjectError> {
        attachment.check_name_lengths()?;
        if attachment.object.id == OCTOMAP_NAME {
            return Err(ObjectError::ReservedId);
        }
        match attachment.object.operation {
            Operation::Add | Operation::Append if attachment.object.id.is_empty() => Err(ObjectError::NoId),
            Operation::Add => self.apply_attach(attachment, frames),
            Operation::Append => match self.attached_by_name(&attachment.object.id) {
                Some(held) => {
                    let held = held.as_ref().clone();
                    self.apply_attached_append(attachment, held, frames)
                }
                None => self.apply_attach(attachment, frames),
            },
            Operation::Remove => self.apply_detach(&attachment, frames),
            Operation::Move => Err(ObjectError::MoveAttached),
        }
    }

    fn apply_attach(
        &mut self,
        attachment: SceneAttachment,
        frames: &Frames,
    ) -> Result<Vec<String>, ObjectError> {
        let SceneAttachment { link, object, touch_links } = attachment;
        let Some(carrier) = frames.robot.link_by_name(&link) else {
            return Err(ObjectError::UnknownLink(link));
        };
        if frames.robot.link_by_name(&object.id).is_some() {
            return Err(ObjectError::NameOfLink(object.id));
        }
        let mut remarks = strangers(&touch_links, frames);
        let pose_rl = frames.poses.pose(carrier);
        if object.shapes.is_empty() {
            let Some(there) = self.obstacle_by_name(&object.id) else { return Err(ObjectError::NoShapes) };
            let grasped = AttachedObject::grasped(there, &link, pose_rl, touch_links);
            remarks.push(placed_by_state(&link));
            self.attach(grasped)?;
            return Ok(remarks);
        }
        let object = object.with_own_pose();
        let (pose_lf, remark) = self.in_link(&object.frame, &link, frames)?;
        remarks.extend(remark);
        self.attach(AttachedObject {
            name: object.id,
            pose_lo: pose_lf * object.pose_fo,
            link,
            shapes: object.shapes.into(),
            subframes: object.subframes,
            touch_links,
        })?;
        Ok(remarks)
    }

    fn apply_attached_append(
        &mut self,
        attachment: SceneAttachment,
        held: AttachedObject,
        frames: &Frames,
    ) -> Result<Vec<String>, ObjectError> {
        let SceneAttachment { link, object, touch_links } = attachment;
        if link != held.link {
            return Err(ObjectError::OtherLink { object: object.id, link: held.link, named: link });
        }
        let mut remarks = strangers(&touch_links, frames);
        let mut pose_lo = held.pose_lo;
        if object.pose_fo != Pose::identity() {
            let (pose_lf, remark) = self.in_link(&object.frame, &link, frames)?;
            remarks.extend(remark);
            pose_lo = pose_lf * object.pose_fo;
        }
        let mut touched = held.touch_links;
        touched.extend(touch_links);
        let mut subframes = object.subframes;
        subframes.extend(held.subframes);
        let shapes = held.shapes.iter().cloned().chain(object.shapes).collect();
        self.attach(AttachedObject { pose_lo, shapes, subframes, touch_links: touched, ..held })?;
        Ok(remarks)
    }

    /// By name, or all of a link, or all.
    fn apply_detach(
        &mut self,
        attachment: &SceneAttachment,
        frames: &Frames,
    ) -> Result<Vec<String>, ObjectError> {
        let (id, link) = (&attachment.object.id, &attachment.link);
        if !link.is_empty() && frames.robot.link_by_name(link).is_none() {
            return Err(ObjectError::UnknownLink(link.clone()));
        }
        if !id.is_empty() {
            let held = self.attached_by_name(id).ok_or_else(|| ObjectError::NotAttached(id.clone()))?;
            if !link.is_empty() && held.link != *link {
                let (object, named) = (id.clone(), link.clone());
                return Err(ObjectError::OtherLink { object, link: held.link.clone(), named });
            }
        }
        let meant =
            |o: &AttachedObject| (id.is_empty() || o.name == *id) && (link.is_empty() || o.link == *link);
        let held: Vec<_> = self.attached().iter().filter(|o| meant(o)).cloned().collect();
        for object in held {
            let carrier = frames.robot.link_by_name(&object.link);
            let carrier = carrier.ok_or_else(|| ObjectError::UnknownLink(object.link.clone()))?;
            self.detach(&object.name, frames.poses.pose(carrier))?;
        }
        Ok(vec![])
    }

    /// Pose of a frame in that of a link, and why it depends on the robot's state, if it does.
    fn in_link(
        &self,
        frame: &str,
        link: &str,
        frames: &Frames,
    ) -> Result<(Pose, Option<String>), ObjectError> {
        let found = frames.find(frame, self).map_err(ObjectError::Frame)?;
        let unknown = || ObjectError::UnknownLink(link.to_owned());
        let carrier = frames.robot.link_by_name(link).ok_or_else(unknown)?;
        let of_frame = frames.robot.link_by_name(frame.strip_prefix('/').unwrap_or(frame));
        if of_frame == Some(carrier) {
            return Ok((Pose::identity(), None));
        }
        let rigid = of_frame.is_some_and(|of_frame| frames.robot.same_rigid_body(of_frame, carrier));
        let remark = (!rigid).then(|| placed_by_state(link));
        Ok((frames.poses.pose(carrier).inverse() * found.pose_rf, remark))
    }
}

fn placed_by_state(link: &str) -> String {
    format!("it is held where the robot's state puts it against link '{link}' now")
}

/// Names among the touch links that no link bears.
fn strangers(touch_links: &[String], frames: &Frames) -> Vec<String> {
    let unknown = touch_links.iter().filter(|name| frames.robot.link_by_name(name).is_none());
    unknown.map(|name| format!("touch_links: the robot has no link '{name}'")).collect()
}

#[cfg(test)]
mod tests;
