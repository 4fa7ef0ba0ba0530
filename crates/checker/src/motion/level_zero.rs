//! Level 0 of a motion: capsule bounds of all pairs in eight intervals at once.

use clearance_geometry::constants::{CONTACT_DISTANCE, MOTION_SLACK};
use clearance_geometry::math::UnitVector;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, dispatch, f64x8};
use clearance_motion::MotionSegment;
use clearance_robot::{Deviation, Deviations, Frame, PathsToRoot};

use super::MotionScratch;
use super::interval_midpoint::of_whole_interval;
use crate::batch::Eight;
use crate::bodies::RobotBody;
use crate::capsules::up;
use crate::collision_checker::CollisionChecker;
use crate::questions::near_pairs;
use crate::workspace::Workspace;

/// Index of each part's kinematic paths in a list of the paths of all parts.
#[derive(Clone, Debug)]
pub struct Ways {
    /// By part: its first path, which has no joints.
    starts: Vec<usize>,
    /// By part: the path to the root, which matters for static obstacles.
    to_root: Vec<usize>,
    /// By part: the radius (m) around its body's origin that contains it.
    reach: Vec<f64>,
}

impl Ways {
    pub fn new(paths_to_root: &PathsToRoot, robot_bodies: &[RobotBody]) -> Self {
        let (mut starts, mut to_root) = (Vec::new(), Vec::new());
        let mut next = 0;
        for robot_body in robot_bodies {
            let depth = paths_to_root.depth(robot_body.body);
            starts.push(next);
            to_root.push(next + depth);
            next += depth + 1;
        }
        Self { starts, to_root, reach: robot_bodies.iter().map(RobotBody::reach).collect() }
    }
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
struct Off<'s>(&'s MotionSegment);

impl Deviations for Off<'_> {
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

impl CollisionChecker {
    /// For each self pair, the maximum decrease (m) of its distance in one unit of t; then for each part, the maximum decrease of its
    /// distance to static obstacles.
    pub(super) fn approach_speeds(
        &self,
        segment: &MotionSegment,
        ways: &mut Vec<f64>,
        speeds: &mut Vec<f32>,
    ) {
        self.fill_ways(&AtTopSpeed(segment), segment, ways);
        self.sums(ways, speeds);
        if self.pairs().world_len() == 0 {
            speeds[self.infos.len()..].fill(0.0);
        }
    }

    /// In the same order, the decrease (m) that tolerances allow.
    pub(super) fn tolerated(&self, segment: &MotionSegment, ways: &mut Vec<f64>, off: &mut Vec<f32>) {
        if segment.tube().is_empty() {
            off.clear();
            off.resize(self.infos.len() + self.robot_bodies.len(), 0.0);
            return;
        }
        self.fill_ways(&Off(segment), segment, ways);
        self.sums(ways, off);
    }

    fn fill_ways(&self, deviations: &impl Deviations, segment: &MotionSegment, ways: &mut Vec<f64>) {
        ways.clear();
        for (robot_body, reach) in self.robot_bodies.iter().zip(&self.ways.reach) {
            self.chain.stretched_ways(robot_body.body, *reach, deviations, |i| segment.range(i), ways);
        }
    }

    fn sums(&self, ways: &[f64], sums: &mut Vec<f32>) {
        sums.clear();
        let way = |part: usize, joints: u32| ways[self.ways.starts[part] + joints as usize];
        let of_pairs = self.infos.iter().zip(&self.joints_between);
        sums.extend(of_pairs.map(|(info, [a, b])| up(way(info.bodies.0, *a) + way(info.bodies.1, *b))));
        sums.extend(self.ways.to_root.iter().map(|way| up(ways[*way])));
    }

    /// The pairs that capsules do not prove apart in eight intervals of this half width around `middles`.
    pub(super) fn screen_intervals(
        &self,
        segment: &MotionSegment,
        (middles, half_width): ([f64; LANES], f64),
        (speeds, off): (&[f32], &[f32]),
        scratch: &mut MotionScratch,
        workspace: &mut Workspace,
    ) {
        let motion = Self::motion_within(half_width, speeds, off);
        let padding = up(self.largest_padding + CONTACT_DISTANCE + MOTION_SLACK);
        let MotionScratch { positions, columns, near, .. } = scratch;
        near.clear();
        columns.resize(positions.len(), [0.0; LANES]);
        workspace.scratch.work.volume_tests += (self.infos.len() * LANES) as u64;
        dispatch!(workspace.scratch.level(), simd => {
            let mut eight = Eight::new(self, simd);
            for (lane, middle) in middles.iter().enumerate() {
                segment.positions_at(*middle, positions);
                for (column, position) in columns.iter_mut().zip(&*positions) {
                    column[lane] = *position;
                }
            }
            eight.screen(
                simd,
                self,
                #[inline(always)]
                |i| f64x8::from_slice(simd, &columns[i]),
                #[inline(always)]
                |i| motion(i) + padding,
            );
            let of_parts = eight.near.iter().enumerate().filter(|(_, intervals)| **intervals != 0);
            near.extend(of_parts.map(|(pair, intervals)| NearPair { pair, intervals: *intervals }));
            let frame = |body: usize, lane: usize| eight.frame(body, lane);
            self.screen_obstacles(segment, frame, |part| motion(self.infos.len() + part), workspace, near);
        });
    }

