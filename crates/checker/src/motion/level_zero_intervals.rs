//! Division of a motion into intervals at level 0.

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::LANES;
use clearance_motion::MotionSegment;

use super::level_zero::{LevelZero, NearPair};
use super::motion_scratch::PairInterval;

/// Target motion (m) within one interval at level 0.
const LEVEL_ZERO_MOTION: f32 = 0.1;

/// Motions up to this length (m) on either side of the middle are searched as one interval.
const SHORT_MOTION: f32 = 0.07;

/// Maximum number of intervals at level 0.
const MOST_INTERVALS: usize = 1024;

/// Positions (rad, m) beyond which kinematics are too inexact for the rounding slack of f32.
const LARGEST_AT_LEVEL_ZERO: f64 = 1e4;

/// Intervals of a motion at level 0.
#[derive(Clone, Copy, Debug)]
pub enum Intervals {
    /// The whole motion: for short motions the middle decides all but a few pairs.
    Whole,
    /// This number of blocks of eight intervals each.
    Blocks(usize),
}

impl Intervals {
    /// The intervals of a motion; level 0 then has the bounds on the motion in them.
    pub fn of(level_zero: &mut LevelZero) -> Self {
        level_zero.bound_motion();
        let fastest = level_zero.memory.fastest();
        if 0.5 * fastest <= SHORT_MOTION { Self::Whole } else { Self::Blocks(blocks(fastest)) }
    }

    /// Number of blocks of eight intervals.
    pub fn blocks(self) -> usize {
        match self {
            Self::Whole => 1,
            Self::Blocks(blocks) => blocks,
        }
    }
}

/// True if the bounds of level 0 do not cover the rounding of the positions.
pub fn is_beyond_level_zero(segment: &MotionSegment) -> bool {
    segment.size() > LARGEST_AT_LEVEL_ZERO
}

/// Level 0 of a block; returns the ends of its eight intervals.
pub fn screen_block(level_zero: &mut LevelZero, block: usize, blocks: usize) -> [f64; LANES + 1] {
    #[allow(clippy::cast_precision_loss)] // small numbers
    let end = |i: usize| (block * LANES + i) as f64 / (blocks * LANES) as f64;
    let ends = std::array::from_fn(end);
    let middles = std::array::from_fn(|lane| 0.5 * (end(lane) + end(lane + 1)));
    #[allow(clippy::cast_precision_loss)]
    let half_width = 0.5 / (blocks * LANES) as f64;
    level_zero.screen_intervals(middles, half_width);
    ends
}

/// The runs of a block's intervals in which level 0 leaves pairs open. A pair that is always near often moves little:
/// its whole run is searched as one interval.
pub fn open_runs<'p>(
    near: &'p [NearPair],
    ends: &'p [f64; LANES + 1],
) -> impl Iterator<Item = PairInterval> + 'p {
    (0..LANES).flat_map(move |lane| {
        near.iter().filter_map(move |near| {
            let end = run_from(near.intervals, lane)?;
            Some(PairInterval { pair: near.pair, from: ends[lane], to: ends[end] })
        })
    })
}

/// Number of blocks of eight intervals that keeps the motion per interval small at level 0.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // clamped
fn blocks(fastest: f32) -> usize {
    let intervals = (0.5 * fastest / LEVEL_ZERO_MOTION).lesser(MOST_INTERVALS as f32);
    (intervals.greater(1.0) as usize).div_ceil(LANES)
}

/// End of the run of set bits that begins at a lane; `None` if none begins there.
pub fn run_from(near: u8, lane: usize) -> Option<usize> {
    let begins = near & (1 << lane) != 0 && (lane == 0 || near & (1 << (lane - 1)) == 0);
    begins.then(|| lane + (near >> lane).trailing_ones() as usize)
}
