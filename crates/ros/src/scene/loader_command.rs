//! Commands to the loader: changed descriptions, parameters, scene messages, clouds and frames.

use crate::scene::scene_command::SceneCommand;

/// Change of the robot or of the world, for which the loader builds a new checker.
pub enum LoaderCommand {
    /// A URDF was received on `robot_description`.
    Description(String),
    /// An SRDF was received on `robot_description_semantic`.
    Semantic(String),
    /// A parameter changed.
    Parameters,
    /// The displayed level of the link volumes changed.
    Display,
    /// A scene message was received.
    Scene(Box<SceneCommand>),
    /// A new point cloud was received on a topic.
    Clouds,
    /// The robot has moved relative to the frames of obstacles.
    Frames,
}
