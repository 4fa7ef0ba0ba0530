//! Kind of a world file, recognised by its content or its name.

use std::ffi::OsStr;
use std::path::Path;

use super::scene_loader::SceneLoader;
use crate::{Octomap, is_cloud};

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
