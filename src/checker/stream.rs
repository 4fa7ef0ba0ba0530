//! What a workspace remembers of the last states, so that a stream of states costs little.
//!
//! By how much distances can have changed is known from the joints alone ([`TravelRates`]). Each pair's distance has lost at
//! most that since it was last looked at; only a pair for which this is too much is looked at again, and
//! where there is none, nothing is even placed.

use super::memory::Memory;
use super::pair::Pair;
use crate::robot::TravelRates;

/// Travel (m) after which counting begins anew: sums are rounded outward, and large ones coarsely.
const LONGEST_TRAVEL: f64 = 1e3;

/// What is known about all pairs of one checker.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    /// The checker that it is about.
    checker: u64,
    /// The last state.
    positions: Vec<f64>,
    /// By how much (m) distances have changed, at most.
    travelled: f64,
    /// A pair's padded distance (m) is not less than this, less what has been travelled.
    horizons: Vec<f64>,
    /// Not more than any horizon.
    nearest_horizon: f64,
    memories: Vec<Option<Memory>>,
}

impl Stream {
    pub fn new(checker: u64, pairs: usize) -> Self {
        Self {
            checker,
            positions: Vec::new(),
            travelled: 0.0,
            horizons: vec![f64::NEG_INFINITY; pairs],
            nearest_horizon: f64::NEG_INFINITY,
            memories: (0..pairs).map(|_| None).collect(),
        }
    }

    /// Whether it is about this checker.
    pub fn is_of(&self, checker: u64) -> bool {
        self.checker == checker
    }

    /// Goes on to the next state.
    pub fn advance(&mut self, rates: &TravelRates, positions: &[f64]) {
        self.travelled += if self.positions.len() == positions.len() {
            rates.between(&self.positions, positions)
        } else {
            f64::INFINITY
        };
        self.travelled = self.travelled.next_up();
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        if self.travelled > LONGEST_TRAVEL {
            self.travelled = 0.0;
            self.horizons.fill(f64::NEG_INFINITY);
            self.nearest_horizon = f64::NEG_INFINITY;
        }
    }

    /// Whether all pairs are certainly farther apart than `limit` (m).
    pub fn all_beyond(&self, limit: f64) -> bool {
        self.nearest_horizon - self.travelled > limit
    }

    /// A number never larger than a pair's padded distance (m).
    pub fn lower(&self, index: usize) -> f64 {
        self.horizons[index] - self.travelled
    }

    /// Whether a pair may be within `limit` (m) though it was not when last asked.
    pub fn is_unclear(&self, index: usize, limit: f64) -> bool {
        self.lower(index) <= limit && !self.memories[index].as_ref().is_some_and(Memory::was_near)
    }

    /// Notes that a pair's padded distance is now not less than `lower` (m).
    pub fn learn(&mut self, index: usize, lower: f64) {
        self.horizons[index] = self.horizons[index].max((lower + self.travelled).next_down());
    }

    /// Notes what a pair's memory tells at its present pose.
    pub fn learn_from_memory(&mut self, index: usize, pair: &Pair) {
        if let Some(memory) = &self.memories[index] {
            self.learn(index, memory.lower_at(pair) - pair.info.padding);
        }
    }

    /// Notes what was learned.
    pub fn settle(&mut self) {
        self.nearest_horizon = self.horizons.iter().copied().fold(f64::INFINITY, f64::min);
    }

    pub fn memory(&mut self, index: usize) -> &mut Option<Memory> {
        &mut self.memories[index]
    }
}
