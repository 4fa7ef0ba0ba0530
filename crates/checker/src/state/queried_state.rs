//! State that is queried: places the robot, and finds the pairs that may be near.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_geometry::simd::dispatch;
use clearance_proximity::Scratch;
use clearance_robot::Configuration;

use super::stream::Stream;
use crate::pair_kind::{PairKind, SearchedPairs};
use crate::pairs::{CheckedPairs, InsideSearch, PlacedRobot, PosedPair, SearchedBodies};
use crate::robot::CandidatePair;
use crate::world::{BroadPhaseScratch, PartQuery};

/// Distance (m) beyond the requested limit up to which a stream searches for obstacles, so that the result lasts for
/// some further states.
const WORLD_LOOK_AHEAD: f64 = 0.05;

/// One state of the robot, with the memory that its queries use.
pub struct QueriedState<'a> {
    pub pairs: &'a CheckedPairs,
    pub q: &'a Configuration,
    pub robot: &'a mut PlacedRobot,
    pub broad_phase: &'a mut BroadPhaseScratch,
    /// Pairs to test.
    pub candidates: &'a mut Vec<CandidatePair>,
    pub scratch: &'a mut Scratch,
    /// Memory of the last states, if this state is one of a stream.
    pub stream: Option<&'a mut Stream>,
}

impl<'a> QueriedState<'a> {
    /// The same state, queried without the memory of the last states.
    pub fn without_stream(&mut self) -> QueriedState<'_> {
        QueriedState {
            pairs: self.pairs,
            q: self.q,
            robot: &mut *self.robot,
            broad_phase: &mut *self.broad_phase,
            candidates: &mut *self.candidates,
            scratch: &mut *self.scratch,
            stream: None,
        }
    }

    /// A pair in this state; all bodies must be placed.
    pub fn pair(&self, index: usize) -> PosedPair<'a> {
        self.pairs.pair(index, self.robot.frames())
    }

    /// Queues those of the pairs that may be within `limit` (m), in their order, with lower bounds (m) on their
    /// distances; if there are any, all bodies are placed.
    pub fn queue_candidates(&mut self, searched: SearchedPairs, limit: f64) {
        let limit = limit.greater(CONTACT_DISTANCE);
        self.candidates.clear();
        if !self.place_unless_beyond(limit) {
            return;
        }
        if searched.include(PairKind::SelfPair) {
            self.queue_self_candidates(limit);
        }
        if searched.include(PairKind::WorldPair) {
            self.queue_world_candidates(limit);
        }
    }

    /// Adds the pairs with obstacles that may be within `limit` (m) to the queue; all bodies must be placed.
    fn queue_world_candidates(&mut self, limit: f64) {
        let is_beyond = |state: &Self, part: usize| {
            state.stream.as_ref().is_some_and(|stream| stream.obstacles_beyond(part, limit))
        };
        let parts = 0..self.pairs.robot().parts().len();
        if parts.clone().all(|part| is_beyond(self, part)) {
            return;
        }
        self.find_inside(SearchedBodies::All);
        for part in parts {
            if is_beyond(self, part) {
                continue;
            }
            if self.stream.is_none() {
                self.queue_obstacles(part, limit);
                continue;
            }
            let begin = self.candidates.len();
            let farther = limit + WORLD_LOOK_AHEAD;
            self.queue_obstacles(part, farther);
            let Self { candidates, stream: Some(stream), .. } = self else { continue };
            stream.record_obstacles(part, farther, &candidates[begin..]);
            let mut rank = 0;
            candidates.retain(|pair| {
                rank += 1;
                rank <= begin || pair.lower <= limit
            });
        }
    }

    /// Finds the pairs of which the robot body is inside the obstacle; all bodies must be placed.
    pub fn find_inside(&mut self, bodies: SearchedBodies) {
        let Self { pairs, robot, broad_phase, scratch, .. } = self;
        let inside = &mut broad_phase.inside;
        inside.clear();
        dispatch!(scratch.level(), simd => {
            let mut search = InsideSearch { pairs, bodies, scratch };
            search.in_state(simd, &|chain_body| robot.frame(chain_body), |pair| {
                inside.push(pair);
                false
            })
        });
    }

    /// Queues the pairs of a part with obstacles that may be within `limit` (m), and with those that it is inside of.
    fn queue_obstacles(&mut self, part: usize, limit: f64) {
        let Self { pairs, robot, broad_phase, candidates, scratch, .. } = self;
        let robot_body = &pairs.robot()[part];
        let capsule = robot_body.padded_capsule(&robot.frame(robot_body.chain_body()));
        let begin = candidates.len();
        let query = PartQuery::new(part, &capsule, limit);
        pairs.world().candidates(query, broad_phase, scratch, candidates);
        for pair in broad_phase.inside.iter().filter(|pair| pair.part == part) {
            let index = pairs.world().number(*pair);
            match candidates[begin..].iter_mut().find(|near| near.index == index) {
                Some(near) => near.lower = 0.0,
                None => candidates.push(CandidatePair { lower: 0.0, index }),
            }
        }
        candidates[begin..].sort_unstable_by_key(|pair| pair.index);
    }

    /// Places all bodies, unless the memory of the last states proves all pairs farther apart than `limit` (m); then
    /// returns false.
    pub fn place_unless_beyond(&mut self, limit: f64) -> bool {
        let rates = self.pairs.robot().displacement_rates();
        if let Some(stream) = &mut self.stream {
            stream.advance(rates, self.q.positions());
            if stream.all_beyond(limit) {
                return false;
            }
        }
        self.robot.place(self.pairs, self.q.positions(), self.scratch.level());
        true
    }

    /// Queues the self pairs that may be within `limit` (m), and no others, in their order, with lower bounds (m) on
    /// their distances; all bodies must be placed.
    pub fn queue_self_candidates(&mut self, limit: f64) {
        self.candidates.clear();
        if self.stream.is_some() {
            self.queue_self_candidates_of_stream(limit);
            return;
        }
        self.bound();
        let Self { pairs, robot, candidates, .. } = self;
        let infos = pairs.self_pairs().infos().iter().enumerate();
        let bounded =
            infos.map(|(index, info)| CandidatePair { lower: robot.lower_bound(index, info.padding), index });
        candidates.extend(bounded.filter(|pair| pair.lower <= limit));
    }

    /// As [`Self::queue_self_candidates`], from the memory of the last states, and from capsules where that does not
    /// suffice.
    fn queue_self_candidates_of_stream(&mut self, limit: f64) {
        let pairs = self.pairs;
        let Some(stream) = &self.stream else { return };
        let unclear = (0..pairs.self_pairs().count()).any(|i| stream.is_unclear(i, limit));
        if unclear {
            self.bound();
        }
        let Self { robot, candidates, stream, .. } = self;
        let Some(stream) = stream else { return };
        for (index, info) in pairs.self_pairs().infos().iter().enumerate() {
            if unclear {
                stream.record_bound(index, robot.lower_bound(index, info.padding));
            }
            let lower = stream.lower(index);
            if lower <= limit {
                candidates.push(CandidatePair { lower: lower.greater(0.0), index });
            }
        }
    }

    /// Bounds the distances of all self pairs by their capsules.
    fn bound(&mut self) {
        self.scratch.work.volume_tests += self.pairs.self_pairs().count() as u64;
        self.robot.bound(self.pairs, self.scratch.level());
    }
}
