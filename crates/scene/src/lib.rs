//! The scene around a robot, as in `moveit_msgs`: obstacles, attached objects, allowed collisions, paddings, frames.
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
//! parts of a message leave a [`SceneGap`], which makes the state UNKNOWN.

#![deny(missing_docs)]
// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod allowed_collision_matrix;
mod anchor;
mod anchor_frames;
mod anchor_updates;
mod applied;
mod apply;
mod attached_changes;
mod attached_object;
mod body_id;
mod check_settings;
mod cloud;
mod file_octree;
mod files;
mod frame_ancestor;
mod frame_lookup;
mod frame_path;
mod frame_remarks;
mod gap_closing;
mod message_shapes;
mod multi_dof_joint;
mod named_state;
mod names_without_effect;
mod object_changes;
mod obstacle;
mod obstacle_states;
mod octomap;
mod octomap_placement;
mod pair_entries;
mod pair_list;
mod scene;
mod scene_context;
mod scene_gap;
mod scene_rejection;
mod scene_update;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod timestamp;
mod transform;
mod transform_tree;
mod volume_selection;
mod whole_scene_changes;
mod world;

pub use allowed_collision_matrix::{AllowedCollisionMatrix, MatrixEntries, MatrixError};
pub use anchor::{LEAST_MOTION, is_elsewhere};
pub use anchor_frames::{AnchorFrames, RootPoseLoss, TrackedFrame};
pub use applied::Applied;
pub use attached_object::{AttachedId, AttachedObject};
pub use body_id::BodyId;
pub use check_settings::{MeshModel, Settings};
pub use cloud::{
    ByteOrder, CloudError, CloudPoints, Column, Columns, NumberKind, is_at_origin, is_cloud, read_cloud,
};
pub use file_octree::FileOctree;
pub use files::RobotStateText;
pub use files::{SceneError, SceneLoader, StateList, WorldFileKind};
pub use frame_path::{FramePath, PathLink};
pub use message_shapes::{mesh, message_pose, placed_shapes, plane, solid, solid_type};
pub use multi_dof_joint::{MultiDofJoint, VirtualJointRole};
pub use named_state::NamedState;
pub use obstacle::{OCTOMAP, Obstacle, ObstacleId, ObstacleShape};
pub use obstacle_states::{ObstacleState, ObstacleStates, ObstacleTwist};
pub use octomap::{Cell, Octomap, OctomapError, Space};
pub use octomap_placement::OctomapMessage;
pub use pair_list::{PairList, SkipReason};
pub use scene::{DroppedParts, Scene};
pub use scene_context::SceneContext;
pub use scene_gap::{GapExtent, GapSubject, SceneGap};
pub use scene_rejection::SceneRejection;
pub use scene_update::{
    AttachedChange, FixedFrame, ObjectChange, OctomapPlacement, Operation, RobotStateChange, SceneChange,
    SceneUpdate, StatedPositions, WorldChange,
};
pub use timestamp::Time;
pub use transform::Transform;
pub use transform_tree::{NumberedPose, TransformTree};
pub use volume_selection::{VolumeSelection, VolumeSelectionError};
pub use world::{World, WorldError};
