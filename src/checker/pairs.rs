//! Which pairs are checked: decided once, with the reason for each that is not.

use super::AllowedCollisionMatrix;
use crate::robot::{LinkId, RobotModel};
use crate::world::{ObstacleId, World};

/// The pairs to check, and how many were left out and why.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairList {
    self_pairs: Vec<(LinkId, LinkId)>,
    world_pairs: Vec<(LinkId, ObstacleId)>,
    skipped: [usize; 4],
}

/// Why a pair is not checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkipReason {
    /// The links are joined by fixed joints only.
    SameRigidBody,
    /// The links' rigid bodies are joined by one moving joint, and there is no SRDF to say otherwise.
    Adjacent,
    /// The SRDF disables the pair.
    Disabled,
    /// The planning scene's allowed collision matrix allows contact.
    Allowed,
}

impl SkipReason {
    pub const ALL: [Self; 4] = [Self::SameRigidBody, Self::Adjacent, Self::Disabled, Self::Allowed];
}

impl std::fmt::Display for SkipReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::SameRigidBody => "same rigid body",
            Self::Adjacent => "adjacent rigid bodies (no SRDF)",
            Self::Disabled => "disabled by the SRDF",
            Self::Allowed => "allowed by the collision matrix",
        })
    }
}

impl PairList {
    /// Pairs of links that have geometry, and of those with obstacles.
    ///
    /// A scene's matrix replaces what the SRDF disables, as in MoveIt; without either, adjacent rigid bodies are
    /// skipped.
    #[must_use]
    pub fn new(robot: &RobotModel, world: &World, scene: Option<&AllowedCollisionMatrix>) -> Self {
        let solid: Vec<LinkId> =
            (robot.link_ids()).filter(|l| !robot.link(*l).collisions.is_empty()).collect();
        let mut list = Self::default();
        list.add_self_pairs(robot, &solid, scene);
        list.add_world_pairs(robot, &solid, world, scene);
        list
    }

    fn add_self_pairs(
        &mut self,
        robot: &RobotModel,
        solid: &[LinkId],
        scene: Option<&AllowedCollisionMatrix>,
    ) {
        let srdf = robot.srdf().map(|_| AllowedCollisionMatrix::from_srdf(robot));
        for (i, &a) in solid.iter().enumerate() {
            for &b in &solid[i + 1..] {
                let (name_a, name_b) = (&robot.link(a).name, &robot.link(b).name);
                let reason = if robot.same_rigid_body(a, b) {
                    Some(SkipReason::SameRigidBody)
                } else if let Some(scene) = scene {
                    scene.allows(name_a, name_b).then_some(SkipReason::Allowed)
                } else if let Some(srdf) = &srdf {
                    srdf.allows(name_a, name_b).then_some(SkipReason::Disabled)
                } else {
                    (robot.adjacent_rigid_bodies(a, b)).then_some(SkipReason::Adjacent)
                };
                match reason {
                    Some(reason) => self.skipped[reason as usize] += 1,
                    None => self.self_pairs.push((a, b)),
                }
            }
        }
    }

    fn add_world_pairs(
        &mut self,
        robot: &RobotModel,
        solid: &[LinkId],
        world: &World,
        scene: Option<&AllowedCollisionMatrix>,
    ) {
        for &link in solid {
            for obstacle in world.ids() {
                let names = (&robot.link(link).name, &world.obstacle(obstacle).name);
                if scene.is_some_and(|m| m.allows(names.0, names.1)) {
                    self.skipped[SkipReason::Allowed as usize] += 1;
                } else {
                    self.world_pairs.push((link, obstacle));
                }
            }
        }
    }

    #[must_use]
    pub fn self_pairs(&self) -> &[(LinkId, LinkId)] {
        &self.self_pairs
    }

    #[must_use]
    pub fn world_pairs(&self) -> &[(LinkId, ObstacleId)] {
        &self.world_pairs
    }

    /// Number of pairs that are checked.
    #[must_use]
    pub fn len(&self) -> usize {
        self.self_pairs.len() + self.world_pairs.len()
    }

    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Why pairs are left out, and how many for each reason that occurs.
    pub fn skipped(&self) -> impl Iterator<Item = (SkipReason, usize)> {
        (SkipReason::ALL.into_iter().zip(self.skipped)).filter(|(_, count)| *count > 0)
    }

    /// Leaves out all pairs of links, or all pairs with obstacles.
    pub(super) fn restricted(mut self, check_self: bool, check_world: bool) -> Self {
        if !check_self {
            self.self_pairs.clear();
        }
        if !check_world {
            self.world_pairs.clear();
        }
        self
    }
}
