//! Meshes that are read from a recording instead of files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::mesh_log::MeshUse;

/// Meshes of a recording. With them, no file is ever opened.
#[derive(Clone, Debug, Default)]
pub struct RecordedMeshes(HashMap<(Option<PathBuf>, String), RecordedMesh>);

/// A file with its real path and its content.
pub(super) type RecordedMesh = (PathBuf, Arc<[u8]>);

impl RecordedMeshes {
    /// Adds a mesh and the content of its file.
    pub fn insert(&mut self, found: MeshUse, bytes: Arc<[u8]>) {
        self.0.insert((found.folder, found.uri), (found.file, bytes));
    }

    pub(super) fn find(&self, folder: Option<&Path>, uri: &str) -> Option<&RecordedMesh> {
        self.0.get(&(folder.map(Path::to_owned), uri.to_owned()))
    }
}
