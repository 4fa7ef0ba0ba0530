//! The scene of the loader: conversion of messages, storage, and what is missing in it.
//!
//! ```text
//! planning_scene, collision_object, … ─> topics ─┐
//! apply_planning_scene, … ────────> services ────┤─> scene commands ─> loader ─> loader scene ─> checker ─> monitor
//! octomaps, clouds, tf ───────────> topics ──────┘
//! ```

pub mod active_scene; // the robot and the scene in use
pub mod cloud_inbox; // received point clouds that wait for the loader
pub mod cloud_topic_status; // status of one cloud topic: time and report of its last cloud
pub mod command_conversion; // scene messages to scene commands
pub mod file_obstacles; // obstacles of world files, which messages may remove
pub mod loader_command; // commands of the loader
pub mod loader_scene; // the scene of the loader
pub mod lost_messages; // scene messages that were lost
pub mod missing_objects; // objects that were rejected
pub mod obstacle_state_reader; // states of obstacles to scene changes
pub mod octomap_messages; // octomap messages to scene changes
pub mod point_cloud_decoder; // decoder of `PointCloud2`
pub mod scene_checker; // checker of a robot in a scene
pub mod scene_command; // loader command for one scene message
pub mod scene_command_sender; // sender of scene commands to the loader
pub mod scene_message_reader; // scene messages to scene changes
pub mod scene_message_writer; // the scene to messages
pub mod scene_update_context; // snapshot that updates are applied against
pub mod shared_state; // state shared between threads
pub mod transform_messages; // transforms to poses and to the transform tree
pub mod whole_scene; // whether the complete scene was received

#[cfg(test)]
pub mod tests; // tests, and helpers of other tests
