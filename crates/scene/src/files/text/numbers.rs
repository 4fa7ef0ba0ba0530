//! Points, rotations and poses, as lists or with named components.

use clearance_geometry::math::Pose;
use serde::Deserialize;

use crate::message_shapes::message_pose;

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PoseText {
    pub position: XyzText,
    pub orientation: QuaternionText,
}

/// `geometry_msgs/Transform`
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TransformText {
    pub translation: XyzText,
    pub rotation: QuaternionText,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "it must be a list of three numbers, or x, y and z")]
pub enum XyzText {
    List([f64; 3]),
    Map(XyzMap),
}

/// Missing components are zero, as in a message.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct XyzMap {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "it must be a list of four numbers, or x, y, z and w")]
pub enum QuaternionText {
    List([f64; 4]),
    Map(QuaternionMap),
}

/// Missing components are those of the identity, as in a message.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct QuaternionMap {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl Default for QuaternionMap {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
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
            Self::Map(XyzMap { x, y, z }) => [x, y, z],
        }
    }
}

impl QuaternionText {
    pub fn numbers(self) -> [f64; 4] {
        match self {
            Self::List(list) => list,
            Self::Map(QuaternionMap { x, y, z, w }) => [x, y, z, w],
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
