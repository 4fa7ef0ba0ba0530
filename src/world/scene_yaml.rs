//! Planning scenes out of YAML.

mod text;

use super::octomap::Octomap;
use super::planning_scene::{PlanningScene, SceneError, Situation};
use super::scene_object::{OCTOMAP_NAME, Operation, SceneAttachment, SceneObject};
use super::scene_text::{
    AttachedText, LinkPaddingText, LinkScaleText, MatrixEntries, MultiDofText, ObjectText, OctomapText,
    RobotStateText, SceneText, TransformStampedText,
};
use crate::math::Pose;
use crate::robot::{LinkPoses, MeshFiles, RobotModel};

/// What is the same for all parts of one file.
struct Reader<'r> {
    file: &'r str,
    robot: &'r RobotModel,
    files: &'r MeshFiles,
    /// Whether the file may replace objects.
    is_diff: bool,
    /// Where the links are in the scene's state.
    poses: LinkPoses,
}

/// Positions (rad, m) by name.
type NamedPositions = Vec<(String, f64)>;

impl PlanningScene {
    /// Reads a `moveit_msgs/PlanningScene` or its `world` alone, on top of what is there.
    ///
    /// As in `MoveIt`, attached objects come before objects, objects in the order of the file, and frames are links, the
    /// parent frame of the virtual joint, objects, subframes and `fixed_frame_transforms`. A scene with `is_diff` may replace
    /// objects; in any other an id that is there already is a fault. Poses in the frame of a link that
    /// moves are those of the file's `robot_state`, or of the default configuration. Mesh resources are looked up by
    /// `files`.
    ///
    /// # Errors
    /// The first fault, with object and field. What was read before it stays.
    pub fn read_yaml(
        &mut self,
        text: &str,
        file: &str,
        robot: &RobotModel,
        files: &MeshFiles,
    ) -> Result<(), SceneError> {
        let fault = |message: String| SceneError::of_file(file, message);
        let scene = text::read(text, file)?;
        if says_nothing(&scene) {
            return Err(fault("no planning scene: expected 'world' or 'collision_objects'".to_owned()));
        }
        let state = scene.robot_state.unwrap_or_default();
        let remarks = self.situation.read_state(&state, robot).map_err(fault)?;
        self.warnings.extend(remarks.iter().map(|remark| format!("{file}: {remark}")));
        let poses = self.situation.link_poses(robot);
        let reader = Reader { file, robot, files, is_diff: scene.is_diff, poses };
        self.read_fixed_frames(&scene.fixed_frame_transforms, &reader)?;
        self.read_sizes(&scene.link_padding, &scene.link_scale, robot).map_err(fault)?;
        self.take_matrix(scene.allowed_collision_matrix, file)?;
        for (i, object) in state.attached_collision_objects.into_iter().enumerate() {
            self.read_attached(object, i, &reader)?;
        }
        let (objects, octomap) = scene.world.map(|w| (w.collision_objects, w.octomap)).unwrap_or_default();
        for object in objects.into_iter().chain(scene.collision_objects.into_iter().flatten()) {
            self.read_object(object, &reader)?;
        }
        for octomap in octomap.iter().chain(&scene.octomap) {
            self.read_octomap(octomap, &reader)?;
        }
        self.warn_of_strange_names(file, robot);
        if self.world.is_empty() {
            self.warnings.push(format!("{file}: the scene has no objects"));
        }
        Ok(())
    }

    fn take_matrix(&mut self, matrix: Option<MatrixEntries>, file: &str) -> Result<(), SceneError> {
        let Some(matrix) = matrix.filter(|m| *m != MatrixEntries::default()) else { return Ok(()) };
        if self.allowed.replace(matrix).is_some() {
            let message = "a second allowed_collision_matrix; only one world file may have one";
            return Err(SceneError::of_file(file, message));
        }
        Ok(())
    }

