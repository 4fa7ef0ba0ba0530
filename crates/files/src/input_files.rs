//! Bounded reading of input files, and writing of result files. Every file that a command, the node or the library
//! opens is opened here.
//!
//! Guarantees: opening never blocks; only regular files are opened (no FIFO, device, socket or directory); no more than
//! the limit is read, whatever the size in the file's metadata is (`/proc` files have size 0, other files grow).
//!
//! Results are written here too, to new or regular files only, without blocking.

use std::fs::{File, FileType, Metadata};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// URDF, SRDF and parameter files (bytes).
pub const DESCRIPTION_LIMIT: u64 = 64 << 20;
/// States, edges, trajectories and certificates (bytes).
pub const STATES_LIMIT: u64 = 256 << 20;
/// Mesh files and their buffers (bytes): ten million triangles of binary STL.
pub const MESH_LIMIT: u64 = 512 << 20;
/// World files: scenes, point clouds and octrees (bytes).
pub const WORLD_LIMIT: u64 = 1 << 30;

/// Longest path (characters) in a message.
const LONGEST_SHOWN_PATH: usize = 300;

/// Most names that [`names_in`] returns.
const MOST_NAMES: usize = 100_000;

/// Names that are tried for a new file beside another one.
const MOST_PARTS: u32 = 100;

/// Links that are followed to a file that does not exist yet.
const MOST_LINKS: u32 = 40;

/// Reason why a file is not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", shown(file))]
pub struct InputFileError {
    /// Path of the file.
    pub file: PathBuf,
    /// A clause without the path, such as `is a directory, not a regular file`.
    pub reason: String,
}

/// All bytes of a regular file of at most `limit` bytes.
///
/// # Errors
/// When the file is missing, unreadable, no regular file, or larger than `limit`.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>, InputFileError> {
    let fault = |reason| InputFileError { file: path.to_owned(), reason };
    read_bounded(path, limit).map_err(fault)
}

/// As [`read`], for UTF-8 text.
///
/// # Errors
/// As for [`read`], and when the file is compressed or no UTF-8 text.
pub fn read_text(path: &Path, limit: u64) -> Result<String, InputFileError> {
    let fault = |reason| InputFileError { file: path.to_owned(), reason };
    let bytes = read(path, limit)?;
    if bytes.starts_with(b"\x1f\x8b") {
        return Err(fault("is compressed with gzip; unpack it".to_owned()));
    }
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        fault(format!("is no UTF-8 text: byte {at} belongs to another encoding"))
    })
}

/// Opens a regular file for streaming. The caller limits the amount of data it keeps.
///
/// # Errors
/// When the file is missing, unreadable or no regular file.
pub fn open(path: &Path) -> Result<File, InputFileError> {
    let fault = |reason| InputFileError { file: path.to_owned(), reason };
    open_regular(path).map(|(file, _)| file).map_err(fault)
}

/// Writes a file, and replaces an existing one.
///
/// # Errors
/// When there is something else than a regular file, or the file can not be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), InputFileError> {
    let fault = |reason| InputFileError { file: path.to_owned(), reason };
    let unwritable = |error: io::Error| fault(format!("cannot be written: {error}"));
    check_target(path)?;
    let mut file = create_without_blocking(path).map_err(unwritable)?;
    only_regular(&file.metadata().map_err(unwritable)?, OUTPUT_HINT).map_err(fault)?;
    // truncated only after it is known to be a regular file
    file.set_len(0).and_then(|()| file.write_all(bytes)).map_err(unwritable)
}

/// As [`write()`], so that an existing file is complete at every moment: the bytes are written to a file beside it, which then takes its
/// place.
///
/// # Errors
/// When there is something else than a regular file, or the file can not be written.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), InputFileError> {
    check_target(path)?;
    let target = target_of(path);
    let fault = |error: io::Error| InputFileError {
        file: path.to_owned(),
        reason: format!("cannot be written: {error}"),
    };
    let (beside, mut file) = new_file_beside(&target).map_err(fault)?;
    let mut moved = || {
        file.write_all(bytes)?;
        if let Ok(metadata) = target.metadata() {
            std::fs::set_permissions(&beside, metadata.permissions())?;
        }
        file.sync_all()?;
        std::fs::rename(&beside, &target)
    };
    moved().map_err(|error| {
        let _ = std::fs::remove_file(&beside);
        fault(error)
    })
}

/// The file that a link points to, also where it does not exist yet; the path itself if it is no link. [`replace`] writes there.
#[must_use]
pub fn target_of(path: &Path) -> PathBuf {
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        if let Ok(real) = target.canonicalize() {
            return real;
        }
        let Ok(next) = target.read_link() else { return target };
        target = target.parent().unwrap_or(Path::new("")).join(next);
    }
    target
}

