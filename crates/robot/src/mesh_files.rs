//! Resolves mesh names to files, and decides which files may be opened.
//!
//! A name is searched only in the roots: folders given by the user (`--package-path`, the URDF's folder) or by the ROS environment. The
//! text that contains the name is not trusted:
//!
//! 1. `.` and `..` are resolved by name, before any file access. A result outside of every root is rejected.
//! 2. Inside a root, symbolic links may lead anywhere except into `/proc`, `/sys` and `/dev`: they were created by users with write
//!    access to the root. `colcon build --symlink-install` fills install folders with links into source folders.
//! 3. In a package found beside or above the URDF, links must stay in that package or in a root, unless it is the URDF's own
//!    package: a folder above the URDF with a `package.xml`.
//! 4. Only regular files are read (`input_files`).

use std::ffi::OsStr;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use clearance_files::input_files::{self, InputFileError};

use super::decimal_numbers::shortened;
use super::mesh_file_error::MeshFileError;
use super::mesh_log::MeshLog;
use super::mesh_name::{self, MeshName};
use super::recorded_meshes::RecordedMeshes;

/// Folders into which no symbolic link is followed: their files are not regular files on a disk.
const SYSTEM_FOLDERS: [&str; 3] = ["/proc", "/sys", "/dev"];

/// Folders from which meshes may be read. Nothing outside these folders is ever opened, except by symbolic links as the module
/// documentation describes.
#[derive(Clone, Debug, Default)]
pub struct MeshFiles {
    /// Names without a scheme are relative to this folder.
    folder: Option<Root>,
    /// Searches for `NAME` of `package://NAME` in this folder and its parents.
    beside: Option<Root>,
    package_paths: Vec<Root>,
    ament_prefixes: Vec<Root>,
    ros_package_paths: Vec<Root>,
    embedded: &'static [(&'static str, &'static [u8])],
    /// If present, meshes are searched nowhere else.
    recorded: Option<Arc<RecordedMeshes>>,
    log: Option<MeshLog>,
}

/// A mesh file that may be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Found {
    File(FoundFile),
    Embedded(&'static str, &'static [u8]),
    /// Content from a recording.
    Recorded(PathBuf, Arc<[u8]>),
}

/// A file on the disk that may be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FoundFile {
    /// Its real path: symbolic links resolved.
    pub real: PathBuf,
    /// The path by which it was found: file names inside the file are relative to this path's folder.
    named: PathBuf,
    package: Option<Package>,
}

/// A folder whose files may always be opened.
#[derive(Clone, Debug)]
struct Root {
    /// As given by the user, made absolute: absolute mesh names may start with it.
    spelled: PathBuf,
    real: PathBuf,
}

/// A package beside or above the URDF.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Package {
    folder: PathBuf,
    /// True if it contains the URDF.
    is_own: bool,
}

/// A candidate for a mesh file.
struct Candidate {
    file: PathBuf,
    /// A folder whose files may be opened for this name, in addition to the roots.
    package: Option<Package>,
}

/// Reason why a candidate is rejected.
enum Miss {
    Missing,
    Outside(PathBuf),
    System(PathBuf),
}

/// Checks that a folder for [`MeshFiles::with_package_path`] can be searched: a misspelled one would find nothing, in silence.
///
/// # Errors
/// If it is not a folder, with the reason.
pub fn check_package_path(dir: &Path) -> Result<(), String> {
    match dir.metadata() {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(_) => Err(format!("'{}' is not a folder", dir.display())),
        Err(error) => Err(format!("'{}' is not a folder that can be searched: {error}", dir.display())),
    }
}

impl MeshFiles {
    /// Searches for meshes in packages in `dir`, and for names relative to `dir`.
    #[must_use]
    pub fn under(dir: impl Into<PathBuf>) -> Self {
        let dir = dir.into();
        Self::default().with_folder(&dir).with_package_path(dir)
    }

    /// Meshes compiled into the program, by name without `package://`, as in `demo/arm.stl`.
    #[must_use]
    pub fn embedded(meshes: &'static [(&'static str, &'static [u8])]) -> Self {
        Self { embedded: meshes, ..Self::default() }
    }

