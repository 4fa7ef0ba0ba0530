//! The scene around a robot: obstacles, attached objects, allowed collisions, paddings and frames, as `moveit_msgs` describes them.
//!
//! Messages and files are converted to the same [`SceneUpdate`]s, which [`Scene::apply`] applies as MoveIt 2 does. No I/O and no ROS
//! types. A rejected object or field changes nothing.
//!
//! | update | effect |
//! |---|---|
//! | [`ObjectChange`] | adds, replaces, extends, moves or removes one obstacle, or removes all |
//! | [`AttachedChange`] | attaches an object to a link, or detaches it where it is |
//! | [`WorldChange`] | replaces all obstacles |
//! | [`SceneChange`] | a whole scene replaces everything; a difference changes only the parts it contains |
//!
//! Deliberate differences from MoveIt: a whole scene without allowed collision matrix restores the SRDF's. A name that cannot be resolved
//! is rejected, and is not taken as the planning frame. APPEND of a single shape to an object uses the shape's pose unchanged. Rejected
//! parts of a message leave a [`Gap`], which makes the state UNKNOWN.

#![warn(missing_docs)]
// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod allowed_collision_matrix;
mod anchors;
mod attached_changes;
mod attached_object;
mod body_id;
mod change;
mod cloud;
mod files;
mod frame_remarks;
mod frames;
mod gaps;
mod ineffective;
mod named_state;
mod object_changes;
mod obstacle;
mod octomap;
mod octomap_placement;
mod pair_list;
mod rejection;
mod scene;
mod scene_changes;
mod settings;
mod shapes;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod time;
mod transform_tree;
mod way;
mod world;

pub use allowed_collision_matrix::{AllowedCollisionMatrix, MatrixEntries, MatrixError};
pub use anchors::AnchorFrames;
pub use anchors::{Lost, TrackedFrame, is_elsewhere};
pub use attached_object::{AttachedId, AttachedObject};
pub use body_id::BodyId;
pub use change::{
    AttachedChange, FixedFrame, ObjectChange, OctomapPlacement, Operation, RobotStateChange, SceneChange,
    SceneUpdate, WorldChange,
};
pub use cloud::{ByteOrder, CloudError, CloudPoints, Column, Columns, NumberKind, is_cloud, read_cloud};
pub use files::RobotStateText;
pub use files::{SceneError, SceneLoader, StateList, WorldFileKind};
pub use frames::SceneContext;
pub use gaps::{Extent, Gap, Subject};
pub use named_state::NamedState;
pub use obstacle::{Obstacle, ObstacleId, ObstacleShape};
pub use octomap::{Cell, Octomap, OctomapError, Space};
pub use octomap_placement::OctomapMessage;
pub use pair_list::{PairList, SkipReason};
pub use rejection::SceneRejection;
pub use scene::{Applied, OCTOMAP, Scene, Unfit};
pub use settings::{MeshModel, Settings};
pub use shapes::{mesh, message_pose, placed_shapes, plane, solid, solid_type};
pub use time::Time;
pub use transform_tree::{Transform, TransformTree};
pub use way::{Link, Way};
pub use world::{World, WorldError};
