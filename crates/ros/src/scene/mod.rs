//! The world interface: MoveIt's scene topics and services. Converts messages to scene changes, and the scene to messages.
//!
//! ```text
//! planning_scene, collision_object, … ─┐                       ┌─> monitored_planning_scene
//! the scene of move_group ─> asking ─> │
//! octomaps, clouds, tf ────────────> topics ──> loader ──> monitor
//! apply_planning_scene, clear_octomap ─┘          │ the scene in force
//! get_planning_scene, check_state_validity <──────┘
//! ```

mod clouds;
mod monitored;
mod octomaps;
mod orders;
mod reading;
mod scene_messages;
mod scene_request;
mod services;
#[cfg(test)]
mod tests;
mod topics;
mod validity;

pub use clouds::{CloudMessage, CloudReport, decode, is_at_origin};
pub use monitored::Monitored;
pub use orders::{
    CLEAR_OCTOMAP, attached_order, clear_octomap, object_order, octomap_order, scene_order, unreadable_order,
    world_order,
};
pub use services::SceneServices;
pub use topics::{OCTOMAP_SOURCE, SceneTopics, Shared, Transforms, note_transforms};
pub use validity::{Situation, state_validity};
