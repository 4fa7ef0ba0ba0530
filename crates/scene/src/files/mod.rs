//! Readers of scene files: the YAML of a `moveit_msgs/PlanningScene`, MoveIt's `.scene` text, point clouds and octrees; and of robot
//! state files.

mod kind;
mod loader;
mod object;
mod robot_state;
mod scene_file;
mod scene_text;
mod states;
mod text;
mod yaml;

pub use kind::WorldFileKind;
pub use loader::{SceneError, SceneLoader};
pub use states::StateList;
pub use text::{JointStateText, MultiDofText, RobotStateText};
