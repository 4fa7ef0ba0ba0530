//! Kinds of pairs: self pairs and world pairs.

use clearance_scene::BodyId;

/// Kind of a checked pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairKind {
    /// Two bodies of the robot: links, or objects attached to links.
    SelfPair,
    /// A body of the robot and an obstacle.
    WorldPair,
}

impl PairKind {
    /// Both kinds, in the order of the pair numbers.
    pub const ALL: [Self; 2] = [Self::SelfPair, Self::WorldPair];

    /// The kind of a pair with this second body. The first body of every pair is one of the robot.
    #[must_use]
    pub fn of_second(body: BodyId) -> Self {
        match body {
            BodyId::Link(_) | BodyId::Attached(_) => Self::SelfPair,
            BodyId::Obstacle(_) => Self::WorldPair,
        }
    }
}

/// The pairs that a search considers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchedPairs {
    All,
    Only(PairKind),
}

impl SearchedPairs {
    pub fn include(self, kind: PairKind) -> bool {
        self == Self::All || self == Self::Only(kind)
    }
}
