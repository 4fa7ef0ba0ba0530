//! Pair numbers, and the bodies they refer to.

use clearance_geometry::math::MatrixPose;
use clearance_robot::{Frame, KinematicPath};
use clearance_scene::ObstacleId;

use super::collision_checker::CollisionChecker;
use super::pair::{Pair, PairInfo};
use clearance_scene::BodyId;

/// The bodies of a pair: indices of two robot parts, or of a robot part and the place of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PairNumber {
    /// Index in the list of self pairs.
    OfParts(usize),
    WithObstacle {
        part: usize,
        place: usize,
    },
}

impl CollisionChecker {
    pub(super) fn number(&self, index: usize) -> PairNumber {
        match index.checked_sub(self.infos.len()) {
            None => PairNumber::OfParts(index),
            Some(rest) => {
                let places = self.obstacles.place_count();
                PairNumber::WithObstacle { part: rest / places, place: rest % places }
            }
        }
    }

    /// The number of the pair of a part and the obstacle at a place.
    pub(super) fn world_pair(&self, part: usize, place: usize) -> usize {
        self.infos.len() + part * self.obstacles.place_count() + place
    }

    /// True if this is the number of a pair that is checked.
    pub(super) fn is_pair(&self, index: usize) -> bool {
        index < self.infos.len()
            || (index - self.infos.len() < self.robot_bodies.len() * self.obstacles.place_count())
                && match self.number(index) {
                    PairNumber::WithObstacle { part, place } => self.pairs().checks(part, id(place)),
                    PairNumber::OfParts(_) => true,
                }
    }

    /// The number of the pair of two bodies, if it is checked.
    pub(super) fn number_of(&self, bodies: (BodyId, BodyId)) -> Option<usize> {
        let BodyId::Obstacle(id) = bodies.1 else {
            return self.infos.iter().position(|info| info.ids == bodies);
        };
        let part = self.robot_bodies.iter().position(|robot_body| robot_body.id == bodies.0)?;
        let place = usize::try_from(id.0).ok().filter(|place| *place < self.obstacles.place_count())?;
        Some(self.world_pair(part, place)).filter(|index| self.is_pair(*index))
    }

    /// The numbers of all pairs that are checked, ascending.
    pub(super) fn all_pairs(&self) -> impl Iterator<Item = usize> {
        (0..self.infos.len()).chain(self.all_world_pairs())
    }

    /// The numbers of the pairs with obstacles.
    pub(super) fn all_world_pairs(&self) -> impl Iterator<Item = usize> {
        let places = self.obstacles.place_count();
        let all =
            (0..self.robot_bodies.len()).flat_map(move |part| (0..places).map(move |place| (part, place)));
        all.filter(|(part, place)| self.pairs().checks(*part, id(*place)))
            .map(|(part, place)| self.world_pair(part, place))
    }

    pub(super) fn info(&self, index: usize) -> PairInfo {
        match self.number(index) {
            PairNumber::OfParts(index) => self.infos[index],
            PairNumber::WithObstacle { part, place } => PairInfo {
                ids: (self.robot_bodies[part].id, BodyId::Obstacle(id(place))),
                bodies: (part, place),
                padding: self.robot_bodies[part].padding + self.obstacles.at(place).padding,
            },
        }
    }

    /// The joints between the bodies of a pair.
    pub(super) fn between(&self, index: usize) -> KinematicPath<'_> {
        match self.number(index) {
            PairNumber::OfParts(index) => {
                let (a, b) = self.infos[index].bodies;
                let bodies = [a, b].map(|part| self.robot_bodies[part].body);
                self.paths_to_root.between(bodies, self.joints_between[index].map(|joints| joints as usize))
            }
            PairNumber::WithObstacle { part, .. } => self.to_root(part),
        }
    }

    /// The joints between a part and the root.
    pub(super) fn to_root(&self, part: usize) -> KinematicPath<'_> {
        self.paths_to_root.to_root(self.robot_bodies[part].body)
    }

    /// A pair, with the poses of the chain's bodies.
    pub(super) fn pair_with(&self, index: usize, frame: impl Fn(usize) -> Frame<f64>) -> Pair<'_> {
        let info = self.info(index);
        let pose = |part: usize| MatrixPose::from(&frame(self.robot_bodies[part].body));
        let a = &self.robot_bodies[info.bodies.0];
        let pose_ra = pose(info.bodies.0);
        let (b, pose_rb) = match info.ids.1 {
            BodyId::Obstacle(_) => {
                let obstacle = self.obstacles.at(info.bodies.1);
                (&obstacle.solid, obstacle.pose_ro)
            }
            _ => (&self.robot_bodies[info.bodies.1].solid, pose(info.bodies.1)),
        };
        Pair { info, bodies: (&a.solid, b), pose_ra, pose_ab: pose_ra.relative(&pose_rb) }
    }
}

fn id(place: usize) -> ObstacleId {
    ObstacleId(u32::try_from(place).expect("ids are of 32 bits"))
}
