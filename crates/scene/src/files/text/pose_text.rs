//! Data types (serde) of points, rotations and poses in YAML, as lists or with named components.

use std::fmt;
use std::marker::PhantomData;

use clearance_geometry::math::Pose;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

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
    Map(Named<XyzMap>),
}

/// Components that have names. Without this, a list would be read as components in their order, and a short one
/// completed.
#[derive(Debug, Clone, Copy)]
pub struct Named<T>(T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(NamedComponents(PhantomData))
    }
}

struct NamedComponents<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for NamedComponents<T> {
    type Value = Named<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("named components")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(Named)
    }
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
    Map(Named<QuaternionMap>),
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
            Self::Map(Named(XyzMap { x, y, z })) => [x, y, z],
        }
    }
}

impl QuaternionText {
    pub fn numbers(self) -> [f64; 4] {
        match self {
            Self::List(list) => list,
            Self::Map(Named(QuaternionMap { x, y, z, w })) => [x, y, z, w],
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
