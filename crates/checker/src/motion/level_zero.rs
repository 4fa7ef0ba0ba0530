//! Level 0 of a motion: capsule bounds of all pairs in eight intervals at once.

use clearance_geometry::constants::{CONTACT_DISTANCE, MOTION_SLACK};
use clearance_geometry::math::{Extremes, UnitVector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, dispatch, f64x8};
use clearance_motion::MotionSegment;
use clearance_proximity::Scratch;
use clearance_robot::{Deviation, Deviations, Frame};

use super::checked_motion::CheckedMotion;
use super::interval_midpoint::deviations_within;
use crate::capsules::round_up;
use crate::pairs::{CheckedPairs, InsideSearch, PlacedRobot, SearchedBodies};
use crate::robot::set_bits;
use crate::state::EightStates;
use crate::world::{BroadPhaseScratch, EightStatesQuery, WorldPair};

/// Margins (m) beyond this one are as good as none: their square is a number in f32.
const LARGEST_MARGIN: f64 = 1e9;

/// Share of a margin that covers the rounding of distances of this size in f32.
const MARGIN_SLACK: f64 = 1e-6;

/// Scratch memory of level 0.
#[derive(Clone, Debug, Default)]
pub struct LevelZeroScratch {
    positions: Vec<f64>,
    /// By position, for eight states.
    columns: Vec<[f64; LANES]>,
    /// Pairs that may touch, with a mask of the eight intervals.
    near: Vec<NearPair>,
    /// Values of the kinematic paths of all parts.
    path_values: Vec<f64>,
    motion: MotionBounds,
}

/// Bounds on the decrease of distances: by self pair, then by part for its distance to static obstacles.
#[derive(Clone, Debug, Default)]
struct MotionBounds {
    /// Maximum decrease (m) in one unit of t.
    speeds: Vec<f32>,
    /// Decrease (m) that the tolerances of the positions allow.
    tolerances: Vec<f32>,
}

/// A pair that may touch in some of eight intervals, and a bit mask of these intervals.
#[derive(Clone, Copy, Debug)]
pub struct NearPair {
    pub pair: usize,
    pub intervals: u8,
}

/// Deviation of positions within one unit of t, at their maximum speed.
struct AtTopSpeed<'s>(&'s MotionSegment);

impl Deviations for AtTopSpeed<'_> {
    fn of(&self, position: usize) -> Deviation {
        Deviation { most: self.0.top_speed(position), ..Deviation::default() }
    }

    fn half_width(&self) -> f64 {
        1.0
    }

    fn turn(&self, first: usize) -> Option<(UnitVector, f64)> {
        self.0.turn_of(first)
    }
}

/// Tolerances of the positions.
struct WithTolerance<'s>(&'s MotionSegment);

impl Deviations for WithTolerance<'_> {
    fn of(&self, position: usize) -> Deviation {
        Deviation { tolerance: self.0.tube().get(position).copied().unwrap_or(0.0), ..Deviation::default() }
    }

    fn half_width(&self) -> f64 {
        0.0
    }

    fn turn(&self, _: usize) -> Option<(UnitVector, f64)> {
        None
    }
}

/// Level 0 of a motion, with the memory that it uses.
pub struct LevelZero<'w> {
    pub motion: CheckedMotion<'w>,
    /// Distances (m) up to which self pairs and world pairs matter, besides their paddings.
    pub margins: [f64; 2],
    pub robot: &'w mut PlacedRobot,
    pub broad_phase: &'w mut BroadPhaseScratch,
    pub scratch: &'w mut Scratch,
    pub memory: &'w mut LevelZeroScratch,
}

impl LevelZeroScratch {
    /// Prepares the memory for a motion with this number of positions.
    pub fn resize(&mut self, positions: usize) {
        self.positions.resize(positions, 0.0);
    }

    /// Pairs that may touch.
    pub fn near(&self) -> &[NearPair] {
        &self.near
    }

    /// The largest decrease (m) of a distance in one unit of t; level 0 leaves infinite bodies open in every interval.
    pub fn fastest(&self) -> f32 {
        let speeds = self.motion.speeds.iter().copied().filter(|speed| speed.is_finite());
        speeds.fold(0.0, f32::greater)
    }
}

impl MotionBounds {
    /// By index of the bounds: the maximum decrease (m) of the distance within an interval of this half width.
    fn within(&self, half_width: f64) -> impl Fn(usize) -> f32 + '_ {
        let half_width = round_up(half_width * (1.0 + 1e-6));
        // an interval of zero width is a state
        let loose = f32::from(u8::from(half_width > 0.0));
        let (speeds, tolerances) = (&self.speeds[..], &self.tolerances[..]);
        move |i| (speeds[i] * half_width + tolerances[i] * loose) * (1.0 + 1e-6)
    }
}

