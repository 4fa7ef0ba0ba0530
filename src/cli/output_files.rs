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
                let message = "two outputs would be written to it: give each a file of its own";
                return Err(Failure::Input(format!("{}: {message}", file.display())));
            }
            None => known.push(real),
        }
    }
    Ok(())
}

/// The meshes that were read, as paths without links.
pub fn mesh_files(meshes: &MeshLog) -> Vec<PathBuf> {
    meshes.take().into_iter().map(|mesh| real(&mesh.file)).collect()
}

/// Checks that none of the files that are written is one of the meshes that were `read`.
pub fn check_beside_meshes(read: &[PathBuf], outputs: &[Option<&Path>]) -> Result<(), Failure> {
    match outputs.iter().flatten().find(|file| read.contains(&real(file))) {
        Some(file) => Err(Failure::Input(format!(
            "{}: it is a mesh of the robot: write to another file",
            file.display()
        ))),
        None => Ok(()),
    }
}

/// The path without links; of a file that is not there, its name in its folder. A link may point to such a file.
fn real(file: &Path) -> PathBuf {
    let target = input_files::target_of(file);
    let beside = || {
        let folder =
            target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(folder.canonicalize().ok()?.join(target.file_name()?))
    };
    target.canonicalize().ok().or_else(beside).unwrap_or(target)
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn links_to_one_file_are_one_output() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("sub")).unwrap();
        std::fs::write(path("read"), "").unwrap();
        for (link, target) in
            [("new", "x"), ("sub/far", "../x"), ("chain", "sub/far"), ("folder", "sub"), ("old", "read")]
        {
            symlink(target, path(link)).unwrap();
        }
        symlink(path("x"), path("absolute")).unwrap();
        let fault = |inputs: &[&str], outputs: &[&str]| {
            let [inputs, outputs] =
                [inputs, outputs].map(|names| names.iter().map(|name| path(name)).collect::<Vec<_>>());
            let [inputs, outputs] = [&inputs, &outputs]
                .map(|files| files.iter().map(|file| Some(file.as_path())).collect::<Vec<_>>());
            check(&inputs, &outputs).map_err(|failure| failure.to_string())
        };
        // before the file is there, and after
        for _ in 0..2 {
            for link in ["new", "sub/far", "folder/far", "chain", "absolute", "sub/../x"] {
                for outputs in [["x", link], [link, "x"], ["new", link]] {
                    if outputs[0] == outputs[1] {
                        continue;
                    }
                    let message = fault(&[], &outputs).unwrap_err();
                    assert!(message.contains("two outputs would be written to it"), "{outputs:?}: {message}");
                }
                assert_eq!(fault(&[], &["y", link, "sub/x"]), Ok(()));
            }
            std::fs::write(path("x"), "").unwrap();
        }
        assert!(fault(&["read"], &["old"]).unwrap_err().contains("it is read, too"));
        let [read, old, new] = ["read", "old", "new"].map(path);
        let read = [read.canonicalize().unwrap()];
        let beside = |file: &Path| check_beside_meshes(&read, &[None, Some(file)]);
        assert!(beside(&old).unwrap_err().to_string().contains("it is a mesh of the robot"));
        assert!(beside(&new).is_ok());
    }
}
