//! Batch query, whether states are free: eight states in SIMD lanes, then the remaining pairs one by one.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, dispatch, f64x8};
use clearance_proximity::Scratch;
use clearance_robot::Configuration;

use super::eight_states::EightStates;
use crate::capsules::round_up;
use crate::pairs::{CheckedPairs, ObstacleContacts, ObstacleScratch, StatesInLanes};
use crate::robot::{CandidatePair, PairPriority};
use crate::world::PartQuery;

/// Search for contacts in many states, with the memory that it uses.
pub struct BatchSearch<'a> {
    pub pairs: &'a CheckedPairs,
    pub priority: &'a mut PairPriority,
    pub obstacles: &'a mut ObstacleScratch,
    pub candidates: &'a mut Vec<CandidatePair>,
    pub scratch: &'a mut Scratch,
}

impl BatchSearch<'_> {
    /// Writes for each state whether it is free.
    pub fn find_free(&mut self, states: &[Configuration], free: &mut [bool]) {
        let level = self.scratch.level();
        dispatch!(level, simd => self.find_free_in_lanes(simd, states, free));
    }

    /// Number of pairs, over all states, that level 0 passes on to the hierarchies. Runs only kinematics and capsules.
    pub fn count_near_pairs(&mut self, states: &[Configuration]) -> u64 {
        let level = self.scratch.level();
        dispatch!(level, simd => {
            let mut eight = EightStates::new(self.pairs, simd);
            let mut count = 0;
            for states in states.chunks(LANES) {
                self.screen(simd, states, &mut eight);
                let lanes = u8::MAX >> (LANES - states.len());
                count += eight.near().iter().map(|near| u64::from((near & lanes).count_ones())).sum::<u64>();
                for lane in 0..states.len() {
                    count += self.count_near_obstacles(&eight, lane);
                }
            }
            count
        })
    }

    fn count_near_obstacles<S: Simd>(&mut self, eight: &EightStates<S>, lane: usize) -> u64 {
        let Self { pairs, obstacles, candidates, scratch, .. } = self;
        candidates.clear();
        for (part, robot_body) in pairs.robot().parts().iter().enumerate() {
            let capsule = robot_body.padded_capsule(&eight.frame(robot_body.chain_body(), lane));
            let query = PartQuery::new(part, &capsule, CONTACT_DISTANCE);
            pairs.world().candidates(query, &mut obstacles.broad_phase, scratch, candidates);
        }
        candidates.len() as u64
    }

    /// Runs level 0 on eight states at once, then tests the remaining pairs one by one.
    #[inline(always)]
    fn find_free_in_lanes<S: Simd>(&mut self, simd: S, states: &[Configuration], free: &mut [bool]) {
        let pairs = self.pairs;
        let mut eight = EightStates::new(pairs, simd);
        for (states, free) in states.chunks(LANES).zip(free.chunks_mut(LANES)) {
            self.screen(simd, states, &mut eight);
            self.scratch.work.volume_tests += (pairs.self_pairs().count() * states.len()) as u64;
            let all = u8::MAX >> (LANES - states.len());
            let mut hit = 0u8;
            for rank in 0.. {
                let Some(i) = self.priority.get(rank) else { break };
                let near = eight.take_near(i);
                hit |= self.states_in_contact(i, near & all & !hit, &eight);
            }
            for i in 0..eight.near().len() {
                hit |= self.states_in_contact(i, eight.near()[i] & all & !hit, &eight);
            }
            let origins = eight.origins(pairs);
            let capsules = |part: usize| eight.padded_capsule(simd, pairs, part, origins);
            let reachable = pairs.world().reachable();
            let are_expected = states.iter().all(|q| reachable.is_expected(q.positions()));
            let left = StatesInLanes { among: all & !hit, are_expected };
            let mut obstacles =
                ObstacleContacts { pairs, obstacles: &mut *self.obstacles, scratch: &mut *self.scratch };
            hit |= obstacles.states_in_contact(simd, left, capsules, &|body, lane| eight.frame(body, lane));
            for (lane, free) in free.iter_mut().enumerate() {
                *free = hit & (1 << lane) == 0;
            }
        }
    }

    /// Bit mask of the states in which a self pair touches.
    #[inline(always)]
    fn states_in_contact<S: Simd>(&mut self, pair: usize, mut states: u8, eight: &EightStates<S>) -> u8 {
        let mut hit = 0;
        while states != 0 {
            let lane = states.trailing_zeros() as usize;
            states &= states - 1;
            if self.pairs.pair_with(pair, |body| eight.frame(body, lane)).touches(self.scratch) {
                hit |= 1 << lane;
                self.priority.hit(pair);
            }
        }
        hit
    }

    /// Level 0 of some states. A short block repeats its last state.
    #[inline(always)]
    fn screen<S: Simd>(&self, simd: S, states: &[Configuration], eight: &mut EightStates<S>) {
        let state = |lane: usize| states[lane.min(states.len() - 1)].positions();
        let [a, b, c, d] = [state(0), state(1), state(2), state(3)];
        let [e, f, g, h] = [state(4), state(5), state(6), state(7)];
        let margin = round_up(self.pairs.self_pairs().largest_padding() + CONTACT_DISTANCE);
        eight.screen(
            simd,
            self.pairs,
            #[inline(always)]
            |i| f64x8::simd_from(simd, [a[i], b[i], c[i], d[i], e[i], f[i], g[i], h[i]]),
            #[inline(always)]
            |_| margin,
        );
    }
}
