//! Tests of reading and writing files: size limits, missing files, and special files that never block.

use std::path::Path;

use super::*;

fn reason(path: &Path) -> String {
    let error = read(path, 100).unwrap_err();
    assert_eq!(error.to_string(), format!("{}: {}", path.display(), error.reason));
    assert!(!error.to_string().contains('\n'));
    open(path).map_or_else(|e| e.reason, |_| error.reason.clone())
}

#[test]
fn files_up_to_the_limit_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("f");
    for size in [0, 1, 99, 100] {
        std::fs::write(&file, vec![b'x'; size]).unwrap();
        assert_eq!(read(&file, 100).unwrap().len(), size);
        assert_eq!(read_text(&file, 100).unwrap().len(), size);
    }
    std::fs::write(&file, vec![b'x'; 101]).unwrap();
    let error = read(&file, 100).unwrap_err();
    assert_eq!(error.reason, "has 101 bytes, more than the limit of 100");
    std::fs::File::create(&file).unwrap().set_len(DESCRIPTION_LIMIT + 1).unwrap();
    let error = read(&file, DESCRIPTION_LIMIT).unwrap_err();
    assert_eq!(error.reason, "has 67108865 bytes, more than the limit of 67108864 (64 MiB)");
}

#[test]
fn what_is_no_text_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("f");
    std::fs::write(&file, b"\x1f\x8b\x08").unwrap();
    assert!(read_text(&file, 100).unwrap_err().reason.contains("gzip"));
    std::fs::write(&file, b"ab\xe4").unwrap();
    assert!(read_text(&file, 100).unwrap_err().reason.contains("byte 2"));
}

#[test]
fn what_is_missing_is_named() {
    assert!(reason(Path::new("/no/such/file")).starts_with("cannot be read: "));
    let long = PathBuf::from("x".repeat(5000));
    assert!(read(&long, 1).unwrap_err().to_string().len() < 500);
}

#[test]
fn files_are_written_in_place_of_the_old_ones() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("f");
    for text in ["a long text", "short", ""] {
        write(&file, text.as_bytes()).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    }
    let nowhere = folder.path().join("none").join("f");
    assert!(write(Path::new("-"), b"x").unwrap_err().reason.contains("standard output"));
    assert!(write(&nowhere, b"x").unwrap_err().reason.starts_with("cannot be written: "));
}

#[cfg(unix)]
#[test]
fn nothing_is_written_to_special_files() {
    let folder = tempfile::tempdir().unwrap();
    let fifo = folder.path().join("fifo");
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&fifo, &link).unwrap();
    for path in [folder.path(), &fifo, &link, Path::new("/dev/null"), Path::new("/dev/full")] {
        for error in [write(path, b"x").unwrap_err(), check_target(path).unwrap_err()] {
            assert!(error.reason.contains("not a regular file"), "{error}");
        }
    }
    assert!(write(&fifo, b"x").unwrap_err().reason.contains("give a file"));
    assert_eq!(check_target(&folder.path().join("new")), Ok(()));
}

#[cfg(unix)]
#[test]
fn special_files_are_named_and_never_block() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(reason(folder.path()), "is a directory, not a regular file");
    let fifo = folder.path().join("fifo");
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    assert!(reason(&fifo).contains("a pipe (FIFO), not a regular file; write its data"));
    let socket = folder.path().join("socket");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    assert!(reason(&socket).contains("a socket"));
    for device in ["/dev/zero", "/dev/null", "/dev/tty"] {
        assert!(reason(Path::new(device)).contains("a character device"), "{device}");
    }
    // through a symbolic link, too
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&fifo, &link).unwrap();
    assert!(reason(&link).contains("a pipe"));
}

/// The size of `/proc` files is 0 in their metadata.
#[cfg(target_os = "linux")]
#[test]
fn the_limit_holds_where_the_metadata_lie() {
    let status = Path::new("/proc/self/status");
    assert!(!read(status, 1 << 20).unwrap().is_empty());
    assert_eq!(read(status, 10).unwrap_err().reason, "has at least 11 bytes, more than the limit of 10");
}

#[test]
fn folders_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.stl"), "").unwrap();
    assert_eq!(names_in(folder.path()), ["a.stl"]);
    assert!(names_in(&folder.path().join("none")).is_empty());
}
