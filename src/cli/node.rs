//! `clearance node`: receives joint states, publishes collisions and distances.

use std::path::PathBuf;

use clap::Args;
use clearance::robot::{MeshFiles, MeshLog};
use clearance_ros::{
    Announcement, CommandLineInputs, Environment, Motion, NodeError, NodeOptions, ParameterSource,
    RosArguments, Startup, Surroundings, ThreadPriority, Value, View,
};
use log::LevelFilter;

use super::exit_status::ExitStatus;
use super::failure::Failure;
use super::model_args::{ModelArgs, WorldArgs};
use super::recorded_arguments::RecordedArguments;
use super::view_args::ViewArgs;

/// Without --urdf the robot description is received from the topic `robot_description`.
#[derive(Args)]
pub struct NodeArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    /// Parameters: a ROS 2 parameter file, such as config/clearance.yaml
    #[arg(long, value_name = "FILE")]
    params_file: Vec<PathBuf>,

    /// Record all received and published messages to an MCAP file, for `clearance replay`, `ros2 bag` and Foxglove
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,

    /// Also move the robot: publish a slow motion of every joint on `joint_states`
    #[arg(long)]
    demo_motion: bool,

    #[command(flatten)]
    view: ViewArgs,

    /// ROS arguments up to `--`: -r from:=to, -p name:=value, --params-file FILE, --log-level LEVEL
    #[arg(long, value_name = "ARGUMENT", num_args = 0.., allow_hyphen_values = true, value_terminator = "--")]
    ros_args: Vec<String>,
}

/// Runs the node until it is stopped.
pub fn run(args: &NodeArgs, level: LevelFilter) -> Result<ExitStatus, Failure> {
    let arguments = args.ros_arguments()?;
    clearance_ros::start_logging(arguments.log_level.unwrap_or(level));
    let parameters = clearance_ros::initial_parameters(&arguments).map_err(failure)?;
    let startup = Startup::begin(parameters.memory_limit).map_err(failure)?;
    let priority = ThreadPriority::allowed(parameters.use_realtime_priority).map_err(failure)?;
    let announcement = announce(Environment::of_process().map_err(Failure::input)?, priority)?;
    let meshes = MeshLog::default();
    let mesh_files = args.model.robot.mesh_files().with_log(meshes.clone());
    let robot = match args.model.robot.urdf {
        // the node logs its warnings
        Some(_) => Some(args.model.robot.load_quietly(&mesh_files)?),
        None => None,
    };
    let view = args.view.open()?;
    let recorded = RecordedArguments::new(&args.model.robot, &args.world);
    let command_line = CommandLineInputs { arguments: recorded.to_json(), files: recorded.files(), meshes };
    clearance_ros::run(NodeOptions {
        startup,
        announcement,
        arguments,
        parameters,
        robot,
        surroundings: args.surroundings(mesh_files.clone()),
        mesh_files,
        mesh_model: args.model.robot.mesh_model(),
        motion: args.demo_motion.then_some(Motion::Sweep),
        observer: view.as_ref().map(View::observer),
        on_start: Some(Box::new(args.view.announcement(view.as_ref()))),
        command_line,
    })
    .map_err(failure)?;
    Ok(ExitStatus::SUCCESS)
}

/// Announces the node on the network, before any work that takes time.
pub fn announce(environment: Environment, priority: ThreadPriority) -> Result<Announcement, Failure> {
    Announcement::make(environment, priority).map_err(|error| failure(error.into()))
}

/// Maps a node's error to a failure with its exit code.
pub fn failure(error: NodeError) -> Failure {
    match error {
        NodeError::Input(message) => Failure::Input(message),
        NodeError::Internal(message) => Failure::Internal(message),
        NodeError::OutOfMemory(message) => Failure::OutOfMemory(message),
        NodeError::IncompleteRecording(message) => Failure::IncompleteRecording(message),
    }
}

impl NodeArgs {
    /// Arguments after --ros-args, preceded by the parameters from the other arguments.
    fn ros_arguments(&self) -> Result<RosArguments, Failure> {
        let mut arguments = RosArguments::parse(&self.ros_args).map_err(Failure::input)?;
        let files = self.params_file.iter().cloned().map(ParameterSource::File);
        let padding = self.model.padding.map(|m| single("padding", Value::Double(m)));
        let pad_self = self.model.pad_self.then(|| single("pad_self", Value::Bool(true)));
        let volumes = self.model.volumes.as_ref().map(|v| single("volumes", Value::Text(v.to_string())));
        let record = self.record.as_ref().map(|file| {
            let text = file.to_str().ok_or_else(|| Failure::Input("--record: is no UTF-8".to_owned()))?;
            Ok(single("record_file", Value::Text(text.to_owned())))
        });
        let first = files.chain(padding).chain(pad_self).chain(volumes).chain(record.transpose()?);
        arguments.parameters = first.chain(arguments.parameters).collect();
        Ok(arguments)
    }

    fn surroundings(&self, mesh_files: MeshFiles) -> Surroundings {
        let world = self.world.clone();
        Box::new(move |robot| world.load(robot, &mesh_files).map_err(|failure| failure.to_string()))
    }
}

fn single(name: &str, value: Value) -> ParameterSource {
    ParameterSource::Single { node: None, name: name.to_owned(), value }
}
