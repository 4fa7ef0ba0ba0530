//! Memory of the last states, so that a stream of states costs little per state.
//!
//! An upper bound on the change of all distances follows from the joints alone ([`DisplacementRates`]). The known lower bound
//! of each pair's distance is reduced by this travel since the pair's last search. Only pairs whose remaining bound is
//! too small are searched again; if there are none, bodies are not even placed. For obstacles, one bound per robot part
//! covers all of them.

use std::collections::HashMap;
use std::num::NonZeroU32;

use clearance_geometry::math::Extremes;
use clearance_proximity::{Effort, Scratch};
use clearance_robot::DisplacementRates;

use crate::pair_kind::PairKind;
use crate::pairs::{CheckedPairs, PairMemory, PlacedRobot, PosedPair, RememberedPair};
use crate::revision::Revision;
use crate::robot::CandidatePair;

/// Travel (m) after which the sum restarts from zero: sums are rounded outward, and large sums are rounded coarsely.
const LONGEST_TRAVEL: f64 = 1e3;

/// Maximum number of obstacles with memory; when more were near, all of them are discarded.
const MOST_MEMORIES: usize = 4096;

/// Maximum number of pairs noted for the idle time until the next state, in case it is never used.
const MOST_DUE: usize = 1024;

/// Memory of all pairs of one checker in its present world.
#[derive(Clone, Debug)]
pub struct Stream {
    /// Revision of the world it belongs to.
    revision: Revision,
    /// The last state.
    positions: Vec<f64>,
    /// Upper bound (m) on the change of any distance so far.
    travelled: f64,
    /// By self pair: horizon (m), such that the padded distance is at least the horizon minus the travel.
    horizons: Vec<f64>,
    /// By part: the horizon of its distance from any obstacle.
    world_horizons: Vec<f64>,
    /// Pairs with obstacles that are near in the present state.
    near_obstacles: Vec<NearObstacle>,
    /// Lower bound on all horizons.
    nearest_horizon: f64,
    self_memories: SelfPairMemories,
    /// Memories of pairs with obstacles, by pair number.
    world_memories: HashMap<usize, Option<PairMemory>>,
    /// By kind: the nearest pair in the last state in which pairs of that kind were searched.
    last_nearest: [Option<usize>; 2],
    /// Pairs of the last state that the next state will probably have to search, with the options of their search.
    due: Vec<Due>,
}

/// A pair of a part with an obstacle near it.
#[derive(Clone, Copy, Debug)]
struct NearObstacle {
    part: usize,
    /// Number of the pair.
    index: usize,
    /// Horizon (m) of the pair.
    horizon: f64,
}

/// A pair whose bounds will probably not last until the next state.
#[derive(Clone, Copy, Debug)]
pub struct Due {
    pub index: usize,
    /// Search limit (m), padding included.
    pub limit: f64,
    pub effort: Effort,
}

impl Stream {
    pub fn new(revision: Revision, self_pairs: usize, parts: usize) -> Self {
        Self {
            revision,
            positions: Vec::new(),
            travelled: 0.0,
            horizons: vec![f64::NEG_INFINITY; self_pairs],
            world_horizons: vec![f64::NEG_INFINITY; parts],
            near_obstacles: Vec::new(),
            nearest_horizon: f64::NEG_INFINITY,
            self_memories: SelfPairMemories::new(self_pairs),
            world_memories: HashMap::new(),
            last_nearest: [None; 2],
            due: Vec::new(),
        }
    }

    /// True if it belongs to this world.
    pub fn is_of(&self, revision: Revision) -> bool {
        self.revision == revision
    }

    /// Adds the travel to the next state. Also called before each further search in one state.
    pub fn advance(&mut self, rates: &DisplacementRates, positions: &[f64]) {
        // a part with an obstacle near it is beyond no limit
        self.apply_bounds_of_near_obstacles();
        self.travelled += if self.positions.len() == positions.len() {
            rates.between(&self.positions, positions)
        } else {
            f64::INFINITY
        };
        self.travelled = self.travelled.next_up();
        if self.positions != positions {
            self.due.clear();
        }
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        if self.travelled > LONGEST_TRAVEL {
            self.travelled = 0.0;
            self.horizons.fill(f64::NEG_INFINITY);
            self.world_horizons.fill(f64::NEG_INFINITY);
            self.nearest_horizon = f64::NEG_INFINITY;
        }
        if self.world_memories.len() > MOST_MEMORIES {
            self.world_memories.clear();
        }
    }

