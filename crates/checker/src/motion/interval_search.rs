//! Search of a motion for its earliest or any contact: the order in which its intervals are evaluated.

use std::collections::VecDeque;

use clearance_geometry::simd::LANES;

use super::level_zero::NearPair;
use super::level_zero_intervals::{Intervals, is_beyond_level_zero, open_runs, run_from, screen_block};
use super::motion_report::{MotionOrder, UndecidedReason};
use super::motion_scratch::PairInterval;
use super::prover::Prover;

/// Fractions of the motion that are sampled when any contact suffices: first the end, where most colliding motions
/// collide, then each as far as possible from the earlier ones.
const SAMPLES: [f64; LANES] = [1.0, 0.5, 0.75, 0.25, 0.875, 0.625, 0.375, 0.125];

/// Number of doublings from the first interval of a widening motion to the whole motion.
const DOUBLINGS: i32 = 8;

/// Maximum number of queued intervals; further intervals are searched at once.
const MOST_QUEUED: usize = 1 << 18;

/// Searches one motion with a prover.
pub struct IntervalSearch<'p, 'a, 'w> {
    prover: &'p mut Prover<'a, 'w>,
}

impl<'p, 'a, 'w> IntervalSearch<'p, 'a, 'w> {
    pub fn new(prover: &'p mut Prover<'a, 'w>) -> Self {
        Self { prover }
    }

    /// Searches the whole motion, as far as it matters.
    pub fn run(&mut self) {
        let segment = self.prover.motion().segment;
        if self.prover.keeps_proofs() || is_beyond_level_zero(segment) {
            return self.search_pair_by_pair();
        }
        if segment.widens() {
            return self.search_widening();
        }
        let intervals = Intervals::of(&mut self.prover.level_zero());
        match (self.prover.options().order, intervals) {
            (MotionOrder::Earliest, Intervals::Whole) => self.search_short(),
            (MotionOrder::Earliest, Intervals::Blocks(blocks)) => self.search_earliest(blocks),
            (MotionOrder::Any, intervals) => self.search_any(intervals.blocks()),
        }
    }

    /// Searches pair by pair, each from the whole motion down to smaller intervals: needs the fewest proofs.
    fn search_pair_by_pair(&mut self) {
        for pair in self.prover.motion().pairs.numbers() {
            self.prover.search_interval(PairInterval { pair, from: 0.0, to: 1.0 });
        }
    }

    /// Searches the pairs of moving obstacles only.
    pub fn run_for_movers(&mut self) {
        for pair in self.prover.motion().pairs_of_movers() {
            self.prover.search_interval(PairInterval { pair, from: 0.0, to: 1.0 });
        }
    }

    /// Search of a motion whose deviation grows with time: each interval is as long as all before it. After the first
    /// interval without a proof, nothing matters.
    fn search_widening(&mut self) {
        let mut from = 0.0;
        for doubling in (0..DOUBLINGS).rev() {
            let to = 0.5_f64.powi(doubling);
            self.prover.level_zero().screen_widening([from, to]);
            self.search_near_pairs(from, to);
            if self.prover.cutoff() <= to || self.prover.is_stopped() {
                return;
            }
            from = to;
            self.prover.set_searched_until(to);
        }
    }

    /// For small motions the middle decides all but a few pairs.
    fn search_short(&mut self) {
        self.prover.level_zero().screen_whole();
        self.search_near_pairs(0.0, 1.0);
    }

    /// Searches all pairs that level 0 left open.
    fn search_near_pairs(&mut self, from: f64, to: f64) {
        for near in 0..self.near().len() {
            self.prover.search_interval(PairInterval { pair: self.near()[near].pair, from, to });
        }
    }

    /// Pairs that level 0 left open.
    fn near(&self) -> &[NearPair] {
        self.prover.near()
    }

    /// Searches blocks of eight intervals in order. Where a run of intervals begins in which level 0 leaves a pair
    /// open, the pair is searched in the whole run: a pair that is always near often moves little.
    fn search_earliest(&mut self, blocks: usize) {
        for block in 0..blocks {
            let ends = screen_block(&mut self.prover.level_zero(), block, blocks);
            for lane in 0..LANES {
                self.prover.set_searched_until(ends[lane]);
                if ends[lane] >= self.prover.cutoff() || self.prover.is_stopped() {
                    return;
                }
                for near in 0..self.near().len() {
                    let NearPair { pair, intervals } = self.near()[near];
                    if let Some(end) = run_from(intervals, lane) {
                        self.prover.search_interval(PairInterval { pair, from: ends[lane], to: ends[end] });
                    }
                }
            }
        }
    }

    /// Most colliding motions collide for long: eight states are tested first, then all intervals that level 0 leaves
    /// open; each is searched once before any of its parts.
    fn search_any(&mut self, blocks: usize) {
        if let Some(pair) = self.pair_in_contact_at_samples() {
            self.leave_all_open(pair);
            return;
        }
        let mut queue = VecDeque::new();
        for block in 0..blocks {
            let ends = screen_block(&mut self.prover.level_zero(), block, blocks);
            queue.extend(open_runs(self.prover.near(), &ends));
        }
        while let Some(interval) = queue.pop_front() {
            self.prover.evaluate_interval(interval);
            if self.prover.has_contact() || self.prover.is_stopped() {
                self.leave_all_open(interval.pair);
                return;
            }
            if queue.len() < MOST_QUEUED {
                queue.extend(self.prover.stack().drain(..));
            } else {
                self.prover.stack().drain(..).for_each(|interval| queue.push_front(interval));
            }
        }
    }

    /// The pair that collides at one of eight fractions, if there is one.
    fn pair_in_contact_at_samples(&mut self) -> Option<usize> {
        self.prover.level_zero().screen_intervals(SAMPLES, 0.0);
        for (lane, t) in SAMPLES.into_iter().enumerate() {
            for near in 0..self.near().len() {
                let NearPair { pair, intervals } = self.near()[near];
                if intervals & (1 << lane) != 0 && self.prover.touches(pair, t) {
                    return Some(pair);
                }
            }
        }
        None
    }

    /// Without a fixed order nothing is proven before a collision, or before the pair at which the search was stopped.
    fn leave_all_open(&mut self, pair: usize) {
        let whole = PairInterval { pair, from: 0.0, to: 1.0 };
        self.prover.leave_open(whole, [0.0, f64::INFINITY], UndecidedReason::Tolerance);
    }
}
