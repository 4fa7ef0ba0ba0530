//! Things that a robot holds.

use std::sync::Arc;

use clearance_geometry::math::Pose;

use super::{Obstacle, ObstacleShape};

/// An attached object of one [`World`](super::World): its number in the order of attaching.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AttachedId(pub u32);

/// A rigid part that a link carries along.
#[derive(Clone, Debug)]
pub struct AttachedObject {
    pub name: String,
    /// The link that carries it.
    pub link: String,
    /// Pose of the object in the frame of that link.
    pub pose_lo: Pose,
    pub shapes: Arc<[ObstacleShape]>,
    pub subframes: Vec<(String, Pose)>,
    /// Links that may touch it, beside the one that carries it.
    pub touch_links: Vec<String>,
}

impl AttachedObject {
    /// The object, once a link has grasped it; `pose_rl` is the link's pose in the root frame then.
    #[must_use]
    pub fn grasped(object: &Obstacle, link: &str, pose_rl: &Pose, touch_links: Vec<String>) -> Self {
        Self {
            name: object.name.clone(),
            link: link.to_owned(),
            pose_lo: pose_rl.inverse() * object.pose_ro,
            shapes: Arc::clone(&object.shapes),
            subframes: object.subframes.clone(),
            touch_links,
        }
    }

    /// The obstacle that it becomes where it is let go.
    #[must_use]
    pub fn released(&self, pose_rl: &Pose) -> Obstacle {
        Obstacle {
            name: self.name.clone(),
            pose_ro: pose_rl * self.pose_lo,
            shapes: Arc::clone(&self.shapes),
            subframes: self.subframes.clone(),
        }
    }

    /// Whether a link may touch it.
    #[must_use]
    pub fn may_touch(&self, link: &str) -> bool {
        self.link == link || self.touch_links.iter().any(|touched| touched == link)
    }
}
