//! Named obstacles around the robot, and the files that describe them.

mod obstacle;
mod planning_scene;

pub use obstacle::{Obstacle, ObstacleId, ObstacleShape, World, WorldError};
pub use planning_scene::{MatrixEntries, PlanningScene, SceneError};
