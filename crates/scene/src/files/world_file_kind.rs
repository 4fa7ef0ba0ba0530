//! Recognises the kind of a world file by its content, and calls the reader of its kind.

use std::ffi::OsStr;
use std::path::Path;

use clearance_robot::{MeshFiles, RobotModel};

use super::scene_error::SceneError;
use super::scene_loader::SceneLoader;
use crate::{Octomap, is_cloud, read_cloud};

/// Kind of an obstacle file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorldFileKind {
    /// The YAML of a planning scene.
    Yaml,
    /// MoveIt's `.scene` text.
    SceneText,
    /// An octree of OctoMap, `.bt` or `.ot`.
    Octomap,
    /// A cloud of points, PCD or PLY.
    Cloud,
}

impl WorldFileKind {
    /// Recognises a file by its content, or by its name where the content does not suffice.
    #[must_use]
    pub fn of(bytes: &[u8], path: &Path) -> Self {
        if Octomap::is_file(bytes) {
            return Self::Octomap;
        }
        if is_cloud(bytes) {
            return Self::Cloud;
        }
        let extension = path.extension().and_then(OsStr::to_str).unwrap_or_default().to_lowercase();
        match extension.as_str() {
            "bt" | "ot" => Self::Octomap,
            "pcd" | "ply" => Self::Cloud,
            "scene" => Self::SceneText,
            "yaml" | "yml" | "json" => Self::Yaml,
            _ if std::str::from_utf8(bytes).is_ok_and(SceneLoader::is_scene_text) => Self::SceneText,
            _ => Self::Yaml,
        }
    }
}

impl SceneLoader {
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
}