    /// Meshes of a recording; no other meshes are found.
    #[must_use]
    pub fn recorded(meshes: Arc<RecordedMeshes>) -> Self {
        Self { recorded: Some(meshes), ..Self::default() }
    }

    /// Records the found files in `log`.
    #[must_use]
    pub fn with_log(self, log: MeshLog) -> Self {
        Self { log: Some(log), ..self }
    }

    /// Resolves `package://NAME/path` to `dir/NAME/path`, before all other locations.
    #[must_use]
    pub fn with_package_path(mut self, dir: impl Into<PathBuf>) -> Self {
        self.package_paths.push(Root::new(&dir.into()));
        self
    }

    /// Names without a scheme are relative to `dir`.
    #[must_use]
    pub fn with_folder(mut self, dir: impl Into<PathBuf>) -> Self {
        self.folder = Some(Root::new(&dir.into()));
        self
    }

    /// As [`Self::with_folder`], and also searches for packages in `dir` and all its parents.
    #[must_use]
    pub fn beside_urdf(mut self, dir: &Path) -> Self {
        self.beside = Some(Root::new(dir));
        self.with_folder(dir)
    }

    /// Also searches the folders in the environment variables `AMENT_PREFIX_PATH` and `ROS_PACKAGE_PATH`.
    #[must_use]
    pub fn with_environment(self) -> Self {
        let value = |name| std::env::var_os(name).unwrap_or_default();
        self.with_ros_paths(&value("AMENT_PREFIX_PATH"), &value("ROS_PACKAGE_PATH"))
    }

    /// Also searches `PREFIX/share/NAME` of each ament prefix, and `DIR/NAME` of each package path, or DIR itself if it has the package's
    /// name. Folders are separated as in the system's `PATH`.
    #[must_use]
    pub fn with_ros_paths(mut self, ament_prefix_path: &OsStr, ros_package_path: &OsStr) -> Self {
        let folders = |paths| {
            let named = std::env::split_paths(paths).filter(|p| !p.as_os_str().is_empty());
            named.map(|p| Root::new(&p)).collect::<Vec<_>>()
        };
        self.ament_prefixes.extend(folders(ament_prefix_path));
        self.ros_package_paths.extend(folders(ros_package_path));
        self
    }

    /// The file that `uri` names, if it exists and may be opened.
    ///
    /// # Errors
    /// If the name is invalid, or the file is missing or outside the allowed folders.
    pub(super) fn find(&self, uri: &str) -> Result<Found, MeshFileError> {
        if let Some(embedded) = self.find_embedded(uri) {
            return Ok(embedded);
        }
        let folder = self.folder.as_ref().map(|root| root.real.as_path());
        if let Some(recorded) = &self.recorded {
            return found_in_recording(recorded, folder, uri);
        }
        let file = self.find_file(uri, self.candidates(&mesh_name::parse(uri)?))?;
        if let Some(log) = &self.log {
            log.note(folder, uri, &file.real);
        }
        Ok(Found::File(file))
    }

    fn find_embedded(&self, uri: &str) -> Option<Found> {
        if self.embedded.is_empty() {
            return None;
        }
        let path = match mesh_name::parse(uri).ok()? {
            MeshName::Package { name, path } => Path::new(&name).join(path),
            MeshName::Relative(path) => path,
            MeshName::Absolute(_) => return None,
        };
        let mut embedded = self.embedded.iter();
        embedded.find(|(name, _)| Path::new(name) == path).map(|(name, bytes)| Found::Embedded(name, bytes))
    }

    /// A file named inside a mesh file, such as a buffer of a glTF: only from the mesh file's own folder and its subfolders.
    ///
    /// # Errors
    /// As for [`Self::find`].
    pub(super) fn find_part(&self, mesh: &Found, uri: &str) -> Result<Found, MeshFileError> {
        let bad = |reason: &str| MeshFileError::BadName { uri: shortened(uri), reason: reason.to_owned() };
        let MeshName::Relative(path) = mesh_name::parse(uri)? else {
            return Err(bad("is named by a mesh file, which may name only files in its own folder"));
        };
        if path.components().any(|c| c == Component::ParentDir) {
            return Err(bad("climbs out of the mesh file's folder with '..'"));
        }
        match mesh {
            Found::Embedded(..) => Err(bad("is named by a mesh that is compiled in, which has no folder")),
            // the mesh file replaces the folder
            Found::Recorded(file, _) => match &self.recorded {
                Some(recorded) => found_in_recording(recorded, Some(file), uri),
                None => Err(MeshFileError::NotRecorded { uri: shortened(uri) }),
            },
            Found::File(file) => {
                let folder = file.named.parent().unwrap_or(&file.named);
                let part = Candidate { file: folder.join(path), package: file.package.clone() };
                let part = self.find_file(uri, vec![part])?;
                if let Some(log) = &self.log {
                    log.note(Some(&file.real), uri, &part.real);
                }
                Ok(Found::File(part))
            }
        }
    }

