//! Loader of world files of any kind, one after the other, into one scene; adds clouds and octrees itself.

use std::path::Path;

use clearance_geometry::Shape;
use clearance_geometry::math::Pose;
use clearance_robot::{MeshFiles, RobotModel};

use super::robot_state_yaml::FileRobotState;
use super::scene_error::SceneError;
use super::scene_file::SceneFile;
use super::world_file_kind::WorldFileKind;
use crate::{
    CloudPoints, FileOctree, OCTOMAP, Obstacle, Octomap, OctomapPlacement, Scene, SceneContext, read_cloud,
};

/// Reads files of any kind, one after the other; each adds to the scene of the earlier ones.
#[derive(Clone, Debug, Default)]
pub struct SceneLoader {
    /// The scene of the files read so far.
    pub scene: Scene,
    /// True if unknown space of an octree counts as occupied; set before the octree is read.
    pub unknown_is_occupied: bool,
    /// Warnings about accepted content; each names its file.
    pub warnings: Vec<String>,
    pub(super) robot_state: FileRobotState,
}

impl SceneLoader {
    /// The scene. Frames of the files are removed: they are only valid for the robot pose of the files.
    #[must_use]
    pub fn into_scene(self) -> Scene {
        self.scene.without_frames()
    }

    /// Adds the content of a file of any kind; `path` is only used as its name. Clouds and octrees are in the root frame. A cloud's
    /// points become balls of `point_radius` (m), and its obstacle is named after the file without its extension.
    pub fn read_file(
        &mut self,
        bytes: &[u8],
        path: &Path,
        point_radius: Option<f64>,
        robot: &RobotModel,
        files: &MeshFiles,
    ) -> Result<(), SceneError> {
        let file = path.display().to_string();
        let text = || {
            std::str::from_utf8(bytes)
                .map_err(|e| SceneError::of_file(&file, format!("no UTF-8 text at byte {}", e.valid_up_to())))
        };
        match WorldFileKind::of(bytes, path) {
            WorldFileKind::Yaml => self.read_yaml(text()?, &file, robot, files),
            WorldFileKind::SceneText => self.read_scene_text(text()?, &file, robot),
            WorldFileKind::Octomap => {
                let octomap =
                    Octomap::from_file(bytes).map_err(|e| SceneError::of_file(&file, e.to_string()))?;
                self.add_octomap(&octomap, &file, robot)
            }
            WorldFileKind::Cloud => {
                let Some(radius) = point_radius else {
                    return Err(SceneError::of_file(&file, "a cloud needs the radius of its points"));
                };
                let points = read_cloud(bytes).map_err(|e| SceneError::of_file(&file, e.to_string()))?;
                let name = path.file_stem().unwrap_or_default().to_string_lossy();
                self.add_cloud(points, &name, radius, &file, robot)
            }
        }
    }

    /// Adds the points of a file as an obstacle made of balls with this `radius` (m), in the root frame; `name` is the file's stem.
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
                "{file}: points are {rounding:.1e} m larger, the resolution of 32-bit floats so far from the origin"
            ));
        }
        let Some(cloud) = points.cloud(radius).map_err(|e| fault(e.to_string()))? else {
            self.warnings.push(format!("{file}: the cloud has no points"));
            return Ok(());
        };
        let placed = self.robot_state.placed(robot);
        let cloud = Obstacle::of_shape(name, Pose::identity(), Shape::Points(cloud));
        self.file(file, &placed.context(robot)).add_obstacle(cloud, "")
    }

    /// Uses the octree of a file as the scene's octomap, in the root frame.
    ///
    /// # Errors
    /// If there is an octomap already, or the octree has too many cells.
    pub fn add_octomap(
        &mut self,
        octomap: &Octomap,
        file: &str,
        robot: &RobotModel,
    ) -> Result<(), SceneError> {
        let (frame, pose_fo) = (String::new(), Pose::identity());
        let placement = OctomapPlacement::of(octomap, frame, pose_fo, self.unknown_is_occupied)
            .map_err(|message| SceneError::of_object(file, OCTOMAP, message))?;
        let octree = FileOctree::of(octomap, self.unknown_is_occupied);
        let placed = self.robot_state.placed(robot);
        self.file(file, &placed.context(robot)).set_octomap(placement, Some(octree))
    }

    /// A file that must not replace any object.
    pub(super) fn file<'f>(&'f mut self, name: &'f str, context: &'f SceneContext<'f>) -> SceneFile<'f> {
        SceneFile {
            scene: &mut self.scene,
            warnings: &mut self.warnings,
            name,
            context,
            is_diff: false,
            unknown_is_occupied: self.unknown_is_occupied,
        }
    }
}

/// Rounding of points (m) above which a warning is issued.
const NOTABLE_ROUNDING: f64 = 1e-4;
