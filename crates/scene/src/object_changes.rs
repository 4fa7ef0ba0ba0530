//! Applies changes of obstacles to a scene: add, replace, append, move and remove; sets the octomap.

use std::collections::HashSet;

use clearance_geometry::math::Pose;
use clearance_robot::quoted;

use super::{
    GapExtent, GapSubject, OCTOMAP, ObjectChange, Obstacle, OctomapPlacement, Operation, Scene, SceneContext,
    SceneGap, SceneRejection,
};

impl Scene {
    pub(super) fn change_object(
        &mut self,
        change: &ObjectChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRejection> {
        change.check().map_err(|excess| SceneRejection::of(&change.id, excess))?;
        match change.operation {
            Operation::Remove if change.id.is_empty() => {
                self.remove_all_objects();
                Ok(())
            }
            Operation::Remove => self.remove_object(&change.id),
            Operation::Move => self.move_object(change, context, warnings).map_err(SceneRejection::of_pose),
            Operation::Add | Operation::Append => self.add_object(change, context, warnings),
        }
    }

    /// Checks whether the name is allowed for an object.
    pub(super) fn check_name(&self, id: &str, context: &SceneContext) -> Result<(), SceneRejection> {
        if id.is_empty() {
            let unnamed = SceneGap::new(GapSubject::Object, "", GapExtent::Shapes);
            return Err(SceneRejection::new("id is empty: every object needs a name").leaving(unnamed));
        }
        if id == OCTOMAP || self.is_sensed(id) {
            return Err(SceneRejection::of(id, "id: the name belongs to what sensors see; take another one"));
        }
        if context.robot.link_by_name(id).is_some() {
            let message = format!("id: the robot has a link {}; take another name", quoted(id));
            return Err(SceneRejection::of(id, message));
        }
        Ok(())
    }

    fn add_object(
        &mut self,
        change: &ObjectChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRejection> {
        let id = &change.id;
        self.check_addition(id, change.shapes.len(), context)?;
        if change.operation == Operation::Append
            && let Some(known) = self.world.obstacle_by_name(id)
        {
            // as in MoveIt, the object stays where it is
            let given = self.pose_of(change, context)?;
            if is_given(change) && !are_alike(&given, &known.pose_ro) {
                warnings.push(format!(
                    "object '{id}' stays where it is: the appended shapes are placed in its frame, and the pose and frame given with them \
                     are ignored"
                ));
            }
            let obstacle = extended(known, change);
            (self.world.replace(obstacle)).map_err(|error| SceneRejection::of(id, error.to_string()))?;
        } else {
            let change = change.as_new();
            let obstacle = Obstacle {
                name: id.clone(),
                pose_ro: self.pose_of(&change, context)?,
                shapes: change.shapes.as_slice().into(),
                subframes: change.subframes.clone(),
            };
            self.put_obstacle(obstacle, &change.frame, context)?;
        }
        self.note_kind(change);
        Ok(())
    }

    /// Adds an obstacle, whose pose is given in a frame.
    pub(super) fn add_obstacle(
        &mut self,
        obstacle: Obstacle,
        frame: &str,
        context: &SceneContext,
    ) -> Result<(), SceneRejection> {
        let id = &obstacle.name;
        self.check_addition(id, obstacle.shapes.len(), context)?;
        let pose_rf = (context.frame_pose(frame, self))
            .map_err(|message| SceneRejection::of(id, format!("header.frame_id: {message}")))?;
        let pose_ro = pose_rf * obstacle.pose_ro;
        self.put_obstacle(Obstacle { pose_ro, ..obstacle }, frame, context)
    }

    /// Checks whether an object may be added.
    fn check_addition(&self, id: &str, shapes: usize, context: &SceneContext) -> Result<(), SceneRejection> {
        self.check_name(id, context)?;
        if shapes == 0 {
            return Err(SceneRejection::of(id, "no shapes: give primitives, meshes or planes"));
        }
        match self.world.attached_by_name(id) {
            None => Ok(()),
            Some(held) => {
                let link = &held.link;
                let message = format!("id: it is attached to link '{link}'; detach it first");
                Err(SceneRejection::of(id, message))
            }
        }
    }

    /// Adds an obstacle with a pose in the root frame, and anchors it to the world-fixed frame that `frame` belongs to.
    fn put_obstacle(
        &mut self,
        obstacle: Obstacle,
        frame: &str,
        context: &SceneContext,
    ) -> Result<(), SceneRejection> {
        let id = obstacle.name.clone();
        (self.world.replace(obstacle)).map_err(|error| SceneRejection::of(&id, error.to_string()))?;
        self.twists.remove(&id);
        self.anchor(&id, frame, context);
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
    ) -> Result<Pose, SceneRejection> {
        let pose_rf = (context.frame_pose(&change.frame, self))
            .map_err(|message| SceneRejection::of(&change.id, format!("header.frame_id: {message}")))?;
        Ok(pose_rf * change.pose_fo)
    }

    fn move_object(
        &mut self,
        change: &ObjectChange,
        context: &SceneContext,
        warnings: &mut Vec<String>,
    ) -> Result<(), SceneRejection> {
        let id = &change.id;
        self.check_name(id, context)?;
        let pose_ro = self.pose_of(change, context)?;
        let known = self.world.obstacle_by_name(id).ok_or_else(|| {
            SceneRejection::of(
                id,
                "operation: it can not be moved, because there is no such object in the world",
            )
        })?;
        let moved = known.with_shapes_at(&change.shape_poses).ok_or_else(|| {
            let (given, has) = (change.shape_poses.len(), known.shapes.len());
            let message = format!(
                "{given} poses of shapes are given, but the object has {has} shapes: give as many, or none"
            );
            SceneRejection::of(id, message)
        })?;
        (self.world.replace(Obstacle { pose_ro, ..moved }))
            .map_err(|error| SceneRejection::of(id, error.to_string()))?;
        self.twists.remove(id);
        self.anchor(id, &change.frame, context);
        if !change.shapes.is_empty() {
            warnings.push(format!("object '{id}' is moved; the shapes given with the move are ignored"));
        }
        Ok(())
    }

    fn remove_object(&mut self, id: &str) -> Result<(), SceneRejection> {
        if self.is_sensed(id) || id == OCTOMAP {
            return Err(SceneRejection::of(
                id,
                "operation: what sensors see is not removed by name; see clear_octomap and point_cloud_ttl",
            )
            .without_gap());
        }
        self.world.remove(id).map_err(|_| {
            SceneRejection::of(
                id,
                "operation: it can not be removed, because there is no such object in the world",
            )
            .without_gap()
        })?;
        self.kinds.remove(id);
        self.anchors.remove(id);
        self.twists.remove(id);
        // as in MoveIt: the next object with this name is a different one; defaults of the name stay
        if let Some(matrix) = &mut self.matrix {
            matrix.forget(&HashSet::from([id]));
        }
        Ok(())
    }

    /// Removes all obstacles from messages and files; obstacles from sensors stay.
    pub(super) fn remove_all_objects(&mut self) {
        let names = self.given_names();
        for name in &names {
            self.kinds.remove(name);
            self.anchors.remove(name);
            self.twists.remove(name);
            // cannot fail: its name was just listed
            let _ = self.world.remove(name);
        }
        if let Some(matrix) = &mut self.matrix {
            matrix.forget(&names.iter().map(String::as_str).collect());
        }
    }

    /// Names of the obstacles that come from messages and files.
    pub(super) fn given_names(&self) -> Vec<String> {
        let names = self.world.obstacles().map(|o| &o.name);
        names.filter(|name| *name != OCTOMAP && !self.is_sensed(name)).cloned().collect()
    }

    /// Replaces the octomap.
    pub(super) fn set_octomap(
        &mut self,
        octomap: Option<&OctomapPlacement>,
        context: &SceneContext,
    ) -> Result<(), SceneRejection> {
        let placed = octomap.and_then(|o| Some((o, o.shape.clone()?)));
        let Some((octomap, shape)) = placed else {
            self.remove_octomap();
            return Ok(());
        };
        let pose_rf = (context.frame_pose(&octomap.frame, self))
            .map_err(|message| SceneRejection::of_octomap(format!("header.frame_id: {message}")))?;
        let obstacle = Obstacle::of_shape(OCTOMAP, pose_rf * octomap.pose_fo, shape);
        (self.world.replace(obstacle)).map_err(|error| SceneRejection::of_octomap(error.to_string()))?;
        self.file_octree = None;
        self.anchor(OCTOMAP, &octomap.frame, context);
        Ok(())
    }

    /// Removes the octomap.
    pub fn remove_octomap(&mut self) {
        self.anchors.remove(OCTOMAP);
        self.file_octree = None;
        let _ = self.world.remove(OCTOMAP);
    }
}

/// An obstacle with additional shapes, in its own frame, and with the subframes of the change, as in `MoveIt`.
fn extended(known: &Obstacle, change: &ObjectChange) -> Obstacle {
    let shapes = known.shapes.iter().chain(&change.shapes).cloned().collect();
    Obstacle { shapes, subframes: change.subframes.clone(), ..known.clone() }
}

/// Whether a change names a frame or a pose.
fn is_given(change: &ObjectChange) -> bool {
    !change.frame.is_empty() || change.pose_fo != Pose::identity()
}

/// Whether two poses are equal but for rounding.
fn are_alike(a: &Pose, b: &Pose) -> bool {
    const ROUNDING: f64 = 1e-9;
    let difference = a.inverse() * b;
    difference.translation.vector.norm() <= ROUNDING && difference.rotation.angle() <= ROUNDING
}