    fn find_file(&self, uri: &str, candidates: Vec<Candidate>) -> Result<FoundFile, MeshFileError> {
        let (mut tried, mut similar, mut refused) = (Vec::new(), None, None);
        for candidate in candidates {
            match self.look_at(&candidate) {
                Ok(found) => return Ok(found),
                Err(Miss::Missing) => {
                    similar = similar.or_else(|| self.differing_in_case(&candidate));
                    tried.push(candidate.file.display().to_string());
                }
                Err(miss) => refused = Some(miss),
            }
        }
        let uri = shortened(uri);
        Err(match refused {
            Some(Miss::System(file)) => MeshFileError::SystemFile { uri, file },
            Some(Miss::Outside(file)) => {
                let allowed = listed(self.roots().map(|r| r.real.display().to_string()).collect());
                MeshFileError::Outside { uri, file, allowed }
            }
            Some(Miss::Missing) | None => {
                let tried = listed(tried.iter().map(|t| shortened(t)).collect());
                MeshFileError::NotFound { uri, tried, similar }
            }
        })
    }

    /// The candidate's file if it exists and may be opened; nothing outside the allowed folders is accessed.
    fn look_at(&self, candidate: &Candidate) -> Result<FoundFile, Miss> {
        let Candidate { file, package } = candidate;
        let outside = || Miss::Outside(file.clone());
        let named = mesh_name::resolved(file).ok_or_else(outside)?;
        let is_in_root = self.is_in_root(&named);
        let in_package = |path: &Path| package.as_ref().is_some_and(|p| path.starts_with(&p.folder));
        if !is_in_root && !in_package(&named) {
            return Err(outside());
        }
        let real = named.canonicalize().map_err(|_| Miss::Missing)?;
        let real_package = package.as_ref().and_then(|p| p.folder.canonicalize().ok());
        let stays = self.is_in_root(&real) || real_package.is_some_and(|folder| real.starts_with(folder));
        let may_leave = is_in_root || package.as_ref().is_some_and(|p| p.is_own);
        if !stays && SYSTEM_FOLDERS.iter().any(|folder| real.starts_with(folder)) {
            return Err(Miss::System(real));
        }
        if stays || may_leave {
            Ok(FoundFile { real, named, package: package.clone() })
        } else {
            Err(Miss::Outside(real))
        }
    }

    /// Folders whose files may always be opened.
    fn roots(&self) -> impl Iterator<Item = &Root> {
        (self.folder.iter())
            .chain(&self.package_paths)
            .chain(&self.ament_prefixes)
            .chain(&self.ros_package_paths)
    }

    fn is_in_root(&self, path: &Path) -> bool {
        self.roots().any(|root| path.starts_with(&root.real) || path.starts_with(&root.spelled))
    }

    /// An allowed file whose path below the root or package differs in upper and lower case only.
    fn differing_in_case(&self, candidate: &Candidate) -> Option<PathBuf> {
        let named = mesh_name::resolved(&candidate.file)?;
        let roots = self.roots().flat_map(|root| [&root.real, &root.spelled]);
        let bases = roots.chain(candidate.package.as_ref().map(|p| &p.folder));
        let base = bases.filter(|base| named.starts_with(base)).min_by_key(|base| base.as_os_str().len())?;
        let rest: Vec<&OsStr> = named.strip_prefix(base).ok()?.iter().collect();
        let file = other_case(base, &rest)?;
        let package = candidate.package.clone();
        self.look_at(&Candidate { file: file.clone(), package }).ok().map(|_| file)
    }