    /// True if all pairs are proven farther apart than `limit` (m).
    pub fn all_beyond(&self, limit: f64) -> bool {
        self.nearest_horizon - self.travelled > limit
    }

    /// True if all obstacles are proven farther from a part than `limit` (m).
    pub fn obstacles_beyond(&self, part: usize, limit: f64) -> bool {
        self.world_horizons[part] - self.travelled > limit
    }

    /// Lower bound (m) on a self pair's padded distance.
    pub fn lower(&self, index: usize) -> f64 {
        self.horizons[index] - self.travelled
    }

    /// True if a self pair may be within `limit` (m), but was not near at its last search.
    pub fn is_unclear(&self, index: usize, limit: f64) -> bool {
        self.lower(index) <= limit && !self.self_memories.get(index).is_some_and(PairMemory::was_near)
    }

    /// Records a lower bound (m) on a pair's present padded distance.
    pub fn record_bound(&mut self, index: usize, lower: f64) {
        let horizon = (lower + self.travelled).next_down();
        match self.horizons.get_mut(index) {
            Some(known) => *known = (*known).greater(horizon),
            None => {
                if let Some(near) = self.near_obstacles.iter_mut().find(|near| near.index == index) {
                    near.horizon = near.horizon.greater(horizon);
                }
            }
        }
    }

    /// Records the obstacles within `limit` (m) of a part: all of them, with lower bounds on their padded distances.
    pub fn record_obstacles(&mut self, part: usize, limit: f64, near: &[CandidatePair]) {
        self.world_horizons[part] = (limit + self.travelled).next_down();
        let horizon = |pair: &CandidatePair| (pair.lower + self.travelled).next_down();
        let near = near.iter().map(|pair| NearObstacle { part, index: pair.index, horizon: horizon(pair) });
        self.near_obstacles.extend(near);
    }

    /// Records the bound that a pair's memory gives at its present pose.
    pub fn record_bound_of_memory(&mut self, index: usize, pair: &PosedPair) {
        let memory = if self.self_memories.is_self_pair(index) {
            self.self_memories.get(index)
        } else {
            self.world_memories.get(&index).and_then(Option::as_ref)
        };
        if let Some(lower) = memory.map(|memory| memory.lower_at(pair)) {
            self.record_bound(index, lower - pair.info.padding);
        }
    }

    /// The pair of this kind that was the nearest one last time.
    pub fn last_nearest(&self, kind: PairKind) -> Option<usize> {
        self.last_nearest[kind as usize]
    }

    /// Records the nearest pair of a kind.
    pub fn record_nearest(&mut self, kind: PairKind, index: usize) {
        self.last_nearest[kind as usize] = Some(index);
    }

    /// Records the search options of a pair whose bounds will probably not last.
    pub fn record_due(&mut self, due: Due) {
        if self.due.len() < MOST_DUE && self.memory(due.index).as_ref().is_some_and(PairMemory::is_due) {
            self.due.push(due);
        }
    }

    /// A pair that is due.
    fn next_due(&mut self) -> Option<Due> {
        loop {
            let due = self.due.pop()?;
            // it may have been renewed since, or be recorded twice
            if self.memory(due.index).as_ref().is_some_and(PairMemory::is_due) {
                return Some(due);
            }
        }
    }

    /// Uses the idle time before the next state: renews the memory of pairs that the next state will probably have to
    /// search.
    pub fn prepare(&mut self, pairs: &CheckedPairs, robot: &PlacedRobot, scratch: &mut Scratch) {
        let before = scratch.work.cost();
        while let Some(Due { index, limit, effort }) = self.next_due() {
            let most = match effort.exact_cost {
                0 => u64::MAX,
                most => most.saturating_sub(scratch.work.cost() - before),
            };
            let pair = &pairs.pair(index, robot.frames());
            RememberedPair { pair, memory: self.memory(index) }.prepare(limit, &effort, most, scratch);
        }
    }

