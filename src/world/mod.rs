//! Named obstacles around the robot, what it holds, and the files that describe them.

mod attached_object;
mod cloud;
mod frames;
mod named_state;
mod obstacle;
mod octomap;
mod planning_scene;
mod scene_object;
mod scene_object_text;
mod scene_shapes;
mod scene_stream;
mod scene_text;
mod scene_yaml;
mod state_text;
#[cfg(test)]
mod testing;
#[allow(clippy::module_inception)] // the concept is the module
mod world;
mod world_file;

pub use attached_object::{AttachedId, AttachedObject};
pub use cloud::{ByteOrder, CloudError, CloudPoints, Column, Columns, NumberKind, is_cloud, read_cloud};
pub use frames::{FoundFrame, Frames};
pub use named_state::NamedState;
pub use obstacle::{Obstacle, ObstacleId, ObstacleShape};
pub use octomap::{Cell, Octomap, OctomapError, Space};
pub use planning_scene::{PlanningScene, SceneError};
pub use scene_object::{OCTOMAP_NAME, ObjectError, Operation, SceneAttachment, SceneObject};
pub use scene_shapes::{mesh, message_pose, placed_shapes, plane, solid, solid_type};
pub use scene_text::MatrixEntries;
pub(crate) use scene_text::RobotStateText;
pub use world::{World, WorldError};
pub use world_file::WorldFileKind;