    /// True if any folder of this package exists.
    pub(super) fn has_package(&self, name: &str) -> bool {
        let folder = MeshName::Package { name: name.to_owned(), path: PathBuf::new() };
        self.candidates(&folder).iter().any(|candidate| candidate.file.is_dir())
    }

    fn candidates(&self, name: &MeshName) -> Vec<Candidate> {
        let plain = |file: PathBuf| Candidate { file, package: None };
        match name {
            MeshName::Absolute(path) => vec![plain(path.clone())],
            MeshName::Relative(path) => {
                (self.folder.iter()).map(|folder| plain(folder.real.join(path))).collect()
            }
            MeshName::Package { name, path } => {
                let given = (self.package_paths.iter()).map(|root| plain(root.real.join(name).join(path)));
                let beside = (self.beside.iter())
                    .flat_map(|b| b.real.ancestors().map(move |dir| (b, dir.join(name))))
                    .map(|(b, folder)| Candidate {
                        file: folder.join(path),
                        package: Some(Package::new(folder, b)),
                    });
                let ament = (self.ament_prefixes.iter())
                    .map(|root| plain(root.real.join("share").join(name).join(path)));
                let ros = (self.ros_package_paths.iter()).map(|root| {
                    let dir = &root.real;
                    let is_package =
                        [dir, &root.spelled].iter().any(|d| d.file_name() == Some(OsStr::new(name)));
                    let package = if is_package { dir.clone() } else { dir.join(name) };
                    plain(package.join(path))
                });
                given.chain(beside).chain(ament).chain(ros).collect()
            }
        }
    }
}

impl Root {
    /// The real path; for a missing folder its absolute name. The parent of a bare file name is an empty path: the working directory.
    fn new(folder: &Path) -> Self {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        let spelled = mesh_name::resolved(&absolute).unwrap_or_else(|| absolute.clone());
        let real = folder.canonicalize().unwrap_or(absolute);
        Self { spelled, real }
    }
}

impl Package {
    fn new(folder: PathBuf, urdf_folder: &Root) -> Self {
        let is_own = urdf_folder.real.starts_with(&folder) && folder.join("package.xml").is_file();
        Self { folder, is_own }
    }
}

impl Found {
    /// The real path; for a missing file its name.
    pub fn path(&self) -> &Path {
        match self {
            Self::File(file) => &file.real,
            Self::Embedded(name, _) => Path::new(name),
            Self::Recorded(file, _) => file,
        }
    }

    pub fn read(&self, limit: u64) -> Result<Vec<u8>, InputFileError> {
        match self {
            Self::File(file) => input_files::read(&file.real, limit),
            Self::Embedded(_, bytes) => Ok(bytes.to_vec()),
            Self::Recorded(_, bytes) => Ok(bytes.to_vec()),
        }
    }

    /// Files with the same key and content are the same mesh.
    pub fn key(&self) -> (PathBuf, PathBuf) {
        match self {
            Self::File(file) => (file.real.clone(), file.named.parent().unwrap_or(&file.named).to_owned()),
            Self::Embedded(name, _) => (PathBuf::from(name), PathBuf::new()),
            Self::Recorded(file, _) => (file.clone(), PathBuf::new()),
        }
    }
}

fn found_in_recording(
    recorded: &RecordedMeshes,
    folder: Option<&Path>,
    uri: &str,
) -> Result<Found, MeshFileError> {
    let found = recorded.find(folder, uri);
    let (file, bytes) = found.ok_or_else(|| MeshFileError::NotRecorded { uri: shortened(uri) })?;
    Ok(Found::Recorded(file.clone(), Arc::clone(bytes)))
}

/// The first path under `base` whose components equal `rest`, ignoring upper and lower case.
fn other_case(base: &Path, rest: &[&OsStr]) -> Option<PathBuf> {
    let Some((first, rest)) = rest.split_first() else { return Some(base.to_owned()) };
    let wanted = first.to_str()?.to_lowercase();
    let mut names = input_files::names_in(base);
    names.retain(|name| name.to_lowercase() == wanted);
    names.sort_unstable();
    names.iter().find_map(|name| other_case(&base.join(name), rest))
}

fn listed(mut names: Vec<String>) -> String {
    names.dedup();
    if names.is_empty() { "no folder at all: none is known".to_owned() } else { names.join(", ") }
}

#[cfg(test)]
mod tests;
