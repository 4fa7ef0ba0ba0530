//! Robot models: links and joints from URDF and SRDF, and the poses of the links for given joint positions.
//!
//! | content | file |
//! |---|---|
//! | loading of a robot from its texts and files | `robot_text` |
//! | robot model; a joint and its limits; ids | `model`, `joint`, `ids` |
//! | errors and warnings about a robot description | `model_error`, `fault`, `warning` |
//! | URDF: validation of the text, construction of the model | `urdf_validation`, `urdf_reader` |
//! | tree of links and joints, leaders of mimic joints | `kinematic_tree`, `mimic_resolution` |
//! | SRDF: its content, its reader | `srdf`, `srdf_reader` |
//! | limits of names and of the number of pairs; prefixes of names | `name_length`, `pair_limit`, `link_prefix` |
//! | XML: documents and their limits, escaping | `xml`, `xml_limits`, `xml_escaping` |
//! | names and numbers in texts and messages | `decimal_numbers`, `quoted_names`, `similar_names` |
//! | meshes: names, files, readers of the formats | `mesh_name`, `mesh_files`, `loaded_mesh`, `mesh_formats` |
//! | errors about mesh files | `mesh_file_error`, `missing_meshes` |
//! | log of meshes for recordings, meshes of a recording | `mesh_log`, `recorded_meshes` |
//! | visual geometry, which no query uses | `visual_geometry` |
//! | configurations and their errors | `configuration`, `configuration_error` |
//! | configurations from joint names, groups and named states | `named_joints`, `joint_group`, `group_state_configuration` |
//! | planar and floating joints given as transforms | `joint_transforms` |
//! | ranges of positions; joints beyond their limits | `position_ranges`, `outside_limits` |
//! | tracking tolerances | `uniform_tolerance` |
//! | interpolated and random configurations | `interpolation`, `random_configuration` |
//! | poses of all links; kinematics and motion bounds of the checker | `kinematics`, `chain` |

#![deny(missing_docs)]
// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod chain;
mod configuration;
mod configuration_error;
mod decimal_numbers;
mod fault;
mod group_state_configuration;
mod ids;
mod interpolation;
mod joint;
mod joint_group;
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
mod model_error;
mod name_length;
mod named_joints;
mod outside_limits;
mod pair_limit;
mod position_ranges;
mod quoted_names;
mod random_configuration;
mod recorded_meshes;
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
pub use group_state_configuration::GroupStateError;
pub use ids::{JointId, LinkId};
pub use joint::{Joint, JointKind, Limits, Mimic};
pub use joint_group::{JointGroup, UnknownGroup};
pub use joint_transforms::JointTransformError;
pub use kinematics::LinkPoses;
pub use loaded_mesh::LoadedMesh;
pub use mesh_file_error::MeshFileError;
pub use mesh_files::{MeshFiles, check_package_path};
pub use mesh_log::{MeshLog, MeshUse};
pub use model::{Collision, Link, MeshSource, RobotModel};
pub use model_error::ModelError;
pub use name_length::check_name_length;
pub use named_joints::{MIMIC_TOLERANCE, NamedJoints};
pub use outside_limits::OutsideLimits;
pub use quoted_names::{quoted, quoted_list};
pub use random_configuration::SamplingBox;
pub use recorded_meshes::RecordedMeshes;
pub use robot_text::RobotText;
pub use srdf::{DisabledPair, Group, GroupState, Srdf, VirtualJoint};
pub use visual_geometry::VisualGeometry;
pub use warning::Warning;
pub use xml_escaping::xml_attribute;
