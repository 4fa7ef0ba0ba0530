//! Readers of scene files: the YAML of a `moveit_msgs/PlanningScene`, MoveIt's `.scene` text, point clouds and octrees; and of robot
//! state files.

mod object_yaml;
mod robot_state_yaml;
mod scene_error;
mod scene_file;
mod scene_loader;
mod scene_text;
mod scene_yaml;
mod state_list;
mod text;
mod world_file_kind;

pub use scene_error::SceneError;
pub use scene_loader::SceneLoader;
pub use state_list::StateList;
pub use text::{JointStateText, MultiDofText, RobotStateText};
pub use world_file_kind::WorldFileKind;
