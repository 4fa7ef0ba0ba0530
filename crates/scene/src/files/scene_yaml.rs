//! Reader of planning scenes in YAML.

mod parser;

use std::collections::HashMap;

use clearance_geometry::math::Extremes;
use clearance_robot::{MeshFiles, RobotModel};

use super::scene_error::SceneError;
use super::scene_file::SceneFile;
use super::scene_loader::SceneLoader;
use super::text::{
    AttachedText, LinkPaddingText, LinkScaleText, ObjectText, OctomapBody, OctomapText, SceneText,
    TransformStampedText,
};
use crate::{
    AttachedChange, FileOctree, FixedFrame, MatrixEntries, OCTOMAP, ObjectChange, OctomapMessage,
    SceneChange, SceneUpdate,
};

impl SceneLoader {
    /// The scene of one YAML text; see [`Self::read_yaml`].
    pub fn from_yaml(
        text: &str,
        file: &str,
        robot: &RobotModel,
        files: &MeshFiles,
    ) -> Result<Self, SceneError> {
        let mut loader = Self::default();
        loader.read_yaml(text, file, robot, files)?;
        Ok(loader)
    }

    /// Reads a `moveit_msgs/PlanningScene` or its `world` alone, and adds it to the existing scene.
    ///
    /// It is applied like a message, with these differences: a scene with `is_diff` may replace objects, in any other an existing id is
    /// an error; only one file may have an `allowed_collision_matrix`. Poses in the frame of a moving link use the file's `robot_state`,
    /// or the default configuration. Mesh resources are looked up by `files`.
    ///
    /// # Errors
    /// The first error, with object and field. Content read before it stays.
    pub fn read_yaml(
        &mut self,
        text: &str,
        file: &str,
        robot: &RobotModel,
        files: &MeshFiles,
    ) -> Result<(), SceneError> {
        let fault = |message: String| SceneError::of_file(file, message);
        let scene = parser::read(text, file)?;
        if is_empty_scene(&scene) {
            return Err(fault("no planning scene: expected 'world' or 'collision_objects'".to_owned()));
        }
        let state = scene.robot_state.unwrap_or_default();
        let is_empty = self.scene.world.is_empty() && self.scene.fixed_frames.is_empty();
        self.robot_state.read_state(&state, robot, is_empty).map_err(fault)?;
        let placed = self.robot_state.placed(robot);
        let context = placed.context(robot);
        let mut reader = SceneFile { is_diff: scene.is_diff, ..self.file(file, &context) };
        let model = scene.robot_model_name.unwrap_or_default();
        reader.read_settings(
            &model,
            &scene.fixed_frame_transforms,
            &scene.link_padding,
            &scene.link_scale,
        )?;
        reader.read_matrix(scene.allowed_collision_matrix)?;
        for (i, attached) in state.attached_collision_objects.into_iter().enumerate() {
            reader.read_attached(attached, i, files)?;
        }
        let (objects, octomap) = scene.world.map(|w| (w.collision_objects, w.octomap)).unwrap_or_default();
        for object in objects.into_iter().chain(scene.collision_objects.into_iter().flatten()) {
            reader.read_object(object, files)?;
        }
        for octomap in octomap.iter().chain(&scene.octomap) {
            reader.read_octomap(octomap)?;
        }
        let strange = self.scene.matrix_without_effect(robot);
        self.warnings.extend(strange.map(|warning| format!("{file}: {warning}")));
        if self.scene.world.is_empty() {
            self.warnings.push(format!("{file}: the scene has no objects"));
        }
        Ok(())
    }
}

