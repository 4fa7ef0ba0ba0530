//! Attached objects: objects that a robot holds.

use std::sync::Arc;

use clearance_geometry::math::Pose;

use super::{Obstacle, ObstacleShape};

/// Index of an attached object in one `World`, in the order of attaching.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AttachedId(pub u32);

/// A rigid object attached to a link.
#[derive(Clone, Debug)]
pub struct AttachedObject {
    /// Name of the object.
    pub name: String,
    /// Name of the link that the object is attached to.
    pub link: String,
    /// Pose of the object in the frame of that link.
    pub pose_lo: Pose,
    /// Shapes with poses in the frame of the object.
    pub shapes: Arc<[ObstacleShape]>,
    /// Named frames on the object, in its frame.
    pub subframes: Vec<(String, Pose)>,
    /// Links that may touch the object, in addition to the link that carries it.
    pub touch_links: Vec<String>,
}

impl AttachedObject {
    /// The attached object that an obstacle becomes when a link grasps it; `pose_rl` is the link's pose in the root frame at that time.
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

    /// The obstacle that it becomes when it is detached.
    #[must_use]
    pub fn released(&self, pose_rl: &Pose) -> Obstacle {
        Obstacle {
            name: self.name.clone(),
            pose_ro: pose_rl * self.pose_lo,
            shapes: Arc::clone(&self.shapes),
            subframes: self.subframes.clone(),
        }
    }

    /// True if contact with the link is allowed.
    #[must_use]
    pub fn may_touch(&self, link: &str) -> bool {
        self.link == link || self.touch_links.iter().any(|touched| touched == link)
    }
}
