//! Robot models: links and joints from URDF and SRDF, and the poses of the links for given joint positions.

#![deny(missing_docs)]
// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod chain;
mod configuration;
mod configuration_error;
mod decimal_numbers;
mod fault;
mod group_states;
mod ids;
mod interpolation;
mod joint;
mod joint_group;
mod joint_limits;
mod joint_transforms;
mod kinematic_tree;
mod kinematics;
mod link_prefix;
mod loaded_mesh;
mod mesh_file_error;
mod mesh_files;
mod mesh_formats;
mod mesh_log;
mod mesh_name;
mod mimic_resolution;
mod missing_meshes;
mod model;
mod name_length;
mod named_joints;
mod pair_limit;
mod position_ranges;
mod quoted_names;
mod random_configuration;
mod robot_text;
mod similar_names;
mod srdf;
mod srdf_reader;
mod uniform_tolerance;
mod urdf_reader;
mod urdf_validation;
mod visual_geometry;
mod warning;
mod xml;
mod xml_escaping;
mod xml_limits;

pub use chain::{
    Chain, ChainJoint, Deviation, Deviations, DisplacementRates, Frame, KinematicPath, LinkInBody, Motion,
    MotionBound, PathsToRoot, PointAlong, Reach, ReachableRegion, SideMotion, Source as PositionSource,
};
pub use chain::{Columns, PlacedFrame};
pub use configuration::Configuration;
pub use configuration_error::{ConfigurationError, MimicContradiction};
pub use fault::{Fault, Place};
pub use group_states::GroupStateError;
pub use ids::{JointId, LinkId};
pub use joint::{Joint, JointKind, Limits, Mimic};
pub use joint_group::{JointGroup, UnknownGroup};
pub use joint_limits::OutsideLimits;
pub use joint_transforms::JointTransformError;
pub use kinematics::LinkPoses;
pub use loaded_mesh::LoadedMesh;
pub use mesh_file_error::MeshFileError;
pub use mesh_files::{MeshFiles, check_package_path};
pub use mesh_log::{MeshLog, MeshUse, RecordedMeshes};
pub use model::{Collision, Link, MeshSource, ModelError, RobotModel};
pub use name_length::check_name_length;
pub use named_joints::{MIMIC_TOLERANCE, NamedJoints};
pub use quoted_names::{quoted, quoted_list};
pub use random_configuration::SamplingBox;
pub use robot_text::RobotText;
pub use srdf::{DisabledPair, Group, GroupState, Srdf, VirtualJoint};
pub use visual_geometry::VisualGeometry;
pub use warning::Warning;
pub use xml_escaping::xml_attribute;