impl LevelZero<'_> {
    /// Computes the bounds on the decrease of distances, which the other methods use.
    pub fn bound_motion(&mut self) {
        let CheckedMotion { pairs, segment, .. } = self.motion;
        let LevelZeroScratch { path_values, motion: MotionBounds { speeds, tolerances }, .. } =
            &mut *self.memory;
        let self_pairs = pairs.self_pairs().count();
        let range = |i| segment.range(i);
        pairs.robot().stretched_motions(&AtTopSpeed(segment), range, path_values);
        sum_along_paths(pairs, path_values, speeds);
        if pairs.world().is_empty() {
            speeds[self_pairs..].fill(0.0);
        }
        if segment.tube().is_empty() {
            tolerances.clear();
            tolerances.resize(self_pairs + pairs.robot().parts().len(), 0.0);
        } else {
            pairs.robot().stretched_motions(&WithTolerance(segment), range, path_values);
            sum_along_paths(pairs, path_values, tolerances);
        }
    }

    /// The pairs that capsules do not prove apart in eight intervals of this half width around `middles`.
    pub fn screen_intervals(&mut self, middles: [f64; LANES], half_width: f64) {
        let CheckedMotion { pairs, segment, .. } = self.motion;
        let LevelZeroScratch { positions, columns, near, motion, .. } = &mut *self.memory;
        let motion = motion.within(half_width);
        // an interval of zero width is a state
        let latest = middles.into_iter().fold(0.0, f64::greater) + half_width;
        let unknown = if half_width > 0.0 { self.motion.largest_uncertainty(latest) } else { 0.0 };
        let padding = padding_with_slack(pairs, self.margins[0]);
        let self_pairs = pairs.self_pairs().count();
        near.clear();
        columns.resize(positions.len(), [0.0; LANES]);
        self.scratch.work.volume_tests += (self_pairs * LANES) as u64;
        dispatch!(self.scratch.level(), simd => {
            let mut eight = EightStates::new(pairs, simd);
            for (lane, middle) in middles.iter().enumerate() {
                segment.positions_at(*middle, positions);
                for (column, position) in columns.iter_mut().zip(&*positions) {
                    column[lane] = *position;
                }
            }
            eight.screen(
                simd,
                pairs,
                #[inline(always)]
                |i| f64x8::from_slice(simd, &columns[i]),
                #[inline(always)]
                |i| motion(i) + padding,
            );
            let of_parts = eight.near().iter().enumerate().filter(|(_, intervals)| **intervals != 0);
            near.extend(of_parts.map(|(pair, intervals)| NearPair { pair, intervals: *intervals }));
            ObstacleScreen {
                motion: self.motion,
                margin: self.margins[1] + unknown,
                broad_phase: self.broad_phase,
                scratch: self.scratch,
                near,
                intervals: u8::MAX,
            }
            .run(|body, lane| eight.frame(body, lane), |part| motion(self_pairs + part));
        });
    }

    /// The pairs that capsules do not prove apart in the whole motion, from its middle alone; reported as the first
    /// interval.
    pub fn screen_whole(&mut self) {
        let CheckedMotion { pairs, segment, .. } = self.motion;
        let LevelZeroScratch { positions, near, motion, .. } = &mut *self.memory;
        segment.positions_at(0.5, positions);
        let motion = motion.within(0.5);
        let padding = padding_with_slack(pairs, self.margins[0]);
        let self_pairs = pairs.self_pairs().count();
        // an incomplete group repeats its last pair
        let last = self_pairs.saturating_sub(1);
        let margins =
            |group: usize| std::array::from_fn(|lane| motion((LANES * group + lane).min(last)) + padding);
        self.scratch.work.volume_tests += self_pairs as u64;
        let robot = &mut *self.robot;
        dispatch!(self.scratch.level(), simd => robot.screen(simd, pairs, positions, margins));
        near.clear();
        near.extend(set_bits(robot.near()).map(|pair| NearPair { pair, intervals: 1 }));
        ObstacleScreen {
            motion: self.motion,
            margin: self.margins[1] + self.motion.largest_uncertainty(1.0),
            broad_phase: self.broad_phase,
            scratch: self.scratch,
            near,
            intervals: 1,
        }
        .run(|body, _| robot.frame(body), |part| motion(self_pairs + part));
    }

    /// The pairs that capsules do not prove apart in an interval of a widening motion; reported as the first interval.
    pub fn screen_widening(&mut self, [from, to]: [f64; 2]) {
        let CheckedMotion { pairs, segment, .. } = self.motion;
        let LevelZeroScratch { positions, near, .. } = &mut *self.memory;
        near.clear();
        near.extend((0..pairs.self_pairs().count()).map(|pair| NearPair { pair, intervals: 1 }));
        if pairs.world().is_empty() {
            return;
        }
        segment.positions_at(0.5 * (from + to), positions);
        let robot = &mut *self.robot;
        robot.place(pairs, positions, self.scratch.level());
        let whole = deviations_within(segment, [from, to]);
        let motion = |part: usize| {
            let robot_body = &pairs.robot()[part];
            let reach = robot_body.reach_in(&robot.frame(robot_body.chain_body()));
            let moved = pairs.robot().part_motion(part, &reach, robot.frames(), &whole);
            round_up((moved.path_length + moved.tolerance) * (1.0 + MOTION_SLACK) + MOTION_SLACK)
        };
        ObstacleScreen {
            motion: self.motion,
            margin: self.margins[1] + self.motion.largest_uncertainty(to),
            broad_phase: self.broad_phase,
            scratch: self.scratch,
            near,
            intervals: 1,
        }
        .run(|body, _| robot.frame(body), motion);
    }
}

