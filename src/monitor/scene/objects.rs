//! Obstacles: added, replaced, extended, moved and removed.

use super::state::OCTOMAP;
use super::{
    Extent, Gap, ObjectChange, OctomapPlacement, Operation, PlanningSceneState, SceneContext, SceneRefusal,
    Subject,
};
use crate::math::Pose;
use crate::world::Obstacle;

impl PlanningSceneState {
    pub(super) fn change_object(
        &mut self,
        change: &ObjectChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRefusal> {
        match change.operation {
            Operation::Remove if change.id.is_empty() => {
                self.remove_all_objects();
                Ok(())
            }
            Operation::Remove => self.remove_object(&change.id),
            Operation::Move => self.move_object(change, context, warnings).map_err(SceneRefusal::of_pose),
            Operation::Add | Operation::Append => self.add_object(change, context),
        }
    }

    /// Whether an object may bear this name.
    pub(super) fn check_name(&self, id: &str, context: &SceneContext) -> Result<(), SceneRefusal> {
        if id.is_empty() {
            let unnamed = Gap::new(Subject::Object, "", Extent::Shapes);
            return Err(SceneRefusal::new("id is empty: every object needs a name").leaving(unnamed));
        }
        if id == OCTOMAP || self.is_sensed(id) {
            return Err(SceneRefusal::of(id, "id: the name belongs to what sensors see; take another one"));
        }
        if context.robot.link_by_name(id).is_some() {
            return Err(SceneRefusal::of(id, "id: the robot has a link of this name; take another one"));
        }
        Ok(())
    }

    fn add_object(&mut self, change: &ObjectChange, context: &SceneContext) -> Result<(), SceneRefusal> {
        let id = &change.id;
        self.check_name(id, context)?;
        if change.shapes.is_empty() {
            return Err(SceneRefusal::of(id, "no shapes: give primitives, meshes or planes"));
        }
        if let Some(held) = self.world.attached_by_name(id) {
            let link = &held.link;
            return Err(SceneRefusal::of(
                id,
                format!("id: it is attached to link '{link}'; detach it first"),
            ));
        }
        if change.operation == Operation::Append
            && let Some(known) = self.world.obstacle_by_name(id)
        {
            let obstacle = extended(known, change);
            (self.world.replace(obstacle)).map_err(|error| SceneRefusal::of(id, error.to_string()))?;
        } else {
            let change = change.as_new();
            let obstacle = Obstacle {
                name: id.clone(),
                pose_ro: self.pose_of(&change, context)?,
                shapes: change.shapes.as_slice().into(),
                subframes: change.subframes.clone(),
            };
            (self.world.replace(obstacle)).map_err(|error| SceneRefusal::of(id, error.to_string()))?;
            self.anchor(id, &change.frame, context);
        }
        self.note_kind(change);
        Ok(())
    }

    pub(super) fn note_kind(&mut self, change: &ObjectChange) {
        if change.kind.iter().any(|word| !word.is_empty()) {
            self.kinds.insert(change.id.clone(), change.kind.clone());
        }
    }

    /// Pose of a changed object in the root frame.
    pub(super) fn pose_of(
        &self,
        change: &ObjectChange,
        context: &SceneContext,
    ) -> Result<Pose, SceneRefusal> {
        let pose_rf = (context.frame_pose(&change.frame, self))
            .map_err(|message| SceneRefusal::of(&change.id, format!("header.frame_id: {message}")))?;
        Ok(pose_rf * change.pose_fo)
    }

    fn move_object(
        &mut self,
        change: &ObjectChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRefusal> {
        let id = &change.id;
        self.check_name(id, context)?;
        let pose_ro = self.pose_of(change, context)?;
        let known = self.world.obstacle_by_name(id).ok_or_else(|| {
            SceneRefusal::of(
                id,
                "operation: it can not be moved, because there is no such object in the world",
            )
        })?;
        let moved = known.with_shapes_at(&change.shape_poses).ok_or_else(|| {
            let (given, has) = (change.shape_poses.len(), known.shapes.len());
            let message = format!(
                "{given} poses of shapes are given, but the object has {has} shapes: give as many, or none"
            );
            SceneRefusal::of(id, message)
        })?;
        (self.world.replace(Obstacle { pose_ro, ..moved }))
            .map_err(|error| SceneRefusal::of(id, error.to_string()))?;
        self.anchor(id, &change.frame, context);
        if !change.shapes.is_empty() {
            warnings.push(format!("object '{id}' is moved; the shapes given with the move are ignored"));
        }
        Ok(())
    }

    fn remove_object(&mut self, id: &str) -> Result<(), SceneRefusal> {
        if self.is_sensed(id) || id == OCTOMAP {
            return Err(SceneRefusal::of(
                id,
                "operation: what sensors see is not removed by name; see clear_octomap and point_cloud_ttl",
            )
            .without_gap());
        }
        self.world.remove(id).map_err(|_| {
            SceneRefusal::of(
                id,
                "operation: it can not be removed, because there is no such object in the world",
            )
            .without_gap()
        })?;
        self.kinds.remove(id);
        self.anchors.remove(id);
        // as in MoveIt: who bears the name next is another thing
        if let Some(matrix) = &mut self.matrix {
            matrix.forget(id);
        }
        Ok(())
    }

    /// Takes away what messages have put there; what sensors see stays.
    pub(super) fn remove_all_objects(&mut self) {
        for name in self.given_names() {
            self.kinds.remove(&name);
            self.anchors.remove(&name);
            if self.world.remove(&name).is_ok()
                && let Some(matrix) = &mut self.matrix
            {
                matrix.forget(&name);
            }
        }
    }

    /// Names of the obstacles that come from messages and files.
    pub(super) fn given_names(&self) -> Vec<String> {
        let names = self.world.obstacles().map(|o| &o.name);
        names.filter(|name| *name != OCTOMAP && !self.is_sensed(name)).cloned().collect()
    }

    /// Puts an octomap in the place of the one before.
    pub(super) fn set_octomap(
        &mut self,
        octomap: Option<&OctomapPlacement>,
        context: &SceneContext,
    ) -> Result<(), SceneRefusal> {
        let placed = octomap.and_then(|o| Some((o, o.shape.clone()?)));
        let Some((octomap, shape)) = placed else {
            self.anchors.remove(OCTOMAP);
            let _ = self.world.remove(OCTOMAP);
            return Ok(());
        };
        let pose_rf = (context.frame_pose(&octomap.frame, self))
            .map_err(|message| SceneRefusal::of_octomap(format!("header.frame_id: {message}")))?;
        let obstacle = Obstacle::of_shape(OCTOMAP, pose_rf * octomap.pose_fo, shape);
        (self.world.replace(obstacle)).map_err(|error| SceneRefusal::of_octomap(error.to_string()))?;
        self.anchor(OCTOMAP, &octomap.frame, context);
        Ok(())
    }
}

/// An obstacle with more shapes, in its own frame as in `MoveIt`.
fn extended(known: &Obstacle, change: &ObjectChange) -> Obstacle {
    let mut subframes = known.subframes.clone();
    for (name, pose_os) in &change.subframes {
        subframes.retain(|(other, _)| other != name);
        subframes.push((name.clone(), *pose_os));
    }
    let shapes = known.shapes.iter().chain(&change.shapes).cloned().collect();
    Obstacle { name: known.name.clone(), pose_ro: known.pose_ro, shapes, subframes }
}
