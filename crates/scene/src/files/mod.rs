//! Scenes out of files: the YAML of a `moveit_msgs/PlanningScene`, MoveIt's `.scene` text, clouds and octrees; and files of robot states.

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
