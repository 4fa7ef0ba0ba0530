//! Data types (serde) of scene objects in YAML: objects, attached objects, primitives, planes and meshes.

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::pose_text::{PoseText, XyzText};

/// `moveit_msgs/CollisionObject`
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObjectText {
    pub id: String,
    pub header: HeaderText,
    pub pose: Option<PoseText>,
    pub primitives: Vec<PrimitiveText>,
    pub primitive_poses: Vec<PoseText>,
    pub meshes: Vec<MeshText>,
    pub mesh_poses: Vec<PoseText>,
    pub planes: Vec<PlaneText>,
    pub plane_poses: Vec<PoseText>,
    pub subframe_names: Vec<String>,
    pub subframe_poses: Vec<PoseText>,
    pub operation: Option<OperationText>,
    #[serde(rename = "type")]
    pub kind: ObjectTypeText,
}

/// `object_recognition_msgs/ObjectType`
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObjectTypeText {
    pub key: String,
    pub db: String,
}

/// `moveit_msgs/AttachedCollisionObject`
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AttachedText {
    pub link_name: String,
    pub object: ObjectText,
    pub touch_links: Vec<String>,
    #[serde(rename = "detach_posture")]
    _detach_posture: Option<IgnoredAny>,
    #[serde(rename = "weight")]
    _weight: Option<IgnoredAny>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HeaderText {
    pub frame_id: String,
    #[serde(rename = "stamp")]
    _stamp: Option<IgnoredAny>,
    #[serde(rename = "seq")]
    _seq: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "it must be 0 to 3, or ADD, REMOVE, APPEND or MOVE")]
pub enum OperationText {
    Number(i64),
    Name(String),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrimitiveText {
    #[serde(rename = "type")]
    pub kind: KindText,
    pub dimensions: Vec<f64>,
    #[serde(rename = "polygon")]
    _polygon: Option<IgnoredAny>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(
    untagged,
    expecting = "it must be the number or the name of a shape, such as box, sphere, cylinder or cone"
)]
pub enum KindText {
    Number(u8),
    Name(String),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneText {
    pub coef: [f64; 4],
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshText {
    pub triangles: Vec<FaceText>,
    pub vertices: Vec<XyzText>,
    /// A mesh file by URI, in the format of MotionBenchMaker.
    pub resource: Option<String>,
    /// Scale factors of the mesh along its axes.
    pub dimensions: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "it must be a list of three numbers of vertices, or vertex_indices"
)]
pub enum FaceText {
    List([u32; 3]),
    Map { vertex_indices: [u32; 3] },
}

impl FaceText {
    pub fn corners(self) -> [u32; 3] {
        match self {
            Self::List(corners) | Self::Map { vertex_indices: corners } => corners,
        }
    }
}
