//! Content of a recording other than messages: attached files, the node's command line, and the version.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use clearance_robot::{MeshFiles, MeshUse, RecordedMeshes};
use serde_json::Value as Json;

use crate::recording::mcap_file::{Entry, ReadError, RecordingFile};
use crate::recording::step::RecordStep;

/// The parts of a recording beside its messages: files, and the node's command line.
#[derive(Debug)]
pub struct Archive {
    files: HashMap<String, Arc<[u8]>>,
    meshes: Arc<RecordedMeshes>,
    /// Command-line inputs of the node.
    pub given: Json,
    /// Version of the program that recorded it.
    pub version: String,
}

impl Archive {
    /// Reads everything but the messages.
    ///
    /// # Errors
    /// When the file cannot be read, or does not hold exactly one run of a node.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let mut file = RecordingFile::open(path)?;
        let (mut files, mut uses, mut started) = (HashMap::new(), Vec::new(), None);
        while let Some(entry) = file.next()? {
            match entry {
                Entry::Attachment { name, data } => drop(files.insert(name, Arc::<[u8]>::from(data))),
                Entry::RecordStep { step, itself, .. } => match *step {
                    RecordStep::Mesh { folder, uri, file } => uses.push(MeshUse { folder, uri, file }),
                    RecordStep::Started { node, .. } if started.is_some() => {
                        return Err(file.error(format!(
                            "holds a second run (of {node}, from {} on): split the file there, and replay each \
                             part",
                            itself.time()
                        )));
                    }
                    RecordStep::Started { version, given, .. } => started = Some((version, given)),
                    _ => {}
                },
            }
        }
        let (version, given) =
            started.ok_or_else(|| file.error("holds no beginning of a recording by clearance"))?;
        let mut meshes = RecordedMeshes::default();
        for found in uses {
            let name = found.file.display().to_string();
            if let Some(bytes) = files.get(&name) {
                meshes.insert(found, Arc::clone(bytes));
            }
        }
        Ok(Self { files, meshes: Arc::new(meshes), given, version })
    }

    /// Returns an attached file.
    ///
    /// # Errors
    /// When there is no file with this name.
    pub fn file(&self, path: &Path) -> Result<Arc<[u8]>, String> {
        let name = path.display().to_string();
        self.files.get(&name).cloned().ok_or_else(|| format!("{name}: is not in the recording"))
    }

    /// The mesh files of the recording.
    #[must_use]
    pub fn meshes(&self) -> MeshFiles {
        MeshFiles::recorded(Arc::clone(&self.meshes))
    }
}
