//! `clearance node`: joint states in, collisions and distances out.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use clearance::monitor::scene::PlanningSceneState;
use clearance::node::{
    self, Environment, Motion, NodeError, NodeOptions, ParameterSource, Parameters, RosArguments,
    Surroundings, Value, View,
};
use log::LevelFilter;

use super::failure::Failure;
use super::model::{ModelArgs, WorldArgs};
use super::view::ViewArgs;

/// Without --urdf the robot is awaited on the topic `robot_description`.
#[derive(Args)]
pub struct NodeArgs {
    #[command(flatten)]
    model: ModelArgs,

    #[command(flatten)]
    world: WorldArgs,

    /// Parameters: a ROS 2 parameter file, such as config/clearance.yaml
    #[arg(long, value_name = "FILE")]
    params_file: Vec<PathBuf>,

    /// Also move the robot: publish a slow motion of every joint on `joint_states`
    #[arg(long)]
    demo_motion: bool,

    #[command(flatten)]
    view: ViewArgs,

    /// ROS arguments up to `--`: -r from:=to, -p name:=value, --params-file FILE, --log-level LEVEL
    #[arg(long, value_name = "ARGUMENT", num_args = 0.., allow_hyphen_values = true, value_terminator = "--")]
    ros_args: Vec<String>,
}

/// Runs the node until it is told to end.
pub fn run(args: &NodeArgs, level: LevelFilter) -> Result<ExitCode, Failure> {
    let arguments = args.ros_arguments()?;
    node::logging::start(arguments.log_level.unwrap_or(level));
    let robot = match args.model.urdf {
        Some(_) => Some(args.model.load()?),
        None => None,
    };
    let view = args.view.open()?;
    node::run(NodeOptions {
        environment: Environment::of_process().map_err(Failure::input)?,
        arguments,
        parameters: Parameters::default(),
        robot,
        mesh_files: args.model.mesh_files(),
        surroundings: args.surroundings(),
        mesh_model: args.model.settings().mesh_model,
        motion: args.demo_motion.then_some(Motion::Sweep),
        observer: view.as_ref().map(View::observer),
    })
    .map_err(failure)?;
    Ok(ExitCode::SUCCESS)
}

/// Which exit code a failed node means.
pub fn failure(error: NodeError) -> Failure {
    match error {
        NodeError::Input(message) => Failure::Input(message),
        NodeError::Internal(message) => Failure::Internal(message),
    }
}

impl NodeArgs {
    /// What stands after --ros-args, preceded by what the other arguments say about parameters.
    fn ros_arguments(&self) -> Result<RosArguments, Failure> {
        let mut arguments = RosArguments::parse(&self.ros_args).map_err(Failure::input)?;
        let files = self.params_file.iter().cloned().map(ParameterSource::File);
        let padding = self.model.padding.map(|m| single("padding", Value::Double(m)));
        let pad_self = self.model.pad_self.then(|| single("pad_self", Value::Bool(true)));
        let first = files.chain(padding).chain(pad_self);
        arguments.parameters = first.chain(arguments.parameters).collect();
        Ok(arguments)
    }

    fn surroundings(&self) -> Surroundings {
        let (world, mesh_files) = (self.world.clone(), self.model.mesh_files());
        Box::new(move |robot| {
            let loaded = world.load(robot, &mesh_files).map_err(|failure| failure.to_string())?;
            let mut scene = PlanningSceneState::new(loaded.world);
            scene.matrix = loaded.allowed;
            (scene.link_padding, scene.link_scale) = (loaded.link_padding, loaded.link_scale);
            Ok(scene)
        })
    }
}

fn single(name: &str, value: Value) -> ParameterSource {
    ParameterSource::Single { node: None, name: name.to_owned(), value }
}
