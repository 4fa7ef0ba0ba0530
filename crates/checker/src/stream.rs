//! Memory of the last states, so that a stream of states costs little per state.
//!
//! An upper bound on the change of all distances follows from the joints alone ([`DisplacementRates`]). The known lower bound of each pair's
//! distance is reduced by this travel since the pair's last search. Only pairs whose remaining bound is too small are searched again; if
//! there are none, bodies are not even placed. For obstacles, one bound per robot part covers all of them.

use std::collections::HashMap;
use std::num::NonZeroU32;

use clearance_geometry::math::Extremes;
use clearance_proximity::Effort;
use clearance_robot::DisplacementRates;

use super::memory::Memory;
use super::pair::Pair;
use super::workspace::QueuedPair;

/// Travel (m) after which the sum restarts from zero: sums are rounded outward, and large sums are rounded coarsely.
const LONGEST_TRAVEL: f64 = 1e3;

/// Maximum number of obstacles with memory; when more were near, all of them are discarded.
const MOST_MEMORIES: usize = 4096;

/// Maximum number of pairs noted for the idle time until the next state, in case it is never used.
const MOST_DUE: usize = 1024;

/// Memory of all pairs of one checker.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    /// The revision of the checker it belongs to.
    checker: u64,
    /// The last state.
    positions: Vec<f64>,
    /// Upper bound (m) on the change of any distance so far.
    travelled: f64,
    /// By self pair: horizon (m), such that the padded distance is at least the horizon minus the travel.
    horizons: Vec<f64>,
    /// By part: the horizon of its distance from any obstacle.
    world_horizons: Vec<f64>,
    /// For the present state: parts, pair numbers of obstacles near them, and their horizons.
    seen: Vec<(usize, usize, f64)>,
    /// Lower bound on all horizons.
    nearest_horizon: f64,
    memories: Memories,
    /// Memories of pairs with obstacles.
    world_memories: HashMap<usize, Option<Memory>>,
    /// Pairs of the last state that the next state will probably have to search, with the options of their search.
    due: Vec<Due>,
}

/// A pair whose bounds will probably not last until the next state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Due {
    pub index: usize,
    /// Search limit (m), padding included.
    pub limit: f64,
    pub effort: Effort,
}

impl Stream {
    pub fn new(checker: u64, self_pairs: usize, parts: usize) -> Self {
        Self {
            checker,
            positions: Vec::new(),
            travelled: 0.0,
            horizons: vec![f64::NEG_INFINITY; self_pairs],
            world_horizons: vec![f64::NEG_INFINITY; parts],
            seen: Vec::new(),
            nearest_horizon: f64::NEG_INFINITY,
            memories: Memories::new(self_pairs),
            world_memories: HashMap::new(),
            due: Vec::new(),
        }
    }

    /// True if it belongs to this checker.
    pub fn is_of(&self, checker: u64) -> bool {
        self.checker == checker
    }

    /// Goes on to the next state.
    pub fn advance(&mut self, rates: &DisplacementRates, positions: &[f64]) {
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
        self.lower(index) <= limit && !self.memories.get(index).is_some_and(Memory::was_near)
    }

    /// Records a lower bound (m) on a pair's present padded distance.
    pub fn learn(&mut self, index: usize, lower: f64) {
        let horizon = (lower + self.travelled).next_down();
        match self.horizons.get_mut(index) {
            Some(known) => *known = (*known).greater(horizon),
            None => {
                if let Some((_, _, known)) = self.seen.iter_mut().find(|(_, pair, _)| *pair == index) {
                    *known = (*known).greater(horizon);
                }
            }
        }
    }

    /// Records the obstacles within `limit` (m) of a part: all of them, with lower bounds on their padded distances.
    pub fn see(&mut self, part: usize, limit: f64, near: &[QueuedPair]) {
        self.world_horizons[part] = (limit + self.travelled).next_down();
        let horizon = |pair: &QueuedPair| (pair.lower + self.travelled).next_down();
        self.seen.extend(near.iter().map(|pair| (part, pair.index, horizon(pair))));
    }

    /// Records the bound that a pair's memory gives at its present pose.
    pub fn learn_from_memory(&mut self, index: usize, pair: &Pair) {
        let memory = if self.memories.has(index) {
            self.memories.get(index)
        } else {
            self.world_memories.get(&index).and_then(Option::as_ref)
        };
        if let Some(lower) = memory.map(|memory| memory.lower_at(pair)) {
            self.learn(index, lower - pair.info.padding);
        }
    }

    /// Records the search options of a pair whose bounds will probably not last.
    pub fn note_due(&mut self, due: Due) {
        if self.due.len() < MOST_DUE && self.memory(due.index).as_ref().is_some_and(Memory::is_due) {
            self.due.push(due);
        }
    }

    /// A pair that is due.
    pub fn next_due(&mut self) -> Option<Due> {
        loop {
            let due = self.due.pop()?;
            // it may have been renewed since, or be recorded twice
            if self.memory(due.index).as_ref().is_some_and(Memory::is_due) {
                return Some(due);
            }
        }
    }

    /// Applies the recorded bounds.
    pub fn settle(&mut self) {
        for (part, _, horizon) in self.seen.drain(..) {
            self.world_horizons[part] = self.world_horizons[part].lesser(horizon);
        }
        let all = self.horizons.iter().chain(&self.world_horizons);
        self.nearest_horizon = all.copied().fold(f64::INFINITY, f64::lesser);
    }

    pub fn memory(&mut self, index: usize) -> &mut Option<Memory> {
        if self.memories.has(index) {
            self.memories.of(index)
        } else {
            self.world_memories.entry(index).or_default()
        }
    }
}

/// Memories of self pairs. In a robot of many links few pairs ever come near each other, and only these have a memory.
#[derive(Clone, Debug)]
struct Memories {
    /// By self pair: the place of its memory.
    places: Vec<Option<NonZeroU32>>,
    kept: Vec<Option<Memory>>,
}

/// Initial capacity, in pairs.
const ROOM: usize = 1 << 12;

impl Memories {
    fn new(self_pairs: usize) -> Self {
        let mut kept = Vec::with_capacity(1 + self_pairs.min(ROOM));
        // the index that stands for no memory
        kept.push(None);
        Self { places: vec![None; self_pairs], kept }
    }

    /// Whether this is the number of a self pair.
    fn has(&self, index: usize) -> bool {
        index < self.places.len()
    }

    fn get(&self, index: usize) -> Option<&Memory> {
        self.kept[self.places[index]?.get() as usize].as_ref()
    }

    fn of(&mut self, index: usize) -> &mut Option<Memory> {
        let place = self.places[index].get_or_insert_with(|| {
            self.kept.push(None);
            let place = u32::try_from(self.kept.len() - 1).ok().and_then(NonZeroU32::new);
            place.expect("pairs that come near are fewer than 32 bits count")
        });
        &mut self.kept[place.get() as usize]
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
            noted.push(stream.stream.as_ref().unwrap().due.len());
        }
        assert_eq!(noted.iter().max(), Some(&MOST_DUE), "standing still, and nobody takes that time");
        checker.prepare(&mut stream);
        assert_eq!(stream.stream.unwrap().due.len(), 0);
    }
}
