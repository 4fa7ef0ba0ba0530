//! Mesh names to files, and the walls around them.
//!
//! A name is looked up only in folders the user gave or the ROS environment names, and a file is opened only when it
//! really lies in one of them, symbolic links resolved. One exception: `colcon build --symlink-install` fills the
//! install folders of `AMENT_PREFIX_PATH` with links into the source folders, so links found there may lead out.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::mesh_log::{MeshLog, RecordedMeshes};
use super::mesh_uri::{self, MeshName};
use super::numbers::shortened;

/// Where meshes may be read from. Nothing outside these folders is ever opened.
#[derive(Clone, Debug, Default)]
pub struct MeshFiles {
    /// Names without a scheme are relative to this folder.
    folder: Option<PathBuf>,
    /// Look for `NAME` of `package://NAME` in this folder and its parents.
    beside: Option<PathBuf>,
    package_paths: Vec<PathBuf>,
    ament_prefixes: Vec<PathBuf>,
    ros_package_paths: Vec<PathBuf>,
    embedded: &'static [(&'static str, &'static [u8])],
    /// With these, nothing is looked up elsewhere.
    recorded: Option<Arc<RecordedMeshes>>,
    log: Option<MeshLog>,
}

/// Why a mesh name gave no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshFileError {
    #[error("mesh '{uri}' {reason}")]
    BadName { uri: String, reason: String },
    #[error(
        "mesh '{uri}' was not found; looked for {tried}; give the folder that holds it with --package-path DIR"
    )]
    NotFound { uri: String, tried: String },
    #[error("mesh '{uri}' is not in the recording: it ends before its meshes, or was altered")]
    NotRecorded { uri: String },
    #[error(
        "mesh '{uri}' is {}, outside every folder that may be opened ({allowed}); allow its folder with --package-path",
        file.display()
    )]
    Outside { uri: String, file: PathBuf, allowed: String },
    #[error("mesh {}: {reason}", file.display())]
    Unusable { file: PathBuf, reason: String },
}

/// A mesh file that may be opened.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Found {
    /// By its real path.
    File(PathBuf),
    Embedded(&'static str, &'static [u8]),
    /// Out of a recording.
    Recorded(PathBuf, Arc<[u8]>),
}

/// A file that may hold a mesh, and why it may be opened.
struct Candidate {
    file: PathBuf,
    /// Links under this folder may lead anywhere.
    trusted_links: bool,
    /// A folder whose files may be opened for this name, beside those that always may.
    root: Option<PathBuf>,
}

impl MeshFiles {
    /// Meshes of packages that lie in `dir`, and of names relative to `dir`.
    #[must_use]
    pub fn under(dir: impl Into<PathBuf>) -> Self {
        let dir = dir.into();
        Self::default().with_folder(&dir).with_package_path(dir)
    }

    /// Meshes compiled into the program, by name: `package://` left out, as in `demo/arm.stl`.
    #[must_use]
    pub fn embedded(meshes: &'static [(&'static str, &'static [u8])]) -> Self {
        Self { embedded: meshes, ..Self::default() }
    }

    /// Meshes of a recording: nothing else is found.
    #[must_use]
    pub fn recorded(meshes: Arc<RecordedMeshes>) -> Self {
        Self { recorded: Some(meshes), ..Self::default() }
    }

    /// Notes in `log` which files are found.
    #[must_use]
    pub fn noted_in(self, log: MeshLog) -> Self {
        Self { log: Some(log), ..self }
    }

    /// Looks up `package://NAME/path` as `dir/NAME/path`, before everything else.
    #[must_use]
    pub fn with_package_path(mut self, dir: impl Into<PathBuf>) -> Self {
        self.package_paths.push(anchored(&dir.into()));
        self
    }

    /// Names without a scheme are relative to `dir`.
    #[must_use]
    pub fn with_folder(mut self, dir: impl Into<PathBuf>) -> Self {
        self.folder = Some(anchored(&dir.into()));
        self
    }

    /// As [`Self::with_folder`], and packages are looked for in `dir` and all its parents.
    #[must_use]
    pub fn beside_urdf(mut self, dir: &Path) -> Self {
        self.beside = Some(anchored(dir));
        self.with_folder(dir)
    }

    /// Looks also where `AMENT_PREFIX_PATH` and `ROS_PACKAGE_PATH` of the environment say.
    #[must_use]
    pub fn with_environment(self) -> Self {
        let value = |name| std::env::var_os(name).unwrap_or_default();
        self.with_ros_paths(&value("AMENT_PREFIX_PATH"), &value("ROS_PACKAGE_PATH"))
    }

