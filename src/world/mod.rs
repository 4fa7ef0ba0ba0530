//! Named obstacles around the robot, what it holds, and the files that describe them.

mod attached_object;
mod obstacle;
mod planning_scene;
mod scene_text;
#[allow(clippy::module_inception)] // the concept is the module
mod world;

pub use attached_object::{AttachedId, AttachedObject};
pub use obstacle::{Obstacle, ObstacleId, ObstacleShape};
pub use planning_scene::{PlanningScene, SceneError};
pub use scene_text::MatrixEntries;
pub use world::{World, WorldError};
