//! The program under test, as a process.

use std::path::Path;
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
