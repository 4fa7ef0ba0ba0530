//! `clearance replay`: runs a recording of the node again, without a network.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use clearance::robot::{MeshFiles, RobotModel, RobotText};
use clearance_ros::{Archive, Outcome, Prepared, recorded_path, save_part};
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::{MeshArg, RobotArgs, UnknownSpace, WorldArgs};
use super::run_args::{Format, internal, print_line};

/// Number of results before the different one to keep in a test; the smallest that reproduces the difference is used.
const KEPT: [u64; 4] = [1, 10, 100, u64::MAX];

/// Replays a recording and compares every result bit by bit, except computation times.
///
/// Exit codes: 0 all results are the same; 1 one differs, or there is nothing to compare; 2 the recording cannot be read.
#[derive(Args)]
pub struct ReplayArgs {
    /// MCAP file written by `clearance node --record FILE`
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// If a result differs, save the part of the recording that reproduces it to DIR, as a test like those in tests/replays
    #[arg(long, value_name = "DIR")]
    save_test: Option<PathBuf>,

    /// Output format
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Command line arguments in a recording: names of files, which are attached to it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct GivenFiles {
    urdf: Option<PathBuf>,
    srdf: Option<PathBuf>,
    mesh: Option<MeshArg>,
    world: Vec<PathBuf>,
    cloud: Vec<PathBuf>,
    point_radius: Option<f64>,
    unknown_space: UnknownSpace,
    ignore: Vec<String>,
}

pub fn run(args: &ReplayArgs) -> Result<ExitStatus, Failure> {
    let outcome = replay(&args.file)?;
    let saved = match (&outcome.difference, &args.save_test) {
        (Some(_), Some(folder)) => Some(save_test(&args.file, folder, &outcome)?),
        _ => None,
    };
    match args.format {
        Format::Json => print_line(&serde_json::to_string(&outcome).map_err(internal)?)?,
        Format::Text => print_outcome(&args.file, &outcome)?,
    }
    match (saved, &args.save_test) {
        (Some(file), _) => eprintln!("saved: {}", file.display()),
        (None, Some(folder)) => {
            eprintln!("nothing is saved to {}: no result differs", folder.display());
        }
        (None, None) => {}
    }
    let is_same = outcome.difference.is_none() && outcome.lost.is_none() && outcome.same > 0;
    Ok(ExitStatus::from(u8::from(!is_same)))
}

/// Runs a recording again.
fn replay(file: &Path) -> Result<Outcome, Failure> {
    let archive = Archive::read(file).map_err(Failure::input)?;
    if archive.version != env!("CARGO_PKG_VERSION") {
        log::warn!("{}: version {} recorded it", file.display(), archive.version);
    }
    let prepared = prepare(archive).map_err(|why| Failure::Input(format!("{}: {why}", file.display())))?;
    clearance_ros::replay(file, prepared).map_err(Failure::input)
}

fn print_outcome(file: &Path, outcome: &Outcome) -> Result<(), Failure> {
    let (file, same) = (file.display(), outcome.same);
    if let Some(difference) = &outcome.difference {
        let (answer, seconds, nanoseconds) =
            (difference.answer, difference.time / 1_000_000_000, difference.time % 1_000_000_000);
        print_line(&format!(
            "answer {answer} at {seconds}.{nanoseconds:09} differs: {}\n  recorded: {}\n  replayed: {}",
            difference.field, difference.recorded, difference.replayed
        ))?;
    }
    if let Some(steps) = outcome.lost {
        print_line(&format!("the recorder lost {steps} steps here: what follows can not be run again"))?;
    }
    if outcome.cut_off {
        print_line("the file was not finished: what it holds was run")?;
    }
    if outcome.late > 0 {
        print_line(&format!(
            "{} answers lacked pairs at check_deadline: of these, is_free and speed_scale were compared",
            outcome.late
        ))?;
    }
    print_line(&format!("{file}: {same} answers are as recorded"))
}

/// Saves the part of a recording that reproduces the difference.
fn save_test(file: &Path, folder: &Path, outcome: &Outcome) -> Result<PathBuf, Failure> {
    let input_failure = |error: std::io::Error| Failure::Input(format!("{}: {error}", folder.display()));
    let Some(difference) = &outcome.difference else {
        return Err(Failure::Internal("there is no difference to save".to_owned()));
    };
    let to = folder.join("recording.mcap");
    if to.exists() {
        return Err(Failure::Input(format!("{}: is there already", to.display())));
    }
    std::fs::create_dir_all(folder).map_err(input_failure)?;
    for kept in KEPT {
        save_part(file, &to, difference.answer, kept).map_err(Failure::input)?;
        let shown = replay(&to)?.difference;
        let shows = |shown: &clearance_ros::Difference| {
            (&shown.field, &shown.recorded, &shown.replayed)
                == (&difference.field, &difference.recorded, &difference.replayed)
        };
        if shown.as_ref().is_some_and(shows) {
            return Ok(to);
        }
        std::fs::remove_file(&to).map_err(input_failure)?;
    }
    Err(Failure::Internal("no part of the recording shows the difference again".to_owned()))
}

impl GivenFiles {
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
    pub fn all(&self) -> Vec<PathBuf> {
        (self.urdf.iter()).chain(&self.srdf).chain(&self.world).chain(&self.cloud).cloned().collect()
    }
}

/// Prepares the node's input from the recording alone.
fn prepare(archive: Archive) -> Result<Prepared, String> {
    let given: GivenFiles = serde_json::from_value(archive.given.clone())
        .map_err(|error| format!("what the node was given is no such thing of this version: {error}"))?;
    let archive = Arc::new(archive);
    let mesh_files = match given.urdf.as_deref().and_then(Path::parent) {
        Some(folder) => archive.meshes().beside_urdf(folder),
        None => archive.meshes(),
    };
    let robot = given.robot(&archive, &mesh_files)?;
    let mesh_model = RobotArgs { mesh: given.mesh, ..RobotArgs::default() }.mesh_model();
    let world = WorldArgs {
        world: given.world,
        cloud: given.cloud,
        point_radius: given.point_radius,
        unknown_space: given.unknown_space,
        ignore: given.ignore,
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

impl GivenFiles {
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