    fn apply_bounds_of_near_obstacles(&mut self) {
        for NearObstacle { part, horizon, .. } in self.near_obstacles.drain(..) {
            self.world_horizons[part] = self.world_horizons[part].lesser(horizon);
        }
    }

    /// Applies the recorded bounds.
    pub fn apply_bounds(&mut self) {
        self.apply_bounds_of_near_obstacles();
        let all = self.horizons.iter().chain(&self.world_horizons);
        self.nearest_horizon = all.copied().fold(f64::INFINITY, f64::lesser);
    }

    /// Memory of a pair.
    pub fn memory(&mut self, index: usize) -> &mut Option<PairMemory> {
        if self.self_memories.is_self_pair(index) {
            self.self_memories.get_or_insert(index)
        } else {
            self.world_memories.entry(index).or_default()
        }
    }
}

/// Memories of self pairs. In a robot of many links few pairs ever come near each other, and only these have a memory.
#[derive(Clone, Debug)]
struct SelfPairMemories {
    /// By self pair: the place of its memory.
    places: Vec<Option<NonZeroU32>>,
    memories: Vec<Option<PairMemory>>,
}

/// Initial capacity, in pairs.
const INITIAL_CAPACITY: usize = 1 << 12;

impl SelfPairMemories {
    fn new(self_pairs: usize) -> Self {
        let mut memories = Vec::with_capacity(1 + self_pairs.min(INITIAL_CAPACITY));
        // the index that stands for no memory
        memories.push(None);
        Self { places: vec![None; self_pairs], memories }
    }

    /// True if this is the number of a self pair.
    fn is_self_pair(&self, index: usize) -> bool {
        index < self.places.len()
    }

    fn get(&self, index: usize) -> Option<&PairMemory> {
        self.memories[self.places[index]?.get() as usize].as_ref()
    }

    fn get_or_insert(&mut self, index: usize) -> &mut Option<PairMemory> {
        let place = self.places[index].get_or_insert_with(|| {
            self.memories.push(None);
            let place = u32::try_from(self.memories.len() - 1).ok().and_then(NonZeroU32::new);
            place.expect("pairs that come near are fewer than 32 bits count")
        });
        &mut self.memories[place.get() as usize]
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::MOST_DUE;
    use crate::{CollisionChecker, Question};
    use clearance_proximity::Effort;
    use clearance_robot::{MeshFiles, RobotModel};
    use clearance_scene::Settings;
    use clearance_scene::World;

    /// Two boxes, of which one slides past the other.
    const URDF: &str = "<robot name='r'>
        <link name='a'><collision><geometry><box size='1 1 1'/></geometry></collision></link>
        <link name='b'><collision><origin rpy='0.3 0.2 0.1'/><geometry><box size='1 1 1'/></geometry></collision></link>
        <link name='between'/>
        <joint name='i' type='prismatic'><parent link='a'/><child link='between'/><axis xyz='1 0 0'/><limit lower='-9' upper='9' effort='1' velocity='1'/></joint>
        <joint name='j' type='prismatic'><parent link='between'/><child link='b'/><origin xyz='2 0 0'/><axis xyz='0 1 0'/><limit lower='-9' upper='9' effort='1' velocity='1'/></joint></robot>";

    #[test]
    fn what_waits_for_the_time_between_states_is_bounded() {
        let robot = Arc::new(RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap());
        let checker =
            CollisionChecker::new(Arc::clone(&robot), &World::default(), Settings::default()).unwrap();
        let mut stream = checker.streaming_workspace();
        let effort = Effort { exact_cost: 1000, relative_tolerance: 0.1, ..Effort::default() };
        let mut noted = Vec::new();
        let states = [0.0, 1e-3].into_iter().chain(std::iter::repeat_n(2e-3, 2 * MOST_DUE));
        for position in states {
            let q = robot.configuration(&[0.0, position]).unwrap();
            let _ = checker.check_with(
                &q,
                Question::PairDistances { limit: f64::INFINITY },
                &effort,
                &mut stream,
            );
            noted.push(stream.stream().unwrap().due.len());
        }
        assert_eq!(noted.iter().max(), Some(&MOST_DUE), "standing still, and the idle time is never used");
        checker.prepare(&mut stream);
        assert_eq!(stream.stream().unwrap().due.len(), 0);
    }
}
