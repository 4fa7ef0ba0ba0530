//! Log of mesh names and the files that they were resolved to, for recordings.

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
