//! Errors of mesh look-up.

use std::path::{Path, PathBuf};

/// Errors of mesh look-up.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum MeshFileError {
    #[error("mesh '{uri}' {reason}")]
    BadName { uri: String, reason: String },
    #[error("mesh '{uri}' was not found; looked for {tried}; {}", advice(similar.as_deref()))]
    NotFound {
        uri: String,
        tried: String,
        /// An existing file whose name differs in upper and lower case only.
        similar: Option<PathBuf>,
    },
    #[error("mesh '{uri}' is not in the recording: it ends before its meshes, or was altered")]
    NotRecorded { uri: String },
    #[error(
        "mesh '{uri}' is {}, outside every folder that may be opened ({allowed}); allow its folder with --package-path",
        file.display()
    )]
    Outside { uri: String, file: PathBuf, allowed: String },
    #[error("mesh '{uri}' leads by symbolic links to {}; none is followed into /proc, /sys or /dev", file.display())]
    SystemFile { uri: String, file: PathBuf },
    #[error("mesh {}: {reason}", file.display())]
    Unusable { file: PathBuf, reason: String },
}

fn advice(similar: Option<&Path>) -> String {
    match similar {
        Some(file) => format!("{} is there: upper and lower case count", file.display()),
        None => "give the folder that holds it with --package-path DIR".to_owned(),
    }
}
