//! Scratch memory of motion checks, and the types of the intervals in its stack and priority queue.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use clearance_proximity::Scratch;

use super::free_search::FreeSearchScratch;
use super::level_zero::LevelZeroScratch;
use crate::pairs::{NearPoints, ObstacleScratch, PlacedRobot};
use crate::robot::{CandidatePair, PairPriority};
use crate::state::DistanceScratch;

/// Scratch memory that only motion checks use.
#[derive(Clone, Debug, Default)]
pub struct MotionScratch {
    pub level_zero: LevelZeroScratch,
    pub free_search: FreeSearchScratch,
    pub positions: Vec<f64>,
    /// Intervals that are to be evaluated next, the last one first.
    pub stack: Vec<PairInterval>,
    /// Intervals of a search for the least distance, the one with the least lower bound first.
    pub queue: BinaryHeap<BoundedInterval>,
}

/// An interval of t in which a pair is to be evaluated.
#[derive(Clone, Copy, Debug)]
pub struct PairInterval {
    pub pair: usize,
    pub from: f64,
    pub to: f64,
}

/// An interval with a lower bound (m, padding subtracted) on the pair's distance in it.
#[derive(Clone, Copy, Debug)]
pub struct BoundedInterval {
    pub lower: f64,
    pub interval: PairInterval,
    /// The nearest points of the pair at another time.
    pub near: Option<NearPoints>,
}

/// The least lower bound is the greatest element, as the heap needs it; a total order makes the search deterministic.
impl Ord for BoundedInterval {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_lower = other.lower.total_cmp(&self.lower);
        let by_pair = || other.interval.pair.cmp(&self.interval.pair);
        by_lower.then_with(by_pair).then_with(|| other.interval.from.total_cmp(&self.interval.from))
    }
}

impl PartialOrd for BoundedInterval {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for BoundedInterval {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for BoundedInterval {}

/// Memory of a thread that a motion check uses.
pub struct MotionWorkspace<'w> {
    pub robot: &'w mut PlacedRobot,
    pub priority: &'w mut PairPriority,
    pub obstacles: &'w mut ObstacleScratch,
    pub scratch: &'w mut Scratch,
    pub motion: &'w mut MotionScratch,
    /// Pairs to test in a single state, and the memory of the search for the nearest of them.
    pub candidates: &'w mut Vec<CandidatePair>,
    pub distance: &'w mut DistanceScratch,
}
