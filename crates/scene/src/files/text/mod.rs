//! Data types (serde) of planning scenes in YAML: `moveit_msgs` field names, and the short forms of MoveIt's tools.
//! The short forms are lists for vectors and names for shape types.

mod object;
mod pose_text;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::MatrixEntries;

pub use object::{AttachedText, HeaderText, KindText, MeshText, ObjectText, OperationText, PrimitiveText};
pub use pose_text::{PoseText, TransformText};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneText {
    pub world: Option<WorldText>,
    pub collision_objects: Option<Vec<ObjectText>>,
    pub allowed_collision_matrix: Option<MatrixEntries>,
    pub robot_state: Option<RobotStateText>,
    pub octomap: Option<OctomapText>,
    #[serde(default)]
    pub fixed_frame_transforms: Vec<TransformStampedText>,
    #[serde(default)]
    pub link_padding: Vec<LinkPaddingText>,
    #[serde(default)]
    pub link_scale: Vec<LinkScaleText>,
    #[serde(rename = "name")]
    _name: Option<IgnoredAny>,
    pub robot_model_name: Option<String>,
    #[serde(rename = "object_colors")]
    _object_colors: Option<IgnoredAny>,
    /// True if objects may be replaced.
    #[serde(default)]
    pub is_diff: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldText {
    #[serde(default)]
    pub collision_objects: Vec<ObjectText>,
    pub octomap: Option<OctomapText>,
}

/// `moveit_msgs/LinkPadding`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkPaddingText {
    pub link_name: String,
    pub padding: f64,
}

/// `moveit_msgs/LinkScale`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkScaleText {
    pub link_name: String,
    pub scale: f64,
}

/// `geometry_msgs/TransformStamped`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransformStampedText {
    #[serde(default)]
    pub header: HeaderText,
    pub child_frame_id: String,
    #[serde(default)]
    pub transform: TransformText,
}

/// `octomap_msgs/OctomapWithPose`
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OctomapText {
    pub header: HeaderText,
    pub origin: PoseText,
    pub octomap: OctomapBody,
}

/// `octomap_msgs/Octomap`
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OctomapBody {
    #[serde(rename = "header")]
    _header: Option<IgnoredAny>,
    pub binary: bool,
    pub id: String,
    pub resolution: f64,
    #[serde(deserialize_with = "bytes")]
    pub data: Vec<u8>,
}

/// `moveit_msgs/RobotState`
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RobotStateText {
    /// Positions of joints with one position.
    pub joint_state: JointStateText,
    /// Transforms of planar, floating and virtual joints.
    pub multi_dof_joint_state: MultiDofText,
    /// Objects that the robot holds.
    pub attached_collision_objects: Vec<AttachedText>,
    #[serde(rename = "is_diff")]
    pub(crate) _is_diff: Option<IgnoredAny>,
}

/// `sensor_msgs/JointState`
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointStateText {
    pub name: Vec<String>,
    pub position: Vec<f64>,
    #[serde(rename = "header")]
    _header: Option<IgnoredAny>,
    #[serde(rename = "velocity")]
    _velocity: Option<IgnoredAny>,
    #[serde(rename = "effort")]
    _effort: Option<IgnoredAny>,
}

/// `sensor_msgs/MultiDOFJointState`
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MultiDofText {
    pub joint_names: Vec<String>,
    pub transforms: Vec<TransformText>,
    pub header: HeaderText,
    #[serde(rename = "twist")]
    _twist: Option<IgnoredAny>,
    #[serde(rename = "wrench")]
    _wrench: Option<IgnoredAny>,
}

/// Bytes, as signed or unsigned numbers.
fn bytes<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
    let numbers = Vec::<i16>::deserialize(deserializer)?;
    let byte = |n: &i16| u8::try_from(*n).or_else(|_| i8::try_from(*n).map(i8::cast_unsigned));
    (numbers.iter())
        .map(|n| byte(n).map_err(|_| serde::de::Error::custom(format!("{n} is no byte"))))
        .collect()
}
