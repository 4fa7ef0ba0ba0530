//! All pairs that a checker checks, by number.

use std::sync::Arc;

use clearance_geometry::math::MatrixPose;
use clearance_proximity::SolidBody;
use clearance_robot::{Frame, KinematicPath, PlacedFrame, RobotModel};
use clearance_scene::{AllowedCollisionMatrix, BodyId, PairList, Settings, World};

use super::posed_pair::PosedPair;
use super::state_independent::StateIndependent;
use crate::pair_kind::PairKind;
use crate::robot::{PairInfo, RobotGeometry, SceneOfRobot, SelfPairs};
use crate::settings_error::SettingsError;
use crate::world::{WorldIndex, WorldPair, obstacle_id};

/// The robot, the world, and the pairs of bodies that are checked.
///
/// Pairs have numbers: first the self pairs in the order of their list, then for each robot part one number per place
/// of an obstacle.
#[derive(Clone, Debug)]
pub struct CheckedPairs {
    robot: RobotGeometry,
    self_pairs: SelfPairs,
    world: WorldIndex,
    state_independent: StateIndependent,
}

/// A pair of robot parts, or of a part and an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairBodies {
    /// Index in the list of self pairs.
    Parts(usize),
    PartAndObstacle(WorldPair),
}

impl CheckedPairs {
    /// Selects the pairs by a scene's matrix, if given, or else by SRDF or adjacency. Geometry of `known`, which has
    /// the same robot, is reused where it does not change.
    pub fn new(
        robot: Arc<RobotModel>,
        world: &World,
        settings: &Settings,
        matrix: Option<&AllowedCollisionMatrix>,
        known: Option<&Self>,
    ) -> Result<Self, SettingsError> {
        let pairs =
            PairList::new(&robot, world, matrix).restricted(settings.check_self, settings.check_world);
        let scene = SceneOfRobot { world, pairs: &pairs, settings };
        let robot = RobotGeometry::new(robot, scene, known.map_or(&[], |known| known.robot.parts()))?;
        let self_pairs = SelfPairs::new(&pairs, &robot, settings);
        let world = WorldIndex::new(world, pairs, settings, &robot, known.map(|known| &known.world))?;
        Ok(Self { robot, self_pairs, world, state_independent: StateIndependent::default() })
    }

    /// Replaces the world for the same robot and attached objects. If an error is returned, nothing has changed.
    pub fn set_world(&mut self, world: &World, settings: &Settings) -> Result<(), SettingsError> {
        self.world.set_world(world, settings)?;
        self.state_independent = StateIndependent::default();
        Ok(())
    }

    #[inline]
    pub fn robot(&self) -> &RobotGeometry {
        &self.robot
    }

    #[inline]
    pub fn self_pairs(&self) -> &SelfPairs {
        &self.self_pairs
    }

    #[inline]
    pub fn world(&self) -> &WorldIndex {
        &self.world
    }

    #[inline]
    pub fn state_independent(&self) -> &StateIndependent {
        &self.state_independent
    }

    /// Number of pairs that are checked.
    pub fn count(&self) -> usize {
        self.world.pair_list().len()
    }

    /// True if this is the number of a self pair.
    #[inline]
    pub fn is_self_pair(&self, index: usize) -> bool {
        index < self.self_pairs.count()
    }

    /// The kind of a pair.
    #[inline]
    pub fn kind(&self, index: usize) -> PairKind {
        if self.is_self_pair(index) { PairKind::SelfPair } else { PairKind::WorldPair }
    }

    /// True if pairs of this kind are checked.
    pub fn include(&self, kind: PairKind) -> bool {
        match kind {
            PairKind::SelfPair => self.self_pairs.count() > 0,
            PairKind::WorldPair => !self.world.is_empty(),
        }
    }

    /// The bodies of a pair.
    #[inline]
    pub fn bodies(&self, index: usize) -> PairBodies {
        match index.checked_sub(self.self_pairs.count()) {
            None => PairBodies::Parts(index),
            Some(rest) => PairBodies::PartAndObstacle(self.world.pair(rest)),
        }
    }

