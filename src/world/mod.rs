//! Named obstacles around the robot, and the files that describe them.

mod obstacle;
mod planning_scene;
mod scene_text;

pub use obstacle::{Obstacle, ObstacleId, ObstacleShape, World, WorldError};
pub use planning_scene::{PlanningScene, SceneError};
pub use scene_text::MatrixEntries;