    fn read_fixed_frames(
        &mut self,
        transforms: &[TransformStampedText],
        reader: &Reader,
    ) -> Result<(), SceneError> {
        for (i, text) in transforms.iter().enumerate() {
            let field = format!("fixed_frame_transforms[{i}]");
            let fault = |e: String| SceneError::of_file(reader.file, format!("{field}.{e}"));
            let pose_pc = text.transform.pose("transform").map_err(fault)?;
            let found = self.situation.frames(reader.robot, &reader.poses);
            let found = found.find(&text.header.frame_id, &self.world);
            let found = found.map_err(|e| fault(format!("header.frame_id: {e}")))?;
            if let Some(caution) = found.caution {
                self.warnings.push(format!("{}: {field}: {caution}", reader.file));
            }
            let name = text.child_frame_id.trim_start_matches('/').to_owned();
            self.situation.frames.insert(name, found.pose_rf * pose_pc);
        }
        Ok(())
    }

    fn read_sizes(
        &mut self,
        padding: &[LinkPaddingText],
        scale: &[LinkScaleText],
        robot: &RobotModel,
    ) -> Result<(), String> {
        let known = |name: &str, field: &str| {
            let link = robot.link_by_name(name);
            link.map(|_| ()).ok_or_else(|| format!("{field}: the robot has no link '{name}'"))
        };
        for LinkPaddingText { link_name, padding } in padding {
            known(link_name, "link_padding")?;
            if !(padding.is_finite() && *padding >= 0.0) {
                return Err(format!(
                    "link_padding of '{link_name}' is {padding}, but must be a finite number of metres, zero or more"
                ));
            }
            // MoveIt lists all links, most of them with none: that is no decision against a padding of all links
            if *padding > 0.0 {
                self.link_padding.insert(link_name.clone(), *padding);
            }
        }
        for LinkScaleText { link_name, scale } in scale {
            known(link_name, "link_scale")?;
            if !(scale.is_finite() && *scale > 0.0) {
                return Err(format!(
                    "link_scale of '{link_name}' is {scale}, but must be a finite number above zero"
                ));
            }
            if *scale != 1.0 {
                self.link_scale.insert(link_name.clone(), *scale);
            }
        }
        Ok(())
    }

    fn read_attached(&mut self, text: AttachedText, i: usize, reader: &Reader) -> Result<(), SceneError> {
        let id = text.object.id.clone();
        let fault = |message: String| {
            let message = format!("robot_state.attached_collision_objects[{i}]: {message}");
            SceneError::of_object(reader.file, &id, message)
        };
        let mut remarks = Vec::new();
        let attachment = SceneAttachment::from_text(text, reader.files, &mut remarks).map_err(fault)?;
        let frames = self.situation.frames(reader.robot, &reader.poses);
        let said = self.world.apply_attachment(attachment, &frames);
        remarks.extend(said.map_err(|e| fault(e.to_string()))?);
        self.note(reader.file, &id, remarks);
        Ok(())
    }

    fn read_object(&mut self, text: ObjectText, reader: &Reader) -> Result<(), SceneError> {
        let id = text.id.clone();
        let fault = |message: String| SceneError::of_object(reader.file, &id, message);
        let mut remarks = Vec::new();
        let object = SceneObject::from_text(text, reader.files, &mut remarks).map_err(fault)?;
        if object.operation == Operation::Add && self.world.id(&id).is_some() && !reader.is_diff {
            return Err(fault(
                "it is given twice; only a scene with is_diff: true replaces objects".to_owned(),
            ));
        }
        let removes = object.operation == Operation::Remove;
        let before: Vec<String> = if removes { self.names() } else { Vec::new() };
        let frames = self.situation.frames(reader.robot, &reader.poses);
        remarks.extend(self.world.apply(object, &frames).map_err(|e| fault(e.to_string()))?);
        let gone = before.iter().filter(|name| self.world.id(name).is_none());
        if let Some(matrix) = &mut self.allowed {
            gone.for_each(|name| matrix.forget(name));
        }
        self.note(reader.file, &id, remarks);
        Ok(())
    }

    fn names(&self) -> Vec<String> {
        self.world.obstacles().map(|o| o.name.clone()).collect()
    }

