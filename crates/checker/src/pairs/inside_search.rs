//! Search for robot bodies that are inside solid meshes of obstacles.
//!
//! It supplements the search for contacts of elements: where the elements of a robot body and an obstacle do not touch, every connected part
//! of either is wholly inside or outside the other. Parts of obstacles inside a robot body are found with their elements.

use clearance_geometry::math::Point;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Real, Simd, f32x8};
use clearance_proximity::Scratch;
use clearance_robot::{Chain, Frame};

use super::checked_pairs::CheckedPairs;
use crate::robot::DecisivePoint;
use crate::world::{EightPoints, WorldPair};

/// Search among the obstacles of a world.
pub struct InsideSearch<'s> {
    pub pairs: &'s CheckedPairs,
    pub bodies: SearchedBodies,
    pub scratch: &'s mut Scratch,
}

/// Robot bodies that are searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchedBodies {
    All,
    /// Those that joints move.
    Moving,
    /// Those that no joint moves.
    Fixed,
}

/// Eight points of robot bodies, in the root frame; bits of `among` select those that are searched for.
struct PlacedPoints<P: Fn(usize) -> usize> {
    points: [Point; LANES],
    among: u8,
    /// The robot body of each point.
    part: P,
}

impl InsideSearch<'_> {
    /// Visits pairs of which the robot body is inside the obstacle, in a state with these frames of chain bodies; a pair
    /// may be visited more than once. Ends early if the visitor returns true; returns whether it did.
    #[inline(always)]
    pub fn in_state<S: Simd>(
        &mut self,
        simd: S,
        frame: &impl Fn(usize) -> Frame<f64>,
        mut visit: impl FnMut(WorldPair) -> bool,
    ) -> bool {
        if self.pairs.world().inside().is_empty() {
            return false;
        }
        let frames = |chain_body: usize, _: usize| frame(chain_body);
        let mut visit = |pair, _: usize| visit(pair);
        // a loop: a closure that is not inlined is not compiled for the SIMD level
        for eight in self.points().chunks(LANES) {
            let point = |lane: usize| &eight[lane.min(eight.len() - 1)];
            let points = PlacedPoints {
                points: std::array::from_fn(|lane| point(lane).in_root(&frame(point(lane).chain_body))),
                among: u8::MAX >> (LANES - eight.len()),
                part: |lane| point(lane).part,
            };
            if self.visit_points(simd, &points, &frames, &mut visit) {
                return true;
            }
        }
        self.visit_cubes(1, &frames, &mut visit)
    }

    /// As [`Self::in_state`], for those of eight states that have a bit in `among`; the visitor is called with the number
    /// of the state, too.
    #[inline(always)]
    pub fn in_eight_states<S: Simd>(
        &mut self,
        simd: S,
        among: u8,
        frames: &impl Fn(usize, usize) -> Frame<f64>,
        mut visit: impl FnMut(WorldPair, usize) -> bool,
    ) -> bool {
        if among == 0 || self.pairs.world().inside().is_empty() {
            return false;
        }
        for point in self.points() {
            let points = PlacedPoints {
                points: std::array::from_fn(|lane| point.in_root(&frames(point.chain_body, lane))),
                among,
                part: |_| point.part,
            };
            if self.visit_points(simd, &points, frames, &mut visit) {
                return true;
            }
        }
        self.visit_cubes(among, frames, &mut visit)
    }

    /// The points of the bodies that are searched for.
    fn points<'p>(&self) -> &'p [DecisivePoint]
    where
        Self: 'p,
    {
        let points = self.pairs.robot().decisive_points();
        match self.bodies {
            SearchedBodies::All => points.all(),
            SearchedBodies::Moving => points.moving(),
            SearchedBodies::Fixed => points.fixed(),
        }
    }

    /// Visits pairs of which one of eight points of the robot body is inside the obstacle.
    #[inline(always)]
    fn visit_points<S: Simd>(
        &mut self,
        simd: S,
        PlacedPoints { points, among, part }: &PlacedPoints<impl Fn(usize) -> usize>,
        frames: &impl Fn(usize, usize) -> Frame<f64>,
        visit: &mut impl FnMut(WorldPair, usize) -> bool,
    ) -> bool {
        let Self { pairs, scratch, .. } = self;
        let world = pairs.world();
        let axis = |i: usize| f32x8::simd_from(simd, points.map(|p| p[i].single()));
        let query = EightPoints { points: [axis(0), axis(1), axis(2)], among: *among };
        let mut tests = 0;
        let ended = world.inside().find(simd, query, &mut tests, |place, lanes| {
            let mut left = lanes;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let pair = WorldPair { part: part(lane), place };
                let may_be_inside = world.checks(pair) && world.obstacle(place).may_contain(&points[lane]);
                let mut is_inside = || {
                    let pair = pairs.pair_with(world.number(pair), |chain_body| frames(chain_body, lane));
                    pair.is_inside(scratch)
                };
                if may_be_inside && is_inside() && visit(pair, lane) {
                    return true;
                }
            }
            false
        });
        scratch.work.volume_tests += tests;
        ended
    }

    /// Visits pairs of which the robot body has clouds or voxels, and is inside the obstacle.
    fn visit_cubes(
        &mut self,
        among: u8,
        frames: &impl Fn(usize, usize) -> Frame<f64>,
        visit: &mut impl FnMut(WorldPair, usize) -> bool,
    ) -> bool {
        let Self { pairs, bodies, scratch } = self;
        let (robot, world) = (pairs.robot(), pairs.world());
        let is_searched = |part: &usize| match bodies {
            SearchedBodies::All => true,
            SearchedBodies::Moving => robot[*part].chain_body() != Chain::ROOT,
            SearchedBodies::Fixed => robot[*part].chain_body() == Chain::ROOT,
        };
        let parts = robot.decisive_points().bodies_with_cubes().iter().copied().filter(is_searched);
        let all = parts.flat_map(|part| world.inside().places().map(move |place| WorldPair { part, place }));
        all.filter(|pair| world.checks(*pair)).any(|pair| {
            (0..LANES).filter(|lane| among & (1 << lane) != 0).any(|lane| {
                let posed = pairs.pair_with(world.number(pair), |chain_body| frames(chain_body, lane));
                posed.is_inside(scratch) && visit(pair, lane)
            })
        })
    }
}