    /// True if this is the number of a pair that is checked.
    pub fn is_checked(&self, index: usize) -> bool {
        self.is_self_pair(index)
            || (index - self.self_pairs.count() < self.world.number_count())
                && match self.bodies(index) {
                    PairBodies::PartAndObstacle(pair) => self.world.checks(pair),
                    PairBodies::Parts(_) => true,
                }
    }

    /// The number of the pair of two bodies, if it is checked.
    pub fn number_of(&self, bodies: (BodyId, BodyId)) -> Option<usize> {
        let BodyId::Obstacle(id) = bodies.1 else {
            return self.self_pairs.infos().iter().position(|info| info.ids == bodies);
        };
        let part = self.robot.part_of(bodies.0)?;
        let places = self.world.obstacles().place_count();
        let place = usize::try_from(id.0).ok().filter(|place| *place < places)?;
        Some(self.world.number(WorldPair { part, place })).filter(|index| self.is_checked(*index))
    }

    /// The numbers of all pairs that are checked, ascending.
    pub fn numbers(&self) -> impl Iterator<Item = usize> {
        (0..self.self_pairs.count()).chain(self.world.pairs().map(|pair| self.world.number(pair)))
    }

    /// The name of a link or an object.
    pub fn body_name(&self, body: BodyId) -> &str {
        let world = self.world.world();
        match body {
            BodyId::Link(id) => &self.robot.model().link(id).name,
            BodyId::Attached(id) => &world.attached_object(id).name,
            BodyId::Obstacle(id) => &world.obstacle(id).name,
        }
    }

    /// The constants of a pair.
    #[inline]
    pub fn info(&self, index: usize) -> PairInfo {
        match self.bodies(index) {
            PairBodies::Parts(index) => self.self_pairs.infos()[index],
            PairBodies::PartAndObstacle(WorldPair { part, place }) => PairInfo {
                ids: (self.robot[part].id(), BodyId::Obstacle(obstacle_id(place))),
                bodies: (part, place),
                padding: self.robot[part].padding() + self.world.obstacle(place).padding(),
            },
        }
    }

    /// The joints between the bodies of a pair.
    pub fn path_between(&self, index: usize) -> KinematicPath<'_> {
        match self.bodies(index) {
            PairBodies::Parts(index) => self.self_pairs.path_between(index, &self.robot),
            PairBodies::PartAndObstacle(pair) => self.robot.path_to_root(pair.part),
        }
    }

    /// The bodies of a pair for queries of penetration depth.
    pub fn solids(&self, index: usize) -> [&SolidBody; 2] {
        match self.bodies(index) {
            PairBodies::Parts(index) => {
                let (a, b) = self.self_pairs.infos()[index].bodies;
                [self.robot[a].solids(), self.robot[b].solids()]
            }
            PairBodies::PartAndObstacle(WorldPair { part, place }) => {
                [self.robot[part].solids(), self.world.obstacle(place).solids()]
            }
        }
    }

    /// A pair at the poses of the chain's bodies in the root frame.
    #[inline]
    pub fn pair(&self, index: usize, frames: &[PlacedFrame]) -> PosedPair<'_> {
        self.pair_with(index, |body| frames[body].frame())
    }

    /// As [`Self::pair`], from frames by number of chain body.
    pub fn pair_with(&self, index: usize, frame: impl Fn(usize) -> Frame<f64>) -> PosedPair<'_> {
        let info = self.info(index);
        let pose = |part: usize| MatrixPose::from(&frame(self.robot[part].chain_body()));
        let a = &self.robot[info.bodies.0];
        let pose_ra = pose(info.bodies.0);
        let (b, pose_rb) = match info.ids.1 {
            BodyId::Obstacle(_) => {
                let obstacle = self.world.obstacle(info.bodies.1);
                (obstacle.solid(), *obstacle.pose_ro())
            }
            _ => (self.robot[info.bodies.1].solid(), pose(info.bodies.1)),
        };
        PosedPair { info, bodies: (a.solid(), b), pose_ra, pose_ab: pose_ra.relative(&pose_rb) }
    }
}
