//! A planning scene as it stands in YAML: `moveit_msgs` field names, with the short forms that MoveIt's tools write
//! (lists for vectors, names for shape types).

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::math::{Pose, pose_from_xyz_quaternion};

/// `moveit_msgs/AllowedCollisionMatrix` as it stands in the file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct MatrixEntries {
    pub entry_names: Vec<String>,
    #[serde(deserialize_with = "rows")]
    pub entry_values: Vec<Vec<bool>>,
    pub default_entry_names: Vec<String>,
    pub default_entry_values: Vec<bool>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneText {
    pub world: Option<WorldText>,
    pub collision_objects: Option<Vec<ObjectText>>,
    pub allowed_collision_matrix: Option<MatrixEntries>,
    pub robot_state: Option<RobotStateText>,
    pub octomap: Option<OctomapText>,
    #[serde(rename = "name")]
    pub _name: Option<IgnoredAny>,
    #[serde(rename = "robot_model_name")]
    pub _robot_model_name: Option<IgnoredAny>,
    #[serde(rename = "fixed_frame_transforms")]
    pub _fixed_frame_transforms: Option<IgnoredAny>,
    #[serde(rename = "object_colors")]
    pub _object_colors: Option<IgnoredAny>,
    #[serde(rename = "is_diff")]
    pub _is_diff: Option<IgnoredAny>,
    #[serde(default)]
    pub link_padding: Vec<LinkPaddingText>,
    #[serde(default)]
    pub link_scale: Vec<LinkScaleText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WorldText {
    #[serde(default)]
    pub collision_objects: Vec<ObjectText>,
    pub octomap: Option<OctomapText>,
}

/// `moveit_msgs/LinkPadding`
#[derive(Deserialize)]
pub(super) struct LinkPaddingText {
    pub link_name: String,
    pub padding: f64,
}

/// `moveit_msgs/LinkScale`
#[derive(Deserialize)]
pub(super) struct LinkScaleText {
    pub link_name: String,
    pub scale: f64,
}

#[derive(Deserialize)]
pub(super) struct OctomapText {
    pub octomap: Option<OctomapBody>,
}

#[derive(Deserialize)]
pub(super) struct OctomapBody {
    #[serde(default)]
    pub data: Vec<i8>,
}

#[derive(Deserialize)]
pub(super) struct RobotStateText {
    #[serde(default)]
    pub attached_collision_objects: Vec<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(default)]
#[derive(Default)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectText {
    pub id: String,
    pub header: HeaderText,
    pub pose: Option<PoseText>,
    pub primitives: Vec<PrimitiveText>,
    pub primitive_poses: Vec<PoseText>,
    pub meshes: Vec<MeshText>,
    pub mesh_poses: Vec<PoseText>,
    pub planes: Vec<IgnoredAny>,
    pub operation: Option<OperationText>,
    #[serde(rename = "type")]
    pub _type: Option<IgnoredAny>,
    #[serde(rename = "plane_poses")]
    pub _plane_poses: Option<IgnoredAny>,
    #[serde(rename = "subframe_names")]
    pub _subframe_names: Option<IgnoredAny>,
    #[serde(rename = "subframe_poses")]
    pub _subframe_poses: Option<IgnoredAny>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
#[serde(deny_unknown_fields)]
pub(super) struct HeaderText {
    pub frame_id: String,
    #[serde(rename = "stamp")]
    pub _stamp: Option<IgnoredAny>,
    #[serde(rename = "seq")]
    pub _seq: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum OperationText {
    Number(i64),
    Name(String),
}

#[derive(Default, Deserialize)]
#[serde(default)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseText {
    pub position: XyzText,
    pub orientation: QuaternionText,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
pub(super) enum XyzText {
    List([f64; 3]),
    Map { x: f64, y: f64, z: f64 },
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
pub(super) enum QuaternionText {
    List([f64; 4]),
    Map { x: f64, y: f64, z: f64, w: f64 },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrimitiveText {
    #[serde(rename = "type")]
    pub kind: KindText,
    pub dimensions: Vec<f64>,
    #[serde(rename = "polygon")]
    pub _polygon: Option<IgnoredAny>,
}

#[derive(Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum KindText {
    Number(i64),
    Name(String),
}

#[derive(Default, Deserialize)]
#[serde(default)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshText {
    pub triangles: Vec<FaceText>,
    pub vertices: Vec<XyzText>,
    /// A mesh file by URI, as MotionBenchMaker writes it.
    pub resource: Option<String>,
    /// Scale of a resource along its axes.
    pub dimensions: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum FaceText {
    List([u32; 3]),
    Map { vertex_indices: [u32; 3] },
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
    /// A quaternion of zeros is the identity, as in ROS messages that leave it out.
    pub fn pose(&self, field: &str) -> Result<Pose, String> {
        let quaternion = match self.orientation.numbers() {
            [0.0, 0.0, 0.0, 0.0] => [0.0, 0.0, 0.0, 1.0],
            given => given,
        };
        pose_from_xyz_quaternion(self.position.numbers(), quaternion).ok_or_else(|| {
            format!("{field}: position and orientation must be finite and the quaternion not zero")
        })
    }
}

/// Rows as `[true, false]` or as `moveit_msgs/AllowedCollisionEntry` with the field `enabled`.
fn rows<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<bool>>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Row {
        List(Vec<bool>),
        Map { enabled: Vec<bool> },
    }
    let rows = Vec::<Row>::deserialize(deserializer)?;
    Ok((rows.into_iter())
        .map(|row| match row {
            Row::List(values) | Row::Map { enabled: values } => values,
        })
        .collect())
}
