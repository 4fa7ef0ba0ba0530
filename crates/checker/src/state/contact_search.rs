//! Search for any contact of a robot in one state; stops at the first.

use clearance_geometry::simd::{LANES, dispatch};
use clearance_proximity::Scratch;
use clearance_robot::Configuration;

use crate::pairs::{CheckedPairs, ObstacleContacts, ObstacleScratch, PairsAroundStart, PlacedRobot};
use crate::robot::{PairPriority, set_bits};

/// One state, with the memory that the search uses.
pub struct ContactSearch<'a> {
    pub pairs: &'a CheckedPairs,
    pub robot: &'a mut PlacedRobot,
    pub priority: &'a mut PairPriority,
    pub obstacles: &'a mut ObstacleScratch,
    pub scratch: &'a mut Scratch,
    /// Memory of self pairs, if the state is near a start.
    pub start: Option<&'a mut PairsAroundStart>,
}

impl ContactSearch<'_> {
    /// True if a pair touches.
    pub fn any_contact(&mut self, q: &Configuration) -> bool {
        self.any_contact_at(q.positions())
    }

    /// As [`Self::any_contact`], with the positions of a configuration.
    pub fn any_contact_at(&mut self, positions: &[f64]) -> bool {
        let level = self.scratch.level();
        dispatch!(level, simd => {
            self.scratch.work.volume_tests += self.pairs.self_pairs().count() as u64;
            self.robot.screen_for_contact(simd, self.pairs, positions);
            if self.robot.near().iter().any(|group| *group != 0) && self.any_self_contact() {
                return true;
            }
            let Self { pairs, robot, obstacles, scratch, .. } = self;
            let is_expected = pairs.world().reachable().is_expected(positions);
            let segments = robot.segments(pairs);
            ObstacleContacts { pairs, obstacles, scratch }
                .any_in_state(simd, segments, is_expected, &|body| robot.frame(body))
        })
    }

    /// True if parts touch, given placed bodies and screened pairs; pairs that are likely to collide are tested first.
    #[inline(never)]
    fn any_self_contact(&mut self) -> bool {
        let Self { pairs, robot, priority, scratch, start, .. } = self;
        let (near, frames) = (robot.near(), robot.frames());
        let is_near = |i: usize| near[i / LANES] & (1 << (i % LANES)) != 0;
        let mut touches = |i: usize| match start {
            Some(start) => start.are_within(0.0, (*pairs, i), frames, scratch),
            None => pairs.pair(i, frames).touches(scratch),
        };
        for rank in 0.. {
            let Some(i) = priority.get(rank) else { break };
            if is_near(i) && touches(i) {
                priority.hit(i);
                return true;
            }
        }
        let other = set_bits(near).find(|i| !priority.contains(*i) && touches(*i));
        if let Some(hit) = other {
            priority.hit(hit);
        }
        other.is_some()
    }
}
