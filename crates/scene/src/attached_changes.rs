//! Operations on attached objects: attach, append, detach, remove.

use std::borrow::Cow;
use std::sync::Arc;

use clearance_geometry::math::Pose;
use clearance_robot::{LinkId, quoted};

use super::{
    AttachedChange, AttachedObject, GapSubject, ObjectChange, Operation, Scene, SceneContext, SceneGap,
    SceneRejection,
};

impl Scene {
    pub(super) fn change_attached(
        &mut self,
        change: &AttachedChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRejection> {
        let applied = self.attach_or_detach(change, context, warnings);
        // an update that detaches all objects, or all of a link, detaches none of them
        let name = if change.object.id.is_empty() { &change.link } else { &change.object.id };
        let gap = || SceneGap::new(GapSubject::Attached, name, change.extent());
        applied
            .map_err(|rejection| if rejection.gap.is_some() { rejection.leaving(gap()) } else { rejection })
    }

    fn attach_or_detach(
        &mut self,
        change: &AttachedChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRejection> {
        change.check().map_err(|excess| SceneRejection::of(&change.object.id, excess))?;
        let id = &change.object.id;
        match change.object.operation {
            Operation::Remove => self.detach(change, context),
            Operation::Move => Err(SceneRejection::of(
                id,
                "object.operation: what a link holds moves with it; attach it anew at another pose",
            )),
            Operation::Add | Operation::Append => {
                self.check_name(id, context)?;
                let unknown = change.touch_links.iter().filter(|l| context.robot.link_by_name(l).is_none());
                let warn =
                    |l: &String| format!("object '{id}': touch_links: the robot has no link {}", quoted(l));
                warnings.extend(unknown.map(warn));
                let object = self.object_to_attach(change, context, warnings)?;
                (self.world.attach(object)).map_err(|error| SceneRejection::of(id, error.to_string()))?;
                self.anchors.remove(id);
                self.twists.remove(id);
                self.note_kind(&change.object);
                Ok(())
            }
        }
    }

    fn object_to_attach(
        &self,
        change: &AttachedChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<AttachedObject, SceneRejection> {
        let AttachedChange { link, object, touch_links } = change;
        let id = &object.id;
        let link_id = context.robot.link_by_name(link).ok_or_else(|| unknown_link(id, link))?;
        let in_world = self.world.obstacle_by_name(id);
        if object.shapes.is_empty() {
            let obstacle = in_world.filter(|_| object.operation == Operation::Add).ok_or_else(|| {
                SceneRejection::of(
                    id,
                    "object: no shapes are given, and there is no such object in the world to take them from",
                )
            })?;
            let pose_rl = where_is(id, link_id, context)?;
            return Ok(AttachedObject::grasped(obstacle, link, &pose_rl, touch_links.clone()));
        }
        let held = self.world.attached_by_name(id).filter(|_| object.operation == Operation::Append);
        let object = if held.is_some() { Cow::Borrowed(object) } else { object.as_new() };
        // as in MoveIt: an extended object keeps its pose, unless the message gives another one
        let pose_lo = match held {
            Some(held) if object.keeps_pose() => held.pose_lo,
            _ => self.pose_in_link(&object, link_id, context)?,
        };
        let given = AttachedObject {
            name: id.clone(),
            link: link.clone(),
            pose_lo,
            shapes: object.shapes.as_slice().into(),
            subframes: object.subframes.clone(),
            touch_links: touch_links.clone(),
        };
        if let Some(held) = held {
            return extended(held, &given);
        }
        if in_world.is_some() && object.operation == Operation::Append {
            warnings.push(format!(
                "object '{id}' is attached with the shapes of the message; those it had in the world are gone"
            ));
        }
        Ok(given)
    }

    /// Pose of a changed object in the frame of the link it is attached to.
    fn pose_in_link(
        &self,
        object: &ObjectChange,
        link: LinkId,
        context: &SceneContext,
    ) -> Result<Pose, SceneRejection> {
        // a pose in the frame of the link itself does not depend on the link's pose
        if object.frame.trim_start_matches('/') == context.robot.link(link).name {
            return Ok(object.pose_fo);
        }
        let pose_rl = where_is(&object.id, link, context)?;
        Ok(pose_rl.inverse() * self.pose_of(object, context)?)
    }

    /// The attached objects that a change removes from the robot.
    fn held(
        &self,
        change: &AttachedChange,
        context: &SceneContext,
    ) -> Result<Vec<Arc<AttachedObject>>, SceneRejection> {
        let AttachedChange { link, object: ObjectChange { id, .. }, .. } = change;
        if !link.is_empty() && context.robot.link_by_name(link).is_none() {
            return Err(unknown_link(id, link));
        }
        if id.is_empty() {
            let of_link = |o: &&Arc<AttachedObject>| link.is_empty() || o.link == *link;
            return Ok(self.world.attached().iter().filter(of_link).cloned().collect());
        }
        let object = self.world.attached_by_name(id).ok_or_else(|| {
            SceneRejection::of(id, "object.operation: it can not be detached, because no link holds it")
                .without_gap()
        })?;
        if !link.is_empty() && object.link != *link {
            let holder = &object.link;
            return Err(SceneRejection::of(
                id,
                format!(
                    "link_name: it is attached to '{holder}', not to '{link}'; leave link_name empty or correct it"
                ),
            ));
        }
        Ok(vec![Arc::clone(object)])
    }

    /// Detaches objects: each becomes an obstacle at its present pose.
    fn detach(&mut self, change: &AttachedChange, context: &SceneContext) -> Result<(), SceneRejection> {
        let held = self.held(change, context)?;
        // all poses first: if one object cannot be detached, none is
        let mut placed = Vec::new();
        for object in &held {
            let holder = context.robot.link_by_name(&object.link);
            let holder = holder.ok_or_else(|| unknown_link(&object.name, &object.link))?;
            placed.push((object, where_is(&object.name, holder, context)?));
        }
        for (object, pose_rl) in placed {
            let done = self.world.detach(&object.name, &pose_rl);
            done.map_err(|error| SceneRejection::of(&object.name, error.to_string()))?;
            self.anchor(&object.name, &object.link, context);
        }
        Ok(())
    }

    /// Removes attached objects from the scene.
    pub fn let_go(&mut self, change: &AttachedChange, context: &SceneContext) -> Result<(), SceneRejection> {
        for object in self.held(change, context)? {
            let _ = self.world.drop_attached(&object.name);
        }
        Ok(())
    }
}

/// An attached object with additional shapes, in its own frame as in `MoveIt`, and with the pose of the change, if there is one.
fn extended(held: &AttachedObject, given: &AttachedObject) -> Result<AttachedObject, SceneRejection> {
    if held.link != given.link {
        let message = format!("link_name: it is attached to '{}', not to '{}'", held.link, given.link);
        return Err(SceneRejection::of(&held.name, message));
    }
    let mut touch_links = held.touch_links.clone();
    touch_links.extend(given.touch_links.iter().filter(|l| !held.touch_links.contains(l)).cloned());
    let mut subframes = held.subframes.clone();
    subframes.retain(|(name, _)| given.subframes.iter().all(|(other, _)| other != name));
    subframes.extend(given.subframes.iter().cloned());
    Ok(AttachedObject {
        shapes: held.shapes.iter().chain(given.shapes.iter()).cloned().collect(),
        pose_lo: given.pose_lo,
        subframes,
        touch_links,
        ..held.clone()
    })
}

fn where_is(id: &str, link: LinkId, context: &SceneContext) -> Result<Pose, SceneRejection> {
    (context.pose_of_link(link)).map_err(|message| SceneRejection::of(id, format!("link_name: {message}")))
}

fn unknown_link(id: &str, link: &str) -> SceneRejection {
    let message = format!("link_name: the robot has no link {}", quoted(link));
    if id.is_empty() { SceneRejection::new(message) } else { SceneRejection::of(id, message) }
}
