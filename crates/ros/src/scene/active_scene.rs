//! Robot and scene in use: built by the loader, and read by the other threads of the node.

use std::sync::{Arc, Mutex};

use clearance_monitor::Revision;
use clearance_robot::RobotModel;
use clearance_scene::{MeshModel, Scene};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::OctomapWithPose;

use crate::parameters::parameter_set::Parameters;

/// The revision in use, and the scene that it was built from.
pub struct ActiveScene {
    pub revision: Arc<Revision>,
    pub scene: Scene,
    pub octomap: Option<Arc<OctomapWithPose>>,
    pub mesh_model: MeshModel,
    /// Parameters that it was built with.
    pub parameters: Parameters,
}

/// The scene in use, for the services that publish it.
pub type CurrentScene = Arc<Mutex<Option<Arc<ActiveScene>>>>;

/// The current robot, for the thread that publishes a demonstration motion.
pub type CurrentRobot = Arc<Mutex<Option<Arc<RobotModel>>>>;
