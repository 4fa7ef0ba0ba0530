//! Level 0 of a motion: capsules of all pairs, eight intervals at once.

use super::MotionScratch;
use crate::checker::batch::Eight;
use crate::checker::bodies::Rider;
use crate::checker::capsules::up;
use crate::checker::collision_checker::CollisionChecker;
use crate::checker::pair::PairInfo;
use crate::checker::workspace::Workspace;
use crate::constants::{CONTACT_DISTANCE, MOTION_SLACK};
use crate::math::UnitVector;
use crate::motion::MotionSegment;
use crate::robot::{Between, Chain, Deviation, Deviations};
use crate::simd::{LANES, Level, dispatch, dispatch_lean};

/// Where each body's ways stand in a list of all.
#[derive(Clone, Debug)]
pub struct Ways {
    /// By rider.
    starts: Vec<usize>,
    /// By pair: the two ways that matter.
    of_pairs: Vec<[usize; 2]>,
    /// By rider: how far it reaches (m) from its body's origin.
    reach: Vec<f64>,
}

/// The places of all ways.
pub fn ways_of(chain: &Chain, riders: &[Option<Rider>], infos: &[PairInfo], between: &[Between]) -> Ways {
    let (mut starts, mut reach, mut next) = (Vec::new(), Vec::new(), 0);
    for rider in riders {
        starts.push(next);
        reach.push(rider.as_ref().map_or(0.0, Rider::reach));
        next += rider.as_ref().map_or(0, |rider| chain.depth(rider.body) + 1);
    }
    let places = |(info, between): (&PairInfo, &Between)| {
        [starts[info.bodies.0] + between.side(0).len(), starts[info.bodies.1] + between.side(1).len()]
    };
    let of_pairs = infos.iter().zip(between).map(places).collect();
    Ways { starts, of_pairs, reach }
}

/// How positions deviate within one unit of t, at their fastest.
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

/// How far tolerances let positions be off.
struct Off<'s>(&'s MotionSegment);

impl Deviations for Off<'_> {
    fn of(&self, position: usize) -> Deviation {
        Deviation { off: self.0.tube().get(position).copied().unwrap_or(0.0), ..Deviation::default() }
    }

    fn half_width(&self) -> f64 {
        0.0
    }

    fn turn(&self, _: usize) -> Option<(UnitVector, f64)> {
        None
    }
}

impl CollisionChecker {
    /// For each pair, how far (m) it may come nearer in one unit of t, and how far tolerances let it be nearer.
    pub(super) fn approach_speeds(
        &self,
        segment: &MotionSegment,
        ways: &mut Vec<f64>,
        speeds: &mut Vec<f32>,
    ) {
        self.fill_ways(&AtTopSpeed(segment), segment, ways);
        speeds.clear();
        speeds.extend(self.ways.of_pairs.iter().map(|[a, b]| up(ways[*a] + ways[*b])));
    }

    /// For each pair, how much (m) nearer tolerances let it be.
    pub(super) fn tolerated(&self, segment: &MotionSegment, ways: &mut Vec<f64>, off: &mut Vec<f32>) {
        off.clear();
        if segment.tube().is_empty() {
            off.resize(self.infos.len(), 0.0);
            return;
        }
        self.fill_ways(&Off(segment), segment, ways);
        off.extend(self.ways.of_pairs.iter().map(|[a, b]| up(ways[*a] + ways[*b])));
    }

    fn fill_ways(&self, deviations: &impl Deviations, segment: &MotionSegment, ways: &mut Vec<f64>) {
        ways.clear();
        for (rider, reach) in self.riders.iter().zip(&self.ways.reach) {
            let Some(rider) = rider else { continue };
            self.chain.stretched_ways(rider.body, *reach, deviations, |i| segment.range(i), ways);
        }
        debug_assert!(self.ways.starts.last().is_none_or(|last| *last <= ways.len()));
    }

    /// For each pair, in which of the eight intervals of this half width around `middles` capsules do not prove it apart.
    pub(super) fn screen_intervals(
        &self,
        segment: &MotionSegment,
        (middles, half_width): ([f64; LANES], f64),
        (speeds, off): (&[f32], &[f32]),
        scratch: &mut MotionScratch,
        level: Level,
    ) {
        let margin = self.margins(half_width, speeds, off);
        let MotionScratch { positions, near, .. } = scratch;
        dispatch!(level, simd => {
            let mut eight = Eight::new(self, simd);
            for (lane, middle) in middles.iter().enumerate() {
                segment.positions_at(*middle, positions);
                for (column, position) in eight.positions.iter_mut().zip(&*positions) {
                    column[lane] = *position;
                }
            }
            eight.screen(simd, self, margin);
            std::mem::swap(near, &mut eight.near);
        });
    }

    /// By pair: nearer than this (m) it may come to touch within an interval of this half width.
    fn margins<'m>(
        &self,
        half_width: f64,
        speeds: &'m [f32],
        off: &'m [f32],
    ) -> impl Fn(usize) -> f32 + use<'m> {
        let padding = up(self.largest_padding + CONTACT_DISTANCE + MOTION_SLACK);
        let half_width = up(half_width * (1.0 + 1e-6));
        // without any width it is about states
        let loose = f32::from(u8::from(half_width > 0.0));
        move |i| (speeds[i] * half_width + off[i] * loose) * (1.0 + 1e-6) + padding
    }

    /// For each group of eight pairs, which of them capsules do not prove apart in the whole motion: from its middle alone.
    pub(super) fn screen_whole(
        &self,
        segment: &MotionSegment,
        (speeds, off): (&[f32], &[f32]),
        positions: &mut [f64],
        workspace: &mut Workspace,
    ) {
        segment.positions_at(0.5, positions);
        let margin = self.margins(0.5, speeds, off);
        // a group that is not full repeats its last pair
        let last = self.infos.len().saturating_sub(1);
        let margins = |group: usize| std::array::from_fn(|lane| margin((8 * group + lane).min(last)));
        let Workspace { frames, segments, near, scratch, .. } = workspace;
        scratch.work.volume_tests += self.infos.len() as u64;
        dispatch_lean!(scratch.level(), simd => {
            self.chain.frames_of_one(simd, positions, frames);
            self.capsules.place(frames, segments);
            self.capsules.near_one(simd, segments, margins, near);
        });
    }
}
