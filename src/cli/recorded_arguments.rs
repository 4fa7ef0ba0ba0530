//! Command line arguments of the node as a recording stores them, and the node's input that a replay reads from them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clearance::robot::{MeshFiles, RobotModel, RobotText};
use clearance_ros::{Archive, Prepared, recorded_path};
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::model_args::{MeshArg, RobotArgs, UnknownSpace, WorldArgs};

/// Command line arguments in a recording: names of files, which are attached to it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct RecordedArguments {
    urdf: Option<PathBuf>,
    srdf: Option<PathBuf>,
    mesh: Option<MeshArg>,
    world: Vec<PathBuf>,
    cloud: Vec<PathBuf>,
    point_radius: Option<f64>,
    unknown_space: UnknownSpace,
    ignore: Vec<String>,
}

impl RecordedArguments {
    pub fn new(robot: &RobotArgs, world: &WorldArgs) -> Self {
        let recorded = |paths: &[PathBuf]| paths.iter().map(|path| recorded_path(path)).collect();
        Self {
            urdf: robot.urdf.as_deref().map(recorded_path),
            srdf: robot.srdf.as_deref().map(recorded_path),
            mesh: robot.mesh,
            world: recorded(&world.world),
            cloud: recorded(&world.cloud),
            point_radius: world.point_radius,
            unknown_space: world.unknown_space,
            ignore: world.ignore.clone(),
        }
    }

    pub fn to_json(&self) -> Json {
        // paths that are not UTF-8 have no names in a recording
        serde_json::to_value(self).unwrap_or_default()
    }

    /// All files in the arguments.
    pub fn files(&self) -> Vec<PathBuf> {
        (self.urdf.iter()).chain(&self.srdf).chain(&self.world).chain(&self.cloud).cloned().collect()
    }

    fn robot(&self, archive: &Archive, mesh_files: &MeshFiles) -> Result<Option<RobotModel>, String> {
        let read = |path: &Path| -> Result<String, String> {
            let bytes = archive.file(path)?;
            String::from_utf8(bytes.to_vec()).map_err(|error| format!("{}: {error}", path.display()))
        };
        let Some(urdf_path) = &self.urdf else { return Ok(None) };
        let urdf = read(urdf_path)?;
        let srdf = self.srdf.as_deref().map(read).transpose()?;
        let text = RobotText {
            urdf: &urdf,
            urdf_name: urdf_path.to_str(),
            srdf: srdf.as_deref(),
            srdf_name: self.srdf.as_deref().and_then(Path::to_str),
        };
        RobotModel::from_text(&text, mesh_files).map(Some).map_err(|error| error.to_string())
    }
}

/// Prepares the node's input from the recording alone.
pub fn prepare(archive: Archive) -> Result<Prepared, String> {
    let recorded: RecordedArguments = serde_json::from_value(archive.given.clone())
        .map_err(|error| format!("the recorded arguments of the node are not valid: {error}"))?;
    let archive = Arc::new(archive);
    let mesh_files = match recorded.urdf.as_deref().and_then(Path::parent) {
        Some(folder) => archive.meshes().beside_urdf(folder),
        None => archive.meshes(),
    };
    let robot = recorded.robot(&archive, &mesh_files)?;
    let mesh_model = RobotArgs { mesh: recorded.mesh, ..RobotArgs::default() }.mesh_model();
    let world = WorldArgs {
        world: recorded.world,
        cloud: recorded.cloud,
        point_radius: recorded.point_radius,
        unknown_space: recorded.unknown_space,
        ignore: recorded.ignore,
    };
    let files = mesh_files.clone();
    Ok(Prepared {
        robot,
        mesh_files,
        surroundings: Box::new(move |robot| {
            let read = |path: &Path| archive.file(path).map(|bytes| bytes.to_vec());
            world.load_with(robot, &files, &read, &mut Vec::new()).map_err(|failure| failure.to_string())
        }),
        mesh_model,
    })
}
