//! Log of resolved mesh names for recordings, and meshes read from a recording instead of files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A mesh name and the file that it was resolved to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshUse {
    /// Base of names without a scheme: a folder, or the mesh file that names the part.
    pub folder: Option<PathBuf>,
    /// The mesh name in the URDF or scene.
    pub uri: String,
    /// The file, with its real path.
    pub file: PathBuf,
}

/// Records every found mesh. Copies share one list.
#[derive(Clone, Debug, Default)]
pub struct MeshLog(Arc<Mutex<Vec<MeshUse>>>);

impl MeshLog {
    /// Meshes found since the last call.
    #[must_use]
    pub fn take(&self) -> Vec<MeshUse> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub(super) fn note(&self, folder: Option<&Path>, uri: &str, file: &Path) {
        let found =
            MeshUse { folder: folder.map(Path::to_owned), uri: uri.to_owned(), file: file.to_owned() };
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(found);
    }
}

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
