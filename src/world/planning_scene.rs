//! Worlds out of files: the YAML of a `moveit_msgs/PlanningScene`, MoveIt's `.scene` text, clouds and octrees.

use std::collections::HashMap;

use super::cloud::CloudPoints;
use super::frames::Frames;
use super::octomap::Octomap;
use super::scene_object::{OCTOMAP_NAME, ObjectError};
use super::scene_text::MatrixEntries;
use super::{Obstacle, World};
use crate::geometry::Shape;
use crate::math::Pose;
use crate::robot::{Configuration, LinkPoses, MeshFiles, RobotModel, check_name_length};

/// What scene files hold, one read after the other: each adds to what those before it left.
#[derive(Clone, Debug, Default)]
pub struct PlanningScene {
    pub world: World,
    /// The allowed collision matrix, if a file has one.
    pub allowed: Option<MatrixEntries>,
    /// Safety distance (m) by which single links count as larger, where it is not zero.
    pub link_padding: HashMap<String, f64>,
    /// Factors by which single links count as larger, where they are not one.
    pub link_scale: HashMap<String, f64>,
    /// Whether what an octree does not know counts as occupied; decided before it is read.
    pub unknown_is_occupied: bool,
    /// What was odd but accepted; each names its file.
    pub warnings: Vec<String>,
    pub(super) situation: Situation,
}

/// Where the robot is and what other frames there are, as far as files tell.
#[derive(Clone, Debug, Default)]
pub(super) struct Situation {
    /// The default configuration when no file tells.
    pub configuration: Option<Configuration>,
    pub pose_vr: Option<Pose>,
    pub frames: HashMap<String, Pose>,
}

/// A fault in a scene file, with the object and field concerned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    pub file: String,
    pub object: Option<String>,
    pub message: String,
}

impl std::fmt::Display for SceneError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.object {
            Some(id) => write!(f, "{}: object '{id}': {}", self.file, self.message),
            None => write!(f, "{}: {}", self.file, self.message),
        }
    }
}

impl std::error::Error for SceneError {}

/// The start of a name that is too long.
fn short(name: &str) -> String {
    name.chars().take(40).chain(['…']).collect()
}

impl SceneError {
    pub(super) fn of_file(file: &str, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), object: None, message: message.into() }
    }

    pub(super) fn of_object(file: &str, object: &str, message: impl Into<String>) -> Self {
        let object = check_name_length(object).map_or_else(|_| short(object), |()| object.to_owned());
        Self { object: Some(object), ..Self::of_file(file, message) }
    }
}

impl PlanningScene {
    /// The scene of one YAML text; see [`Self::read_yaml`].
    pub fn from_yaml(
        text: &str,
        file: &str,
        robot: &RobotModel,
        files: &MeshFiles,
    ) -> Result<Self, SceneError> {
        let mut scene = Self::default();
        scene.read_yaml(text, file, robot, files)?;
        Ok(scene)
    }

    /// Adds the points of a file as an obstacle of balls with this `radius` (m), in the root frame; `name` is the file's
    /// stem.
    pub fn add_cloud(
        &mut self,
        points: CloudPoints,
        name: &str,
        radius: f64,
        file: &str,
        robot: &RobotModel,
    ) -> Result<(), SceneError> {
        let fault = |message: String| SceneError::of_file(file, message);
        let CloudPoints { dropped, rounding, .. } = points;
        self.warnings.extend(points.remarks.iter().map(|r| format!("{file}: {r}")));
        if dropped > 0 {
            self.warnings.push(format!("{file}: {dropped} points without finite coordinates are left out"));
        }
        if rounding > NOTABLE_ROUNDING {
            self.warnings.push(format!(
                "{file}: points are {rounding:.1e} m larger, since 32-bit floats tell no less apart so far from the origin"
            ));
        }
        let Some(cloud) = points.cloud(radius).map_err(|e| fault(e.to_string()))? else {
            self.warnings.push(format!("{file}: the cloud has no points"));
            return Ok(());
        };
        if robot.link_by_name(name).is_some() {
            return Err(fault(ObjectError::NameOfLink(name.to_owned()).to_string()));
        }
        let obstacle = Obstacle::of_shape(name, Pose::identity(), Shape::Points(cloud));
        self.world.add(obstacle).map_err(|e| fault(e.to_string()))?;
        Ok(())
    }

    /// Makes an octree the world's octomap; `pose_ro` is its pose in the root frame. Only if it `replaces` may there be
    /// one already.
    pub fn set_octomap(
        &mut self,
        octomap: &Octomap,
        pose_ro: Pose,
        replaces: bool,
        file: &str,
    ) -> Result<(), SceneError> {
        let fault = |message: String| SceneError::of_object(file, OCTOMAP_NAME, message);
        if self.world.remove(OCTOMAP_NAME).is_ok() && !replaces {
            return Err(fault("a second octomap; a world has one".to_owned()));
        }
        match octomap.to_voxels(self.unknown_is_occupied).map_err(|e| fault(e.to_string()))? {
            None => self.warnings.push(format!("{file}: the octomap has no occupied cells")),
            Some(voxels) => {
                let obstacle = Obstacle::of_shape(OCTOMAP_NAME, pose_ro, Shape::Voxels(voxels));
                self.world.add(obstacle).map_err(|e| fault(e.to_string()))?;
            }
        }
        Ok(())
    }

    /// Names in the matrix that nothing bears: perhaps misspelled, perhaps of objects that come later.
    pub(super) fn warn_of_strange_names(&mut self, file: &str, robot: &RobotModel) {
        let Some(matrix) = &self.allowed else { return };
        let known = |name: &str| {
            robot.link_by_name(name).is_some()
                || self.world.id(name).is_some()
                || self.world.attached_by_name(name).is_some()
                || name == OCTOMAP_NAME
        };
        let names = matrix.entry_names.iter().chain(&matrix.default_entry_names);
        let strange = names.filter(|name| !known(name));
        let warning = |name| format!("{file}: allowed_collision_matrix: nothing is named '{name}'");
        self.warnings.extend(strange.map(warning));
    }
}

/// Rounding of points (m) that is told.
const NOTABLE_ROUNDING: f64 = 1e-4;

impl Situation {
    pub fn link_poses(&self, robot: &RobotModel) -> LinkPoses {
        let mut poses = LinkPoses::new(robot);
        let default = || robot.default_configuration();
        let q = self.configuration.clone().unwrap_or_else(default);
        robot.forward_kinematics(&q, &mut poses);
        poses
    }

    pub fn frames<'a>(&'a self, robot: &'a RobotModel, poses: &'a LinkPoses) -> Frames<'a> {
        Frames { robot, poses, pose_vr: self.pose_vr.as_ref(), others: &self.frames }
    }
}
