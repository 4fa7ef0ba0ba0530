//! Sources of a robot: its texts and the content of its mesh files. A pickled robot contains all of them, so that it is the same robot
//! on any machine.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clearance::robot::{
    MeshFiles, MeshLog, MeshUse, RecordedMeshes, RobotModel, RobotText, check_package_path,
};
use clearance_files::input_files::{self, DESCRIPTION_LIMIT, MESH_LIMIT};
use pyo3::exceptions::{PyImportError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::error::error;

/// Texts and mesh files of a robot.
#[derive(Clone, Debug, Default)]
pub struct RobotSources {
    pub urdf: Text,
    pub srdf: Option<Text>,
    /// Folder of the URDF.
    pub folder: Option<PathBuf>,
    pub package_paths: Vec<PathBuf>,
    pub meshes: Vec<MeshBytes>,
}

/// A text, and the name of its file.
#[derive(Clone, Debug, Default)]
pub struct Text {
    pub text: String,
    pub file: Option<String>,
}

/// A mesh file by the name that the URDF, or a mesh file in `folder`, gives it.
#[derive(Clone, Debug)]
pub struct MeshBytes {
    pub folder: Option<PathBuf>,
    pub uri: String,
    pub file: PathBuf,
    pub bytes: Arc<[u8]>,
}

impl RobotSources {
    /// Reads the texts; the meshes are read with the robot.
    pub fn read(
        urdf: &Bound<'_, PyAny>,
        srdf: Option<&Bound<'_, PyAny>>,
        package_paths: Vec<PathBuf>,
        xacro_args: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let has_arguments = xacro_args.is_some_and(|arguments| !arguments.is_empty());
        if has_arguments && !is_xacro(urdf) && !srdf.is_some_and(is_xacro) {
            return Err(error(
                "xacro_args are given, but neither urdf nor srdf is the path of a .xacro file: leave them out, or give that path",
            ));
        }
        for dir in &package_paths {
            check_package_path(dir).map_err(|why| error(format!("package_paths: {why}")))?;
        }
        let (urdf, path) = read_text(urdf, "urdf", xacro_args)?;
        let srdf = srdf.map(|srdf| read_text(srdf, "srdf", xacro_args)).transpose()?.map(|(text, _)| text);
        let folder = path.map(|path| match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
            _ => PathBuf::from("."),
        });
        Ok(Self { urdf, srdf, folder, package_paths, meshes: Vec::new() })
    }

    /// Where mesh names of the robot and of scenes are looked up.
    pub fn mesh_files(&self) -> MeshFiles {
        let files = self.package_paths.iter().fold(MeshFiles::default(), MeshFiles::with_package_path);
        match &self.folder {
            Some(folder) => files.beside_urdf(folder).with_environment(),
            None => files.with_environment(),
        }
    }

    /// Loads the robot and keeps the content of its mesh files.
    pub fn load(&mut self) -> Result<RobotModel, String> {
        let log = MeshLog::default();
        let model = self.model(&self.mesh_files().with_log(log.clone()))?;
        let folder = self.folder.as_ref().and_then(|folder| folder.canonicalize().ok());
        let mut read: HashMap<PathBuf, Arc<[u8]>> = HashMap::new();
        for MeshUse { folder: base, uri, file } in log.take() {
            let bytes = match read.get(&file) {
                Some(bytes) => Arc::clone(bytes),
                None => input_files::read(&file, MESH_LIMIT).map_err(|e| e.to_string())?.into(),
            };
            read.insert(file.clone(), Arc::clone(&bytes));
            // a restored robot has no folder
            let base = base.filter(|base| Some(base) != folder.as_ref());
            self.meshes.push(MeshBytes { folder: base, uri, file, bytes });
        }
        Ok(model)
    }

    /// Loads the robot from the kept content; opens no file.
    pub fn restore(&self) -> Result<RobotModel, String> {
        let mut recorded = RecordedMeshes::default();
        for MeshBytes { folder, uri, file, bytes } in &self.meshes {
            let named = MeshUse { folder: folder.clone(), uri: uri.clone(), file: file.clone() };
            recorded.insert(named, Arc::clone(bytes));
        }
        self.model(&MeshFiles::recorded(Arc::new(recorded)))
    }

    fn model(&self, files: &MeshFiles) -> Result<RobotModel, String> {
        let text = RobotText {
            urdf: &self.urdf.text,
            urdf_name: self.urdf.file.as_deref(),
            srdf: self.srdf.as_ref().map(|srdf| srdf.text.as_str()),
            srdf_name: self.srdf.as_ref().and_then(|srdf| srdf.file.as_deref()),
        };
        RobotModel::from_text(&text, files).map_err(|e| e.to_string())
    }
}

/// Reads an argument that is XML text or a path; returns the path, too.
fn read_text(
    value: &Bound<'_, PyAny>,
    what: &str,
    xacro_args: Option<&Bound<'_, PyDict>>,
) -> PyResult<(Text, Option<PathBuf>)> {
    if let Ok(text) = value.cast::<PyString>() {
        let text = text.to_cow()?;
        let content = text.trim_start_matches('\u{feff}').trim_start();
        if content.is_empty() {
            return Err(error(format!("{what} is empty: give a path or XML text")));
        }
        if content.starts_with('<') {
            return Ok((Text { text: text.into_owned(), file: None }, None));
        }
    }
    let path: PathBuf = value.extract().map_err(|_| {
        let given = value.get_type().name().map_or_else(|_| String::new(), |name| name.to_string());
        PyTypeError::new_err(format!("{what} must be a path or XML text, but it is of type {given}"))
    })?;
    let file = path.to_str().map(str::to_owned);
    let text = if has_xacro_extension(&path) {
        expanded(value.py(), &path, xacro_args)?
    } else {
        input_files::read_text(&path, DESCRIPTION_LIMIT).map_err(error)?
    };
    Ok((Text { text, file }, Some(path)))
}

fn is_xacro(value: &Bound<'_, PyAny>) -> bool {
    value.extract::<PathBuf>().is_ok_and(|path| has_xacro_extension(&path))
}

fn has_xacro_extension(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "xacro")
}

/// The URDF of a xacro file, by the package `xacro`.
fn expanded(py: Python<'_>, path: &Path, arguments: Option<&Bound<'_, PyDict>>) -> PyResult<String> {
    let file = path.display();
    let xacro = py.import("xacro").map_err(|why| {
        PyImportError::new_err(format!(
            "{file} is a xacro file, which needs the Python package xacro: pip install xacro, or give the URDF that `xacro {file}` prints \
             ({why})"
        ))
    })?;
    let options = PyDict::new(py);
    if let Some(arguments) = arguments {
        options.set_item("mappings", arguments)?;
    }
    let document = xacro.call_method("process_file", (path,), Some(&options));
    let text = document.and_then(|document| document.call_method0("toxml"));
    text.map_err(|why| error(format!("{file}: xacro: {why}")))?.extract()
}
