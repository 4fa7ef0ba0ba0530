//! Orders to the loader.

use super::scene_order::SceneOrder;

/// Change of the robot or the world that the loader builds a checker for.
pub enum Order {
    /// A URDF came on `robot_description`.
    Description(String),
    /// An SRDF came on `robot_description_semantic`.
    Semantic(String),
    /// A parameter changed.
    Parameters,
    /// Something else of the robot is to be shown.
    Display,
    /// A message about the world.
    Scene(Box<SceneOrder>),
    /// Some topic has a new cloud.
    Clouds,
    /// The robot is elsewhere in what obstacles stand in.
    Frames,
}
