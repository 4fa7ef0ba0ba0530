//! Points, rotations and poses, as lists or with named components.

use serde::Deserialize;

use crate::math::Pose;
use crate::world::scene_shapes::message_pose;

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PoseText {
    pub position: XyzText,
    pub orientation: QuaternionText,
}

/// `geometry_msgs/Transform`
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TransformText {
    pub translation: XyzText,
    pub rotation: QuaternionText,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
pub enum XyzText {
    List([f64; 3]),
    Map { x: f64, y: f64, z: f64 },
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
pub enum QuaternionText {
    List([f64; 4]),
    Map { x: f64, y: f64, z: f64, w: f64 },
}

impl Default for XyzText {
    fn default() -> Self {
        Self::List([0.0; 3])
    }
}

impl Default for QuaternionText {
    fn default() -> Self {
        Self::List([0.0, 0.0, 0.0, 1.0])
    }
}

impl XyzText {
    pub fn numbers(self) -> [f64; 3] {
        match self {
            Self::List(list) => list,
            Self::Map { x, y, z } => [x, y, z],
        }
    }
}

impl QuaternionText {
    pub fn numbers(self) -> [f64; 4] {
        match self {
            Self::List(list) => list,
            Self::Map { x, y, z, w } => [x, y, z, w],
        }
    }
}

impl PoseText {
    pub fn pose(&self, field: &str) -> Result<Pose, String> {
        let pose = message_pose(self.position.numbers(), self.orientation.numbers());
        pose.map_err(|e| format!("{field}: {e}"))
    }
}

impl TransformText {
    pub fn pose(&self, field: &str) -> Result<Pose, String> {
        let pose = message_pose(self.translation.numbers(), self.rotation.numbers());
        pose.map_err(|e| format!("{field}: {e}"))
    }
}
