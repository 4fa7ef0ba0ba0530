//! Search of a motion for a proof that all of it is free; the first contact or undecided interval ends it.
//!
//! The cheap proof comes first: level 0, which alone decides most free motions. If it leaves a pair open, and recent
//! motions collided, single states are tested: that finds most contacts. Each open pair is then evaluated in the middle
//! of its intervals, and last in their parts, level by level: bodies that collide mostly do so for long.
//!
//! The intervals, and their parts, are those of the search for the earliest contact. Both find the same motions free:
//! no proof depends on the order.

use super::level_zero_intervals::{Intervals, is_beyond_level_zero, open_runs, screen_block};
use super::motion_scratch::PairInterval;
use super::probe_credits::{PROBES, ProbeCredits};
use super::prover::Prover;
use crate::robot::PairPriority;

/// Maximum number of parts that are searched breadth first; more are searched one by one.
const MOST_AT_ONCE: usize = 1 << 16;

/// Scratch memory of the search.
#[derive(Clone, Debug, Default)]
pub struct FreeSearchScratch {
    credits: ProbeCredits,
    /// Pairs that are evaluated first.
    priority: PairPriority,
    /// Intervals that are evaluated next.
    intervals: Vec<PairInterval>,
    /// Parts of evaluated intervals that are not decided yet.
    parts: Vec<PairInterval>,
}

/// Searches one motion until it is proven free or cannot be.
pub struct FreeSearch<'p, 'a, 'w> {
    prover: &'p mut Prover<'a, 'w>,
    memory: &'p mut FreeSearchScratch,
    is_probed: bool,
}

impl<'p, 'a, 'w> FreeSearch<'p, 'a, 'w> {
    pub fn new(prover: &'p mut Prover<'a, 'w>, memory: &'p mut FreeSearchScratch) -> Self {
        memory.intervals.clear();
        memory.parts.clear();
        prover.seek_contacts();
        Self { prover, memory, is_probed: false }
    }

    /// True if the whole motion is proven free. Not for motions that widen.
    pub fn run(&mut self) -> bool {
        self.search_whole() && self.search_parts()
    }

    /// Searches all intervals that level 0 leaves open; false if one is not free.
    fn search_whole(&mut self) -> bool {
        let motion = self.prover.motion();
        let whole = |pair: usize| PairInterval { pair, from: 0.0, to: 1.0 };
        if is_beyond_level_zero(motion.segment) {
            self.memory.intervals.extend(motion.pairs.numbers().map(whole));
            return self.evaluate_intervals();
        }
        match Intervals::of(&mut self.prover.level_zero()) {
            Intervals::Whole => {
                self.prover.level_zero().screen_whole();
                self.memory.intervals.extend(self.prover.near().iter().map(|near| whole(near.pair)));
                self.search_open_intervals()
            }
            // most motions that collide do so at their end
            Intervals::Blocks(blocks) => (0..blocks).rev().all(|block| {
                let ends = screen_block(&mut self.prover.level_zero(), block, blocks);
                self.memory.intervals.extend(open_runs(self.prover.near(), &ends));
                self.search_open_intervals()
            }),
        }
    }

    /// Searches the intervals that level 0 has left open so far; false if one is not free.
    fn search_open_intervals(&mut self) -> bool {
        self.memory.intervals.is_empty() || self.probes_are_free() && self.evaluate_intervals()
    }

    /// Tests states of the motion, once and where that is worth its cost.
    fn probes_are_free(&mut self) -> bool {
        if std::mem::replace(&mut self.is_probed, true) {
            return true;
        }
        let credits = &mut self.memory.credits;
        for (probe, &t) in PROBES.iter().enumerate() {
            if !credits.is_worth(probe) {
                continue;
            }
            let Some(is_contact) = self.prover.collides_at(t) else { return true };
            credits.tested(probe, is_contact);
            if is_contact {
                return false;
            }
        }
        true
    }

    /// Evaluates the remaining parts, and the parts that remain of them; false if one is not free.
    fn search_parts(&mut self) -> bool {
        while !self.memory.parts.is_empty() {
            if self.memory.parts.len() > MOST_AT_ONCE {
                return self.search_one_by_one();
            }
            let FreeSearchScratch { intervals, parts, .. } = self.memory;
            std::mem::swap(intervals, parts);
            if !self.evaluate_intervals() {
                return false;
            }
        }
        true
    }

    fn search_one_by_one(&mut self) -> bool {
        while let Some(part) = self.memory.parts.pop() {
            self.prover.search_interval(part);
            if !self.prover.finds_free() {
                return false;
            }
        }
        true
    }

    /// Evaluates the collected intervals once, and collects the parts that remain; false if one is not free.
    fn evaluate_intervals(&mut self) -> bool {
        let FreeSearchScratch { credits, priority, intervals, parts } = self.memory;
        if intervals.len() > 1 {
            intervals.sort_by_key(|interval| priority.rank(interval.pair));
        }
        for interval in intervals.drain(..) {
            self.prover.evaluate_interval(interval);
            if !self.prover.finds_free() {
                if self.prover.has_contact() {
                    priority.hit(interval.pair);
                    credits.missed();
                }
                return false;
            }
            parts.append(self.prover.stack());
        }
        true
    }
}
