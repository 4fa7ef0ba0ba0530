//! Robot models: links and joints from URDF and SRDF, and the poses of the links for given joint positions.

// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod chain;
mod configuration;
mod ids;
mod joint;
mod joint_limits;
mod joint_transforms;
mod kinematics;
mod loaded_mesh;
mod mesh_files;
mod mesh_formats;
mod mesh_log;
mod mesh_uri;
mod mimic;
mod missing_meshes;
mod model;
mod name_length;
mod named_values;
mod numbers;
mod pair_limit;
mod prefix;
mod quoted;
mod robot_text;
mod sampling;
mod similar_names;
mod source;
mod srdf;
mod tree;
mod uniform_tolerance;
mod urdf;
mod urdf_validation;
mod warning;
mod xml;
mod xml_limits;

pub use chain::{
    Approach, Chain, ChainJoint, Deviation, Deviations, Frame, KinematicPath, LinkInBody, Motion,
    PathsToRoot, Reach, ReachableRegion, SideMotion, Source as PositionSource, TravelRates,
};
pub use chain::{Columns, PlacedFrame};
pub use configuration::{Configuration, ConfigurationError};
pub use ids::{JointId, LinkId};
pub use joint::{Joint, JointKind, Limits, Mimic};
pub use joint_limits::OutsideLimits;
pub use joint_transforms::JointTransformError;
pub use kinematics::LinkPoses;
pub use loaded_mesh::LoadedMesh;
pub use mesh_files::{MeshFileError, MeshFiles};
pub use mesh_log::{MeshLog, MeshUse, RecordedMeshes};
pub use model::{Collision, Link, MeshSource, ModelError, RobotModel};
pub use name_length::check_name_length;
pub use named_values::{MIMIC_TOLERANCE, MimicContradiction, NamedJoints};
pub use quoted::{quoted, quoted_list};
pub use robot_text::RobotText;
pub use source::{Fault, Place};
pub use srdf::{DisabledPair, Group, Srdf, VirtualJoint};
pub use warning::Warning;