    /// Looks also in `PREFIX/share/NAME` of each ament prefix, and in `DIR/NAME` of each package path, or in DIR itself
    /// if it bears the package's name. Folders are separated as the system separates those of `PATH`.
    #[must_use]
    pub fn with_ros_paths(mut self, ament_prefix_path: &OsStr, ros_package_path: &OsStr) -> Self {
        let folders = |paths| {
            let named = std::env::split_paths(paths).filter(|p| !p.as_os_str().is_empty());
            named.map(|p| anchored(&p)).collect::<Vec<_>>()
        };
        self.ament_prefixes.extend(folders(ament_prefix_path));
        self.ros_package_paths.extend(folders(ros_package_path));
        self
    }

    /// The file that `uri` names, if it is there and may be opened.
    ///
    /// # Errors
    /// When the name is no name, or the file is missing or outside the allowed folders.
    pub(super) fn find(&self, uri: &str) -> Result<Found, MeshFileError> {
        let plain = uri.strip_prefix("package://").unwrap_or(uri);
        if let Some((name, bytes)) = self.embedded.iter().find(|(name, _)| *name == plain) {
            return Ok(Found::Embedded(name, bytes));
        }
        let folder = self.folder.as_deref();
        if let Some(recorded) = &self.recorded {
            let found = recorded.find(folder, uri);
            let (file, bytes) = found.ok_or_else(|| MeshFileError::NotRecorded { uri: shortened(uri) })?;
            return Ok(Found::Recorded(file.clone(), Arc::clone(bytes)));
        }
        let file = self.find_file(uri)?;
        if let Some(log) = &self.log {
            log.note(folder, uri, &file);
        }
        Ok(Found::File(file))
    }

    fn find_file(&self, uri: &str) -> Result<PathBuf, MeshFileError> {
        let candidates = self.candidates(&mesh_uri::parse(uri)?);
        let mut tried = Vec::new();
        let mut outside = None;
        for candidate in candidates {
            // by name first: nothing outside is even looked at
            if !self.allows(&candidate.file, candidate.root.as_deref()) {
                outside = Some(candidate.file);
                continue;
            }
            match candidate.file.canonicalize() {
                Ok(real) => {
                    let root = candidate.root.and_then(|r| r.canonicalize().ok());
                    if candidate.trusted_links || self.allows(&real, root.as_deref()) {
                        return Ok(real);
                    }
                    outside = Some(real);
                }
                Err(_) => tried.push(candidate.file.display().to_string()),
            }
        }
        let uri = shortened(uri);
        if let Some(file) = outside {
            let allowed = listed(self.roots().map(|r| r.display().to_string()).collect());
            return Err(MeshFileError::Outside { uri, file, allowed });
        }
        Err(MeshFileError::NotFound { uri, tried: listed(tried.iter().map(|t| shortened(t)).collect()) })
    }

    /// Folders whose files may always be opened.
    fn roots(&self) -> impl Iterator<Item = &Path> {
        (self.folder.iter())
            .chain(&self.package_paths)
            .chain(&self.ament_prefixes)
            .chain(&self.ros_package_paths)
            .map(PathBuf::as_path)
    }

    /// Whether `file` lies, by its name, in `root` or in a folder whose files may always be opened.
    fn allows(&self, file: &Path, root: Option<&Path>) -> bool {
        let Some(file) = mesh_uri::resolved(file) else {
            return false;
        };
        root.into_iter().chain(self.roots()).any(|r| file.starts_with(r))
    }

    fn candidates(&self, name: &MeshName) -> Vec<Candidate> {
        let plain = |file: PathBuf| Candidate { file, trusted_links: false, root: None };
        match name {
            MeshName::Absolute(path) => vec![plain(path.clone())],
            MeshName::Relative(path) => (self.folder.iter()).map(|folder| plain(folder.join(path))).collect(),
            MeshName::Package { name, path } => {
                let given = (self.package_paths.iter()).map(|dir| plain(dir.join(name).join(path)));
                let beside = (self.beside.iter().flat_map(|b| b.ancestors()))
                    .map(|dir| Candidate { root: Some(dir.join(name)), ..plain(dir.join(name).join(path)) });
                let ament = (self.ament_prefixes.iter()).map(|prefix| Candidate {
                    trusted_links: true,
                    ..plain(prefix.join("share").join(name).join(path))
                });
                let ros = (self.ros_package_paths.iter()).map(|dir| {
                    let is_package = dir.file_name() == Some(OsStr::new(name));
                    let package = if is_package { dir.clone() } else { dir.join(name) };
                    plain(package.join(path))
                });
                given.chain(beside).chain(ament).chain(ros).collect()
            }
        }
    }
}

/// The folder's real path; one that is not there keeps its name, made absolute.
fn anchored(folder: &Path) -> PathBuf {
    let absolute = || std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    folder.canonicalize().unwrap_or_else(|_| absolute())
}

fn listed(mut names: Vec<String>) -> String {
    names.dedup();
    if names.is_empty() { "no folder at all: none is known".to_owned() } else { names.join(", ") }
}

#[cfg(test)]
mod tests;
