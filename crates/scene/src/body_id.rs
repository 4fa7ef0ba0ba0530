//! Identifiers of the bodies of a scene, which form the pairs to check.

use clearance_robot::LinkId;

use super::{AttachedId, ObstacleId};

/// One of the two bodies of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BodyId {
    /// A link of the robot.
    Link(LinkId),
    /// An attached object.
    Attached(AttachedId),
    /// An obstacle of the world.
    Obstacle(ObstacleId),
}
