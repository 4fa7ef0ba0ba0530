//! Order in which the intervals of a motion are searched.

use std::collections::VecDeque;

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::LANES;

use super::level_zero::NearPair;
use super::prover::{Piece, Prover};
use super::report::{MotionOrder, UndecidedReason};

/// Target motion (m) within one interval at level 0.
const LEVEL_ZERO_MOTION: f32 = 0.1;

/// Motions up to this length (m) on either side of the middle are searched as one interval.
const SHORT_MOTION: f32 = 0.07;

/// Maximum number of intervals at level 0.
const MOST_INTERVALS: usize = 1024;

/// Fractions of the motion that are sampled when any contact suffices: first the end, where most colliding motions collide, then each as
/// far as possible from the earlier ones.
const SAMPLES: [f64; LANES] = [1.0, 0.5, 0.75, 0.25, 0.875, 0.625, 0.375, 0.125];

/// Number of doublings from the first interval of a widening motion to the whole motion.
const DOUBLINGS: i32 = 8;

/// Positions (rad, m) beyond which kinematics are too inexact for the rounding slack of f32.
const LARGEST_AT_LEVEL_ZERO: f64 = 1e4;

/// Maximum number of queued pieces; further pieces are searched at once.
const MOST_QUEUED: usize = 1 << 18;

