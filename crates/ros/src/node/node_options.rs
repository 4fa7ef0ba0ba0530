//! Options of a node: all inputs that are determined before it starts.

use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::MeshModel;

use crate::arguments::RosArguments;
use crate::dds::announcement::Announcement;
use crate::loading::loader::Surroundings;
use crate::monitor_events::current_evaluation::Observer;
use crate::node::startup::Startup;
use crate::parameters::parameter_set::Parameters;
use crate::recording::recorded_event::CommandLineInputs;
use crate::topics::demo_motion::Motion;

/// Input of a node, determined before it starts.
pub struct NodeOptions {
    /// Started before any work that takes time.
    pub startup: Startup,
    /// DDS participant that the node's endpoints will belong to.
    pub announcement: Announcement,
    pub arguments: RosArguments,
    /// Initial parameters.
    pub parameters: Parameters,
    /// Robot model; if `None`, the model is received from `robot_description`.
    pub robot: Option<RobotModel>,
    /// Lookup of the meshes of a received robot description.
    pub mesh_files: MeshFiles,
    pub surroundings: Surroundings,
    pub mesh_model: MeshModel,
    /// Motion to publish on `joint_states`.
    pub motion: Option<Motion>,
    pub observer: Option<Observer>,
    /// Called once, after all input that can be rejected was read and the node has joined the network.
    pub on_start: Option<Box<dyn FnOnce() + Send>>,
    /// Input that a recording needs for its replay.
    pub command_line: CommandLineInputs,
}

impl std::fmt::Debug for NodeOptions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NodeOptions")
            .field("announcement", &self.announcement)
            .field("arguments", &self.arguments)
            .field("parameters", &self.parameters)
            .finish_non_exhaustive()
    }
}
