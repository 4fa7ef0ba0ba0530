//! Test helper: runs the program `clearance` as a process, in a temporary folder.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program in the project's folder.
pub fn clearance(arguments: &[&str]) -> Output {
    clearance_in(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// Runs the program in a folder, to which names of files are relative.
pub fn clearance_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_clearance"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// A temporary folder with the files of a test, in which the program runs.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder can be made"))
    }

    /// With a robot in `r.urdf` and a world in `w.yaml`.
    pub fn of(robot: &str, world: &str) -> Self {
        let folder = Self::new();
        folder.write("r.urdf", robot);
        folder.write("w.yaml", world);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file; gives its path.
    pub fn write(&self, name: &str, text: &str) -> String {
        let path = self.path(name);
        std::fs::write(&path, text).expect("the file can be written");
        path.display().to_string()
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        clearance_in(self.0.path(), arguments)
    }
}
