//! One motion that is checked: its pairs placed at any time, with moving and uncertain obstacles.

use clearance_geometry::math::MatrixPose;
use clearance_geometry::simd::{Level, dispatch};
use clearance_motion::{MotionSegment, MovingObstacle};
use clearance_robot::{PlacedFrame, Reach};
use clearance_scene::BodyId;

use crate::pairs::{CheckedPairs, PairBodies, PosedPair};
use crate::world::WorldPair;

/// One motion, with the pairs that are checked along it.
#[derive(Clone, Copy)]
pub struct CheckedMotion<'c> {
    pub pairs: &'c CheckedPairs,
    pub segment: &'c MotionSegment,
    /// Distance (m) that the pairs have to keep, besides their paddings.
    pub margin: f64,
}

/// Scratch memory for the poses of one pair at one time.
pub struct PoseScratch<'w> {
    /// Poses of the chain's bodies; only those on the pair's kinematic path are computed.
    pub frames: &'w mut [PlacedFrame],
    pub positions: &'w mut [f64],
    pub level: Level,
}

/// A pair placed at one time, with the bounding volumes of its bodies.
pub struct PlacedPair<'c> {
    pub pair: PosedPair<'c>,
    pub reaches: [Reach; 2],
}

impl<'c> CheckedMotion<'c> {
    /// True if the motion is one of this robot, and moves only obstacles of this world.
    pub fn is_valid(&self) -> bool {
        let known = |name: &str| self.pairs.world().world().id(name).is_some();
        let positions = self.pairs.robot().model().position_names().len();
        self.segment.position_count() == positions
            && self.segment.obstacles().iter().all(|mover| known(&mover.name))
    }

    /// A pair at t; its padding includes the margin.
    pub fn placed_pair(&self, index: usize, t: f64, poses: &mut PoseScratch) -> PlacedPair<'c> {
        let Self { pairs, segment, margin } = *self;
        let (mut info, path) = (pairs.info(index), pairs.path_between(index));
        info.padding += margin;
        let PoseScratch { frames, positions, level } = poses;
        segment.positions_at(t, positions);
        dispatch!(*level, simd => pairs.robot().chain().frames_between(simd, &path, positions, frames));
        let a = &pairs.robot()[info.bodies.0];
        let pose_ra = MatrixPose::from(&frames[a.chain_body()]);
        let (solid, pose_rb, reach) = if let BodyId::Obstacle(_) = info.ids.1 {
            let b = pairs.world().obstacle(info.bodies.1);
            match self.mover(index) {
                Some(mover) => {
                    let pose = MatrixPose::from(&(mover.displacement(t) * b.pose()));
                    (b.solid(), pose, b.reach_at(&pose))
                }
                None => (b.solid(), *b.pose_ro(), b.reach()),
            }
        } else {
            let b = &pairs.robot()[info.bodies.1];
            let pose = MatrixPose::from(&frames[b.chain_body()]);
            (b.solid(), pose, b.reach_at(&pose))
        };
        let bodies = (a.solid(), solid);
        PlacedPair {
            reaches: [a.reach_at(&pose_ra), reach],
            pair: PosedPair { info, bodies, pose_ra, pose_ab: pose_ra.relative(&pose_rb) },
        }
    }

    /// The motion of a pair's obstacle, if it moves.
    pub fn mover(&self, index: usize) -> Option<&'c MovingObstacle> {
        if self.segment.obstacles().is_empty() {
            return None;
        }
        let PairBodies::PartAndObstacle(pair) = self.pairs.bodies(index) else { return None };
        let name = self.pairs.world().obstacle(pair.place).name();
        self.segment.obstacles().iter().find(|mover| mover.name == name)
    }

    /// Upper bound (m) on the unknown displacement of a pair's obstacle at t; 0 for a pair of robot bodies.
    pub fn uncertainty(&self, index: usize, t: f64) -> f64 {
        let Some(uncertainty) = self.segment.uncertainty() else { return 0.0 };
        let PairBodies::PartAndObstacle(pair) = self.pairs.bodies(index) else { return 0.0 };
        uncertainty.of(self.pairs.world().obstacle(pair.place).name(), t)
    }

    /// Upper bound (m) on the unknown displacement of any obstacle at t.
    pub fn largest_uncertainty(&self, t: f64) -> f64 {
        let world = self.pairs.world().world();
        self.segment.uncertainty().map_or(0.0, |uncertainty| uncertainty.largest(world, t))
    }

    /// The pairs of moving obstacles.
    pub fn pairs_of_movers(&self) -> impl Iterator<Item = usize> {
        let (pairs, movers) = (self.pairs, self.moving_places());
        let parts = 0..pairs.robot().parts().len();
        let all = parts
            .flat_map(move |part| movers.clone().into_iter().map(move |place| WorldPair { part, place }));
        all.map(|pair| pairs.world().number(pair)).filter(|pair| pairs.is_checked(*pair))
    }

    /// The places of moving obstacles, ascending.
    pub fn moving_places(&self) -> Vec<usize> {
        let world = self.pairs.world().world();
        let ids = self.segment.obstacles().iter().filter_map(|mover| world.id(&mover.name));
        let mut places: Vec<_> = ids.map(|id| id.0 as usize).collect();
        places.sort_unstable();
        places
    }
}