/// Level 0 for pairs with obstacles.
struct ObstacleScreen<'w> {
    motion: CheckedMotion<'w>,
    /// Distance (m) up to which obstacles matter, besides paddings.
    margin: f64,
    broad_phase: &'w mut BroadPhaseScratch,
    scratch: &'w mut Scratch,
    near: &'w mut Vec<NearPair>,
    /// The intervals that are screened, as a bit mask.
    intervals: u8,
}

impl ObstacleScreen<'_> {
    /// Adds the pairs that are not proven apart; `frame` gives the pose of a chain body in the middle of an interval,
    /// and `motion` the maximum motion (m) of a part towards either end.
    fn run(self, frame: impl Fn(usize, usize) -> Frame<f64>, motion: impl Fn(usize) -> f32) {
        let Self { motion: CheckedMotion { pairs, .. }, margin, broad_phase, scratch, near, intervals: mask } =
            self;
        let world = pairs.world();
        if world.is_empty() {
            return;
        }
        let movers = self.motion.moving_places();
        for (part, robot_body) in pairs.robot().parts().iter().enumerate() {
            let capsules: [_; LANES] =
                std::array::from_fn(|lane| robot_body.padded_capsule(&frame(robot_body.chain_body(), lane)));
            let limit = round_up(f64::from(motion(part)) + with_slack(margin));
            let query = EightStatesQuery { part, capsules: &capsules, limit };
            world.for_each_near_in_eight_states(query, broad_phase, scratch, |place, intervals| {
                if !movers.contains(&place) && intervals & mask != 0 {
                    let pair = world.number(WorldPair { part, place });
                    near.push(NearPair { pair, intervals: intervals & mask });
                }
            });
            // level 0 does not bound moving obstacles
            let moving = movers.iter().map(|place| world.number(WorldPair { part, place: *place }));
            let moving = moving.filter(|pair| pairs.is_checked(*pair));
            near.extend(moving.map(|pair| NearPair { pair, intervals: mask }));
        }
        // while elements stay apart nothing comes inside, so that the middle of an interval decides
        let mut search = InsideSearch { pairs, bodies: SearchedBodies::All, scratch };
        let add = |pair: WorldPair, lane: usize| {
            if !movers.contains(&pair.place) {
                near.push(NearPair { pair: world.number(pair), intervals: 1 << lane });
            }
            false
        };
        dispatch!(search.scratch.level(), simd => search.in_eight_states(simd, mask, &frame, add));
        near.sort_unstable_by_key(|near| near.pair);
        near.dedup_by(|next, first| {
            let is_same = next.pair == first.pair;
            if is_same {
                first.intervals |= next.intervals;
            }
            is_same
        });
    }
}

/// The largest padding (m) of any self pair and a margin (m), rounded up.
fn padding_with_slack(pairs: &CheckedPairs, margin: f64) -> f32 {
    round_up(pairs.self_pairs().largest_padding() + with_slack(margin))
}

/// A margin (m) with the slack of contacts and of the rounding of the margin itself.
fn with_slack(margin: f64) -> f64 {
    margin.lesser(LARGEST_MARGIN) * (1.0 + MARGIN_SLACK) + CONTACT_DISTANCE + MOTION_SLACK
}

/// By self pair: the sum of the values along its kinematic path; then by part: the sum along its path to the root. All
/// are rounded up.
fn sum_along_paths(pairs: &CheckedPairs, path_values: &[f64], sums: &mut Vec<f32>) {
    let robot = pairs.robot();
    sums.clear();
    sums.extend(pairs.self_pairs().sums_between(path_values, robot));
    sums.extend(robot.path_sums().to_root(path_values).map(round_up));
}
