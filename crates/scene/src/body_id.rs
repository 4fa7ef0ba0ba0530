//! The bodies of a scene, as pairs of them are checked.

use clearance_robot::LinkId;

use super::{AttachedId, ObstacleId};

/// One of the two bodies of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BodyId {
    Link(LinkId),
    /// An object that a link carries.
    Attached(AttachedId),
    Obstacle(ObstacleId),
}