/// A new file in the folder of another one. No file or link that is there is opened.
fn new_file_beside(target: &Path) -> io::Result<(PathBuf, File)> {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let process = std::process::id();
    let mut result = Err(io::Error::from(io::ErrorKind::AlreadyExists));
    for number in 0..MOST_PARTS {
        let beside = target.with_file_name(format!(".{name}.{process}-{number}.part"));
        match File::create_new(&beside) {
            Ok(file) => return Ok((beside, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => result = Err(error),
            Err(error) => return Err(error),
        }
    }
    result
}

/// Checks that a file may be written there: nothing exists, or a regular file.
///
/// # Errors
/// When something else stands there, such as a folder or a FIFO, and for `-`, which users give for standard output.
pub fn check_target(path: &Path) -> Result<(), InputFileError> {
    let fault = |reason| InputFileError { file: path.to_owned(), reason };
    if path.as_os_str() == "-" {
        return Err(fault("is not standard output here; give a file (./- for one of that name)".to_owned()));
    }
    path.metadata().map_or(Ok(()), |metadata| only_regular(&metadata, OUTPUT_HINT).map_err(fault))
}

/// Names in a folder, in no order; none when it cannot be listed.
#[must_use]
pub fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.take(MOST_NAMES).filter_map(|entry| entry.file_name().into_string().ok()).collect()
}

fn read_bounded(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    let (file, metadata) = open_regular(path)?;
    let size = metadata.len();
    let too_large = |size: &str| format!("has {size} bytes, more than the limit of {}", in_units(limit));
    if size > limit {
        return Err(too_large(&size.to_string()));
    }
    let mut bytes = Vec::new();
    let expected = usize::try_from(size).map_err(|_| too_large(&size.to_string()))?;
    bytes.try_reserve_exact(expected.saturating_add(1)).map_err(|e| format!("cannot be read: {e}"))?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(too_large(&format!("at least {}", bytes.len())));
    }
    Ok(bytes)
}

/// Checked before it is opened, since opening some devices has effects, and again once it is open.
fn open_regular(path: &Path) -> Result<(File, Metadata), String> {
    only_regular(&path.metadata().map_err(unreadable)?, INPUT_HINT)?;
    let file = open_without_blocking(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    only_regular(&metadata, INPUT_HINT)?;
    Ok((file, metadata))
}

#[cfg(unix)]
fn open_without_blocking(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    std::fs::OpenOptions::new().read(true).custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY).open(path)
}

#[cfg(not(unix))]
fn open_without_blocking(path: &Path) -> io::Result<File> {
    File::open(path)
}

#[cfg(unix)]
fn create_without_blocking(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create(true).truncate(false);
    options.custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY).open(path)
}

#[cfg(not(unix))]
fn create_without_blocking(path: &Path) -> io::Result<File> {
    std::fs::OpenOptions::new().write(true).create(true).truncate(false).open(path)
}

#[allow(clippy::needless_pass_by_value)] // for map_err
fn unreadable(error: io::Error) -> String {
    format!("cannot be read: {error}")
}

const INPUT_HINT: &str = "; write its data to a file and give that";
const OUTPUT_HINT: &str = "; give a file, and read that";

/// `hint` says what to do instead of using a pipe.
fn only_regular(metadata: &Metadata, hint: &str) -> Result<(), String> {
    if metadata.is_file() {
        return Ok(());
    }
    let kind = kind_of(metadata.file_type());
    let hint = if kind.contains("pipe") { hint } else { "" };
    Err(format!("is {kind}, not a regular file{hint}"))
}

#[cfg(unix)]
fn kind_of(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match () {
        () if kind.is_dir() => "a directory",
        () if kind.is_fifo() => "a pipe (FIFO)",
        () if kind.is_socket() => "a socket",
        () if kind.is_char_device() => "a character device",
        () if kind.is_block_device() => "a block device",
        () => "a special file",
    }
}

#[cfg(not(unix))]
fn kind_of(kind: FileType) -> &'static str {
    if kind.is_dir() { "a directory" } else { "a special file" }
}

/// A limit for messages, such as `67108864 bytes (64 MiB)`.
fn in_units(limit: u64) -> String {
    match limit {
        _ if limit > 0 && limit.is_multiple_of(1 << 30) => format!("{limit} ({} GiB)", limit >> 30),
        _ if limit > 0 && limit.is_multiple_of(1 << 20) => format!("{limit} ({} MiB)", limit >> 20),
        _ => limit.to_string(),
    }
}

/// A path for messages.
fn shown(path: &Path) -> String {
    let text = path.display().to_string();
    match text.char_indices().nth(LONGEST_SHOWN_PATH) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests;