impl SceneFile<'_> {
    fn read_settings(
        &mut self,
        robot_model_name: &str,
        frames: &[TransformStampedText],
        padding: &[LinkPaddingText],
        scale: &[LinkScaleText],
    ) -> Result<(), SceneError> {
        let fixed_frames = frames.iter().enumerate().map(|(i, text)| self.fixed_frame(i, text));
        let change = SceneChange {
            is_diff: true,
            fixed_frames: fixed_frames.collect::<Result<_, _>>()?,
            robot_model_name: robot_model_name.to_owned(),
            link_padding: padding.iter().map(|l| (l.link_name.clone(), l.padding)).collect(),
            link_scale: scale.iter().map(|l| (l.link_name.clone(), l.scale)).collect(),
            ..SceneChange::default()
        };
        let scene = &self.scene;
        let before = [scene.link_padding.clone(), scene.link_scale.clone()];
        self.apply(&SceneUpdate::Scene(Box::new(change)))?;
        self.keep_sizes(&before)
    }

    /// `MoveIt` lists all links, most of them with padding 0 and scale 1. Such an entry does not make a link smaller than an earlier file
    /// made it; only a scene with `is_diff` changes other sizes.
    fn keep_sizes(&mut self, [padding, scale]: &[HashMap<String, f64>; 2]) -> Result<(), SceneError> {
        let scene = &mut *self.scene;
        let fields = [
            ("link_padding", padding, &mut scene.link_padding, 0.0),
            ("link_scale", scale, &mut scene.link_scale, 1.0),
        ];
        for (field, before, now, usual) in fields {
            for (link, earlier) in before {
                let Some(size) = now.get_mut(link) else { continue };
                if *size == usual {
                    *size = size.greater(*earlier);
                } else if size != earlier && !self.is_diff {
                    let why =
                        format!("{field} of '{link}' is {size:?}, but {earlier:?} in a file before this one");
                    return Err(SceneError::of_file(self.name, why));
                }
            }
        }
        Ok(())
    }

    fn fixed_frame(&self, i: usize, text: &TransformStampedText) -> Result<FixedFrame, SceneError> {
        let fault = |e: String| SceneError::of_file(self.name, format!("fixed_frame_transforms[{i}].{e}"));
        Ok(FixedFrame {
            name: text.child_frame_id.clone(),
            parent: text.header.frame_id.clone(),
            pose_pf: text.transform.pose("transform").map_err(fault)?,
        })
    }

    fn read_matrix(&mut self, entries: Option<MatrixEntries>) -> Result<(), SceneError> {
        let Some(entries) = entries.filter(|entries| *entries != MatrixEntries::default()) else {
            return Ok(());
        };
        if self.scene.matrix.is_some() {
            let message = "a second allowed_collision_matrix; only one world file may have one";
            return Err(SceneError::of_file(self.name, message));
        }
        self.set_matrix(&entries)
    }

    fn read_attached(&mut self, text: AttachedText, i: usize, files: &MeshFiles) -> Result<(), SceneError> {
        let (id, name) = (text.object.id.clone(), self.name);
        let mut remarks = Vec::new();
        let field = |message: String| format!("robot_state.attached_collision_objects[{i}]: {message}");
        let change = AttachedChange::from_text(text, files, &mut remarks)
            .map_err(|message| SceneError::of_object(name, &id, field(message)))?;
        self.warn_about(&id, remarks);
        let changed = self.change_attached(change);
        changed.map_err(|error| SceneError { message: field(error.message), ..error })
    }

    fn read_object(&mut self, text: ObjectText, files: &MeshFiles) -> Result<(), SceneError> {
        let id = text.id.clone();
        let mut remarks = Vec::new();
        let change = ObjectChange::from_text(text, files, &mut remarks)
            .map_err(|message| SceneError::of_object(self.name, &id, message))?;
        self.warn_about(&id, remarks);
        self.change_object(change)
    }

    fn read_octomap(&mut self, text: &OctomapText) -> Result<(), SceneError> {
        let name = self.name;
        let fault =
            |message: String| SceneError::of_object(name, OCTOMAP, format!("world.octomap.{message}"));
        let OctomapBody { id, binary, resolution, data, .. } = &text.octomap;
        let message = OctomapMessage { id, binary: *binary, resolution: *resolution, data };
        if message.is_absent() {
            return Ok(());
        }
        let (frame, pose_fo) = (text.header.frame_id.clone(), text.origin.pose("origin").map_err(fault)?);
        let octomap = message.placed(frame, pose_fo, self.unknown_is_occupied);
        let octomap = octomap.map_err(|why| fault(format!("octomap: {why}")))?;
        self.set_octomap(octomap, FileOctree::of_message(&message, self.unknown_is_occupied))
    }
}

fn is_empty_scene(scene: &SceneText) -> bool {
    scene.world.is_none()
        && scene.collision_objects.is_none()
        && scene.allowed_collision_matrix.is_none()
        && scene.robot_state.is_none()
        && scene.octomap.is_none()
        && scene.link_padding.is_empty()
        && scene.link_scale.is_empty()
}

#[cfg(test)]
mod tests;