    fn note(&mut self, file: &str, id: &str, remarks: Vec<String>) {
        let named = remarks.into_iter().map(|remark| format!("{file}: object '{id}': {remark}"));
        self.warnings.extend(named);
    }

    fn read_octomap(&mut self, text: &OctomapText, reader: &Reader) -> Result<(), SceneError> {
        let fault = |message: String| {
            SceneError::of_object(reader.file, OCTOMAP_NAME, format!("world.octomap.{message}"))
        };
        let body = &text.octomap;
        if body.data.is_empty() {
            return Ok(());
        }
        let octomap = Octomap::from_message(body.binary, &body.id, body.resolution, &body.data);
        let octomap = octomap.map_err(|e| fault(format!("octomap: {e}")))?;
        let frames = self.situation.frames(reader.robot, &reader.poses);
        let found = frames.find(&text.header.frame_id, &self.world);
        let found = found.map_err(|e| fault(format!("header.frame_id: {e}")))?;
        let pose_fo = text.origin.pose("origin").map_err(fault)?;
        self.note(reader.file, OCTOMAP_NAME, found.caution.into_iter().collect());
        self.set_octomap(&octomap, found.pose_rf * pose_fo, reader.is_diff, reader.file)
    }
}

impl Situation {
    /// Where the robot is, if the state tells; answers with what is not read.
    fn read_state(&mut self, text: &RobotStateText, robot: &RobotModel) -> Result<Vec<String>, String> {
        let joints = &text.joint_state;
        if joints.name.len() != joints.position.len() {
            return Err(format!(
                "robot_state.joint_state: {} positions for {} names",
                joints.position.len(),
                joints.name.len()
            ));
        }
        let (placed, remarks) = self
            .read_base(&text.multi_dof_joint_state, robot)
            .map_err(|e| format!("robot_state.multi_dof_joint_state: {e}"))?;
        if !(joints.name.is_empty() && placed.is_empty()) {
            let field = if placed.is_empty() { "robot_state.joint_state" } else { "robot_state" };
            let single = joints.name.iter().map(String::as_str).zip(joints.position.iter().copied());
            let several = placed.iter().map(|(name, position)| (name.as_str(), *position));
            let rest = self.configuration.clone().unwrap_or_else(|| robot.default_configuration());
            let q = robot.configuration_over(&rest, single.chain(several));
            self.configuration = Some(q.map_err(|e| format!("{field}: {e}"))?);
        }
        Ok(remarks)
    }

    /// The positions of planar and floating joints, by name, and what is not read. The virtual joint of the root says where the robot stands.
    fn read_base(
        &mut self,
        text: &MultiDofText,
        robot: &RobotModel,
    ) -> Result<(NamedPositions, Vec<String>), String> {
        if text.joint_names.len() != text.transforms.len() {
            let (given, names) = (text.transforms.len(), text.joint_names.len());
            return Err(format!("{given} transforms for {names} joint_names"));
        }
        let (mut placed, mut remarks) = (Vec::new(), Vec::new());
        for (name, transform) in text.joint_names.iter().zip(&text.transforms) {
            let pose = transform.pose(name)?;
            let mut virtual_joints = robot.srdf().into_iter().flat_map(|srdf| &srdf.virtual_joints);
            if robot.joint_by_name(name).is_some() {
                let frame = &text.header.frame_id;
                if !robot.is_model_frame(frame) {
                    let root = &robot.link(robot.root()).name;
                    return Err(format!("header.frame_id is '{frame}', but must be '{root}' or empty"));
                }
                placed.extend(robot.positions_of_transform(name, &pose).map_err(|e| e.to_string())?);
            } else if virtual_joints.any(|j| j.name == *name && j.child_link == robot.root()) {
                self.pose_vr = Some(pose);
            } else if pose != Pose::identity() {
                remarks.push(format!(
                    "robot_state.multi_dof_joint_state: '{name}' is no virtual joint of the robot's root: it is not read"
                ));
            }
        }
        Ok((placed, remarks))
    }
}

fn says_nothing(scene: &SceneText) -> bool {
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
