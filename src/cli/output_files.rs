//! Checks that the output files of a command can be written, differ, and are none of its input files.

use std::path::{Path, PathBuf};

use clearance::robot::MeshLog;
use clearance_files::input_files;

use super::failure::Failure;

/// Checks that files can be written, and that no two of them, and none of the files that are read, are the same.
pub fn check(inputs: &[Option<&Path>], outputs: &[Option<&Path>]) -> Result<(), Failure> {
    let mut known: Vec<PathBuf> = inputs.iter().flatten().map(|file| real(file)).collect();
    let read = known.len();
    for file in outputs.iter().flatten() {
        input_files::check_target(file).map_err(Failure::input)?;
        let real = real(file);
        match known.iter().position(|other| *other == real) {
            Some(i) if i < read => {
                let message = "it is read, too: write to another file";
                return Err(Failure::Input(format!("{}: {message}", file.display())));
            }
            Some(_) => {
                let message = "two options write to it: give each a file of its own";
                return Err(Failure::Input(format!("{}: {message}", file.display())));
            }
            None => known.push(real),
        }
    }
    Ok(())
}

/// Checks that none of the files that are written is a mesh that was read.
pub fn check_beside_meshes(meshes: &MeshLog, outputs: &[Option<&Path>]) -> Result<(), Failure> {
    let read: Vec<PathBuf> = meshes.take().into_iter().map(|mesh| real(&mesh.file)).collect();
    match outputs.iter().flatten().find(|file| read.contains(&real(file))) {
        Some(file) => Err(Failure::Input(format!(
            "{}: it is a mesh of the robot: write to another file",
            file.display()
        ))),
        None => Ok(()),
    }
}

/// The path without links; of a file that is not there, its name in its folder.
fn real(file: &Path) -> PathBuf {
    let beside = || {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(folder.canonicalize().ok()?.join(file.file_name()?))
    };
    file.canonicalize().ok().or_else(beside).unwrap_or_else(|| file.to_owned())
}
