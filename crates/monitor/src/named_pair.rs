//! Bodies and pairs of bodies by their types and names, which stay the same when the world changes.

use clearance_checker::CollisionChecker;
use clearance_scene::BodyId;

/// Type of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BodyKind {
    /// A link of the robot.
    Link,
    /// An object attached to a link.
    Attached,
    /// An obstacle.
    Obstacle,
}

impl From<BodyId> for BodyKind {
    fn from(body: BodyId) -> Self {
        match body {
            BodyId::Link(_) => Self::Link,
            BodyId::Attached(_) => Self::Attached,
            BodyId::Obstacle(_) => Self::Obstacle,
        }
    }
}

/// A body by its name, which stays the same when the world changes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NamedBody {
    /// Type of the body.
    pub kind: BodyKind,
    /// Name of the link, object or obstacle.
    pub name: String,
}

/// Two bodies by their names, in ascending order.
pub type NamedPair = [NamedBody; 2];

/// Names the bodies of a pair.
pub(super) fn named((a, b): (BodyId, BodyId), checker: &CollisionChecker) -> NamedPair {
    let mut pair =
        [a, b].map(|body| NamedBody { kind: body.into(), name: checker.body_name(body).to_owned() });
    pair.sort();
    pair
}