    /// As [`Self::screen_intervals`], for pairs with obstacles.
    fn screen_obstacles(
        &self,
        segment: &MotionSegment,
        frame: impl Fn(usize, usize) -> Frame<f64>,
        motion: impl Fn(usize) -> f32,
        workspace: &mut Workspace,
        near: &mut Vec<NearPair>,
    ) {
        if self.pairs().world_len() == 0 {
            return;
        }
        let movers = self.moving_places(segment);
        for (part, robot_body) in self.robot_bodies.iter().enumerate() {
            let capsules: [_; LANES] =
                std::array::from_fn(|lane| self.capsule_of(part, &frame(robot_body.body, lane)));
            let motion = f64::from(motion(part));
            self.each_obstacle_near(part, &capsules, motion, workspace, |place, intervals| {
                if !movers.contains(&place) {
                    near.push(NearPair { pair: self.world_pair(part, place), intervals });
                }
            });
            // level 0 does not bound moving obstacles
            let moving =
                movers.iter().map(|place| self.world_pair(part, *place)).filter(|i| self.is_pair(*i));
            near.extend(moving.map(|pair| NearPair { pair, intervals: u8::MAX }));
        }
        near.sort_unstable_by_key(|near| near.pair);
    }

    /// By index of [`Self::approach_speeds`]: the maximum decrease (m) of the distance within an interval of this half width.
    fn motion_within<'m>(
        half_width: f64,
        speeds: &'m [f32],
        off: &'m [f32],
    ) -> impl Fn(usize) -> f32 + use<'m> {
        let half_width = up(half_width * (1.0 + 1e-6));
        // an interval of zero width is a state
        let loose = f32::from(u8::from(half_width > 0.0));
        move |i| (speeds[i] * half_width + off[i] * loose) * (1.0 + 1e-6)
    }

    /// The pairs that capsules do not prove apart in the whole motion, from its middle alone; reported as the first interval.
    pub(super) fn screen_whole(
        &self,
        segment: &MotionSegment,
        (speeds, off): (&[f32], &[f32]),
        scratch: &mut MotionScratch,
        workspace: &mut Workspace,
    ) {
        let MotionScratch { positions, near: found, .. } = scratch;
        segment.positions_at(0.5, positions);
        let motion = Self::motion_within(0.5, speeds, off);
        let padding = up(self.largest_padding + CONTACT_DISTANCE + MOTION_SLACK);
        // an incomplete group repeats its last pair
        let last = self.infos.len().saturating_sub(1);
        let margins =
            |group: usize| std::array::from_fn(|lane| motion((LANES * group + lane).min(last)) + padding);
        let Workspace { frames, segments, near, scratch, .. } = &mut *workspace;
        scratch.work.volume_tests += self.infos.len() as u64;
        dispatch!(scratch.level(), simd => {
            self.place_one(simd, positions, frames, segments);
            self.capsules.near_one(simd, segments, margins, near);
        });
        found.clear();
        found.extend(near_pairs(near).map(|pair| NearPair { pair, intervals: 1 }));
        let frames = std::mem::take(&mut workspace.frames);
        let motion = |part: usize| motion(self.infos.len() + part);
        self.screen_obstacles(segment, |body, _| frames[body].frame(), motion, workspace, found);
        workspace.frames = frames;
    }

    /// The pairs that capsules do not prove apart in an interval of a widening motion; reported as the first interval.
    pub(super) fn screen_widening(
        &self,
        segment: &MotionSegment,
        [from, to]: [f64; 2],
        scratch: &mut MotionScratch,
        workspace: &mut Workspace,
    ) {
        let MotionScratch { positions, near: found, .. } = scratch;
        found.clear();
        found.extend((0..self.infos.len()).map(|pair| NearPair { pair, intervals: 1 }));
        if self.pairs().world_len() == 0 {
            return;
        }
        segment.positions_at(0.5 * (from + to), positions);
        let mut frames = std::mem::take(&mut workspace.frames);
        dispatch!(workspace.scratch.level(), simd => {
            self.chain.frames_of_one(simd, positions, &mut frames, |_, _| {});
        });
        let whole = of_whole_interval(segment, [from, to]);
        let motion = |part: usize| {
            let reach = self.reach_of(part, &frames[self.robot_bodies[part].body].frame());
            let moved = self.chain.side_motion(self.to_root(part).side(0), &reach, &frames, &whole);
            up((moved.path_length + moved.tolerance) * (1.0 + MOTION_SLACK) + MOTION_SLACK)
        };
        self.screen_obstacles(segment, |body, _| frames[body].frame(), motion, workspace, found);
        workspace.frames = frames;
    }
}