impl Prover<'_> {
    /// Searches the whole motion, as far as it matters.
    pub(super) fn run(&mut self) {
        self.motion.stack.clear();
        // the bounds of level 0 do not cover the rounding of huge angles
        if self.proofs.is_some() || self.segment.size() > LARGEST_AT_LEVEL_ZERO {
            return self.all_pairs_alone();
        }
        if self.segment.widens() {
            return self.soonest();
        }
        self.checker.approach_speeds(self.segment, &mut self.motion.ways, &mut self.motion.speeds);
        self.checker.tolerated(self.segment, &mut self.motion.ways, &mut self.motion.off);
        // level 0 leaves infinite bodies open in every interval
        let speeds = self.motion.speeds.iter().copied().filter(|speed| speed.is_finite());
        let fastest = speeds.fold(0.0, f32::greater);
        let blocks = blocks(fastest);
        match self.options.order {
            MotionOrder::Earliest if 0.5 * fastest <= SHORT_MOTION => self.short(),
            MotionOrder::Earliest => self.earliest(blocks),
            MotionOrder::Any => self.any(blocks),
        }
    }

    /// Searches pair by pair, each from the whole motion down to smaller pieces: needs the fewest proofs.
    fn all_pairs_alone(&mut self) {
        for pair in self.checker.all_pairs() {
            self.pair_in(Piece { pair, from: 0.0, to: 1.0 });
        }
    }

    /// Search of a motion whose deviation grows with time: each interval is as long as all before it. After the first interval without a
    /// proof, nothing matters.
    fn soonest(&mut self) {
        let mut from = 0.0;
        for doubling in (0..DOUBLINGS).rev() {
            let to = 0.5_f64.powi(doubling);
            self.checker.screen_widening(self.segment, [from, to], &mut self.motion, self.workspace);
            for near in 0..self.motion.near.len() {
                self.pair_in(Piece { pair: self.motion.near[near].pair, from, to });
            }
            if self.cutoff <= to || self.stopped.is_some() {
                return;
            }
            from = to;
            self.seen_until = to;
        }
    }

    /// For small motions the middle decides all but a few pairs.
    fn short(&mut self) {
        let (speeds, off) = (std::mem::take(&mut self.motion.speeds), std::mem::take(&mut self.motion.off));
        self.checker.screen_whole(self.segment, (&speeds, &off), &mut self.motion, self.workspace);
        (self.motion.speeds, self.motion.off) = (speeds, off);
        for near in 0..self.motion.near.len() {
            self.pair_in(Piece { pair: self.motion.near[near].pair, from: 0.0, to: 1.0 });
        }
    }

    /// Searches blocks of eight intervals in order. Where a run of intervals begins in which level 0 leaves a pair open, the pair is
    /// searched in the whole run: a pair that is always near often moves little.
    fn earliest(&mut self, blocks: usize) {
        for block in 0..blocks {
            let ends = self.screen(block, blocks);
            for lane in 0..LANES {
                self.seen_until = ends[lane];
                if ends[lane] >= self.cutoff || self.stopped.is_some() {
                    return;
                }
                for near in 0..self.motion.near.len() {
                    let NearPair { pair, intervals } = self.motion.near[near];
                    if let Some(end) = run_from(intervals, lane) {
                        self.pair_in(Piece { pair, from: ends[lane], to: ends[end] });
                    }
                }
            }
        }
    }

    /// Most colliding motions collide for long: eight states are tested first, then all pieces that level 0 leaves open; each is searched
    /// once before any of its parts.
    fn any(&mut self, blocks: usize) {
        if let Some(pair) = self.some_state_collides() {
            self.nothing_known_before(pair);
            return;
        }
        let mut queue = VecDeque::new();
        for block in 0..blocks {
            let ends = self.screen(block, blocks);
            for lane in 0..LANES {
                for NearPair { pair, intervals } in &self.motion.near {
                    if let Some(end) = run_from(*intervals, lane) {
                        queue.push_back(Piece { pair: *pair, from: ends[lane], to: ends[end] });
                    }
                }
            }
        }
        while let Some(piece) = queue.pop_front() {
            self.look_at(piece);
            if self.hit.is_some() || self.stopped.is_some() {
                self.nothing_known_before(piece.pair);
                return;
            }
            if queue.len() < MOST_QUEUED {
                queue.extend(self.motion.stack.drain(..));
            } else {
                self.motion.stack.drain(..).for_each(|piece| queue.push_front(piece));
            }
        }
    }

    /// The pair that collides at one of eight fractions, if there is one.
    fn some_state_collides(&mut self) -> Option<usize> {
        self.screen_at(SAMPLES, 0.0);
        for (lane, t) in SAMPLES.into_iter().enumerate() {
            for near in 0..self.motion.near.len() {
                let NearPair { pair, intervals } = self.motion.near[near];
                if intervals & (1 << lane) != 0 && self.touches(pair, t) {
                    return Some(pair);
                }
            }
        }
        None
    }

    /// Without a fixed order nothing is proven before a collision, or before the pair at which the search was stopped.
    fn nothing_known_before(&mut self, pair: usize) {
        let piece = Piece { pair, from: 0.0, to: 1.0 };
        self.leave_open(piece, [0.0, f64::INFINITY], UndecidedReason::Tolerance);
    }

    /// Level 0 of a block; returns the ends of its eight intervals.
    fn screen(&mut self, block: usize, blocks: usize) -> [f64; LANES + 1] {
        #[allow(clippy::cast_precision_loss)] // small numbers
        let end = |i: usize| (block * LANES + i) as f64 / (blocks * LANES) as f64;
        let ends = std::array::from_fn(end);
        let middles = std::array::from_fn(|lane| 0.5 * (end(lane) + end(lane + 1)));
        #[allow(clippy::cast_precision_loss)]
        let half_width = 0.5 / (blocks * LANES) as f64;
        self.screen_at(middles, half_width);
        ends
    }

    /// Level 0 for eight intervals.
    fn screen_at(&mut self, middles: [f64; LANES], half_width: f64) {
        let (speeds, off) = (std::mem::take(&mut self.motion.speeds), std::mem::take(&mut self.motion.off));
        self.checker.screen_intervals(
            self.segment,
            (middles, half_width),
            (&speeds, &off),
            &mut self.motion,
            self.workspace,
        );
        (self.motion.speeds, self.motion.off) = (speeds, off);
    }
}

/// Number of blocks of eight intervals that keeps the motion per interval small at level 0.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // clamped
fn blocks(fastest: f32) -> usize {
    let intervals = (0.5 * fastest / LEVEL_ZERO_MOTION).lesser(MOST_INTERVALS as f32);
    (intervals.greater(1.0) as usize).div_ceil(LANES)
}

/// End of the run of set bits that begins at a lane; `None` if none begins there.
fn run_from(near: u8, lane: usize) -> Option<usize> {
    let begins = near & (1 << lane) != 0 && (lane == 0 || near & (1 << (lane - 1)) == 0);
    begins.then(|| lane + (near >> lane).trailing_ones() as usize)
}
