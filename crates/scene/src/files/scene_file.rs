//! Applies the content of one file to the scene. A rejected part makes the file an error.

use std::sync::Arc;

use super::scene_error::SceneError;
use crate::{
    Applied, AttachedChange, FileOctree, MatrixEntries, OCTOMAP, ObjectChange, Obstacle, OctomapPlacement,
    Operation, RobotStateChange, Scene, SceneChange, SceneContext, SceneRejection, SceneUpdate, WorldChange,
};

/// A file that is being read into a scene.
pub struct SceneFile<'f> {
    pub scene: &'f mut Scene,
    pub warnings: &'f mut Vec<String>,
    /// Its name, for messages.
    pub name: &'f str,
    pub context: &'f SceneContext<'f>,
    /// Whether the file may replace objects.
    pub is_diff: bool,
    /// Whether unknown space of an octree counts as occupied.
    pub unknown_is_occupied: bool,
}

impl SceneFile<'_> {
    /// Applies an update; unusual content becomes a warning that names the file.
    pub fn apply(&mut self, update: &SceneUpdate) -> Result<(), SceneError> {
        let applied = self.scene.apply(update, self.context);
        self.finish(applied)
    }

    fn finish(&mut self, applied: Applied) -> Result<(), SceneError> {
        let remarks = applied.warnings.into_iter().chain(applied.ineffective);
        let name = self.name;
        self.warnings.extend(remarks.map(|remark| format!("{name}: {remark}")));
        applied.refusals.into_iter().next().map_or(Ok(()), |rejection| Err(self.fault(rejection)))
    }

    pub fn change_object(&mut self, change: ObjectChange) -> Result<(), SceneError> {
        if change.operation == Operation::Add {
            self.check_is_new(&change.id)?;
        }
        let is_placed = match change.operation {
            Operation::Add | Operation::Move => true,
            Operation::Append => self.scene.world.id(&change.id).is_none(),
            Operation::Remove => false,
        };
        let remark = is_placed.then(|| self.context.frame_remark(&change.frame, self.scene)).flatten();
        self.warn_about(&change.id, remark);
        let world = WorldChange { objects: vec![change], octomap: None };
        self.apply(&SceneUpdate::Scene(Box::new(SceneChange {
            is_diff: true,
            world,
            ..SceneChange::default()
        })))
    }

    pub fn change_attached(&mut self, change: AttachedChange) -> Result<(), SceneError> {
        if matches!(change.object.operation, Operation::Add | Operation::Append) {
            let remark = self.context.attachment_remark(&change, self.scene);
            self.warn_about(&change.object.id, remark);
        }
        let robot_state =
            RobotStateChange { is_diff: true, attached: vec![change], ..RobotStateChange::default() };
        let change = SceneChange { is_diff: true, robot_state, ..SceneChange::default() };
        self.apply(&SceneUpdate::Scene(Box::new(change)))
    }

    /// Adds an obstacle whose pose is given in a frame.
    pub fn add_obstacle(&mut self, obstacle: Obstacle, frame: &str) -> Result<(), SceneError> {
        self.check_is_new(&obstacle.name)?;
        let added = self.scene.add_obstacle(obstacle, frame, self.context);
        added.map_err(|rejection| self.fault(rejection))
    }

    /// Sets the scene's octomap; `octree` is its tree.
    pub fn set_octomap(
        &mut self,
        octomap: OctomapPlacement,
        octree: Option<FileOctree>,
    ) -> Result<(), SceneError> {
        if self.scene.world.id(OCTOMAP).is_some() && !self.is_diff {
            return Err(SceneError::of_object(self.name, OCTOMAP, "a second octomap; a world has one"));
        }
        if octomap.shape.is_none() {
            self.warnings.push(format!("{}: the octomap has no occupied cells", self.name));
        }
        let remark = self.context.frame_remark(&octomap.frame, self.scene);
        self.warn_about(OCTOMAP, remark);
        self.apply(&SceneUpdate::Octomap(Some(octomap)))?;
        // a map without occupied cells is no obstacle
        let is_obstacle = self.scene.world.id(OCTOMAP).is_some();
        self.scene.file_octree = octree.filter(|_| is_obstacle).map(Arc::new);
        Ok(())
    }

    /// The allowed collision matrix of the file.
    pub fn set_matrix(&mut self, entries: &MatrixEntries) -> Result<(), SceneError> {
        let mut applied = Applied::default();
        // default entries alone have no effect in a difference message; but a file defines an initial scene
        self.scene.set_matrix(entries, self.is_diff, &mut applied);
        self.finish(applied)
    }

    pub fn warn_about(&mut self, id: &str, remarks: impl IntoIterator<Item = String>) {
        let name = self.name;
        let named = remarks.into_iter().map(|remark| format!("{name}: object '{id}': {remark}"));
        self.warnings.extend(named);
    }

    fn check_is_new(&self, id: &str) -> Result<(), SceneError> {
        if self.is_diff || self.scene.world.id(id).is_none() {
            return Ok(());
        }
        let message = "it is given twice; only a scene with is_diff: true replaces objects";
        Err(SceneError::of_object(self.name, id, message))
    }

    fn fault(&self, rejection: SceneRejection) -> SceneError {
        match rejection.object {
            Some(id) => SceneError::of_object(self.name, &id, rejection.message),
            None => SceneError::of_file(self.name, rejection.message),
        }
    }
}
