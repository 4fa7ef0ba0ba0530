//! Front: the pairs of elements of two bodies that may be nearest in all poses near one. They are found once, and updated while the
//! bodies move little (Ehmann & Lin 2001 call such a set a front).
//!
//! # The bounds
//!
//! At the pose where they were listed, each pair has a unit direction n (frame of b) along which its elements have a gap of at least g.
//! Later every point x of a has moved, in the frame of b, by u(x) = u(c) + ΔR (x − c) for any point c of a. ΔR, the difference of two
//! rotations, stretches no vector by more than its Frobenius norm over √2 (both its singular values that are not zero are 2 sin θ/2).
//! With r the largest distance of the pair's element of a from c,
//!
//! > d ≥ g − n·u(c) − |ΔR| r.
//!
//! The common motion of all pairs thus cancels between them: their order changes only by the rotation. For pairs that are not listed, the
//! motion of the whole body is assumed.
//!
//! # Closed meshes as solids
//!
//! The distance of two solids decreases at most by the motion of one in the frame of the other. So neither is inside the other at a pose,
//! if they were farther apart at an earlier pose than the motion between. Only after a larger motion is a point of each part tested.

mod bounds;
mod collector;
mod eight_pairs;
mod front_limits;
mod listed_pair;

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Level, Simd, dispatch, f32x8, not_beyond};

use crate::body::{BodyPair, CollisionBody};
use crate::bvh::Visitor;
use crate::narrow_phase::{Separation, TrianglePairs, separation_within, triangle_slack};
use crate::search::{
    BestSoFar, Goal, Scratch, ScratchParts, SearchedPieces, SurfaceSurfaceVisitor, TriangleCandidates,
    contained_point,
};
use bounds::Bounds;
use collector::{PairLists, collect};
use eight_pairs::EightPairs;
use listed_pair::ListedPair;

pub use front_limits::FrontLimits;

/// Pairs of elements of two bodies.
#[derive(Clone, Debug, Default)]
pub struct Front {
    /// Pose of b in the frame of a at which the pairs were listed; `None` if there is no front.
    listed_at: Option<MatrixPose>,
    /// Elements that are not listed were farther apart than this (m) at that pose.
    beyond: f64,
    with_solids: Group,
    of_triangles: Group,
    /// Last pose of b in the frame of a at which neither body had a part inside the other, and a lower bound (m) on their distance there.
    outside: Option<(MatrixPose, f64)>,
}

/// Listed pairs of one kind.
#[derive(Clone, Debug, Default)]
struct Group {
    listed: Vec<ListedPair>,
    bounds: Bounds,
}

impl Front {
    /// True if it holds any pair.
    #[must_use]
    #[inline]
    pub fn is_collected(&self) -> bool {
        self.listed_at.is_some()
    }

    /// Removes everything.
    #[inline]
    pub fn clear(&mut self) {
        self.listed_at = None;
        self.with_solids.listed.clear();
        self.of_triangles.listed.clear();
    }

    /// Lists the elements of two bodies that may be within `limits.beyond` of each other, or the nearest of these if they are many.
    /// `nearest` is the result of a search at that pose. Bodies with planes, points or voxels have no front. There is no front either if it
    /// would cost more than the limits allow.
    #[inline]
    pub fn collect(
        &mut self,
        bodies: BodyPair,
        nearest: &Separation,
        limits: FrontLimits,
        scratch: &mut Scratch,
    ) {
        self.clear();
        let has_none = |body: &CollisionBody| body.has_cubes() || body.has_planes();
        if has_none(bodies.a) || has_none(bodies.b) {
            return;
        }
        let lists = PairLists {
            with_solids: &mut self.with_solids.listed,
            of_triangles: &mut self.of_triangles.listed,
        };
        let Some(beyond) = collect(bodies, &nearest.direction(), limits, scratch, lists) else {
            return self.clear();
        };
        self.beyond = beyond;
        self.listed_at = Some(*bodies.pose_ab);
        self.outside = Some((*bodies.pose_ab, nearest.distance));
        let near_a = &nearest.witness_points[0];
        self.with_solids.renew(bodies, near_a, scratch.level());
        self.of_triangles.renew(bodies, near_a, scratch.level());
    }

    /// The distance of the bodies at another pose, with the same result as a search: `Some(None)` if it is proven larger than `limit`
    /// (m). `None` where the front does not suffice, or the bodies touch.
    #[must_use]
    pub fn distance(
        &mut self,
        bodies: BodyPair,
        limit: f64,
        scratch: &mut Scratch,
    ) -> Option<Option<Separation>> {
        let BodyPair { b, pose_ab, .. } = bodies;
        let moved = b.bounding_sphere().displacement(self.listed_at.as_ref()?, pose_ab);
        let certain = self.beyond - moved;
        if certain <= 0.0 {
            return None;
        }
        let level = scratch.level();
        let goal = Goal { limit: limit.lesser(certain), ..Goal::EXACT };
        let ScratchParts { work, candidates, .. } = scratch.begin();
        let best_so_far = &mut BestSoFar::new(goal, work);
        let update = FrontUpdate { bodies, level };
        let of_solids = self.with_solids.bounds.move_to(pose_ab, level);
        let of_triangles = self.of_triangles.bounds.move_to(pose_ab, level);
        // the nearest pair of all first: the others then mostly exceed its distance
        let solids_first = of_solids.lower < of_triangles.lower;
        let mut unclear = [0; 2];
        if solids_first {
            unclear[0] = update.test_solids(&self.with_solids, of_solids.index, best_so_far);
        }
        unclear[1] = update.test_triangles(&self.of_triangles, of_triangles.index, best_so_far, candidates);
        if !solids_first {
            unclear[0] = update.test_solids(&self.with_solids, of_solids.index, best_so_far);
        }
        let found = best_so_far.separation();
        if let Some(found) = found {
            for (group, unclear) in [&mut self.with_solids, &mut self.of_triangles].into_iter().zip(unclear) {
                if group.bounds.are_worn(unclear) {
                    group.renew(bodies, &found.witness_points[0], level);
                }
            }
        }
        let result = match found {
            Some(found) if found.distance > 0.0 => Some(found),
            None if limit <= certain => None,
            _ => return None,
        };
        let lower = result.map_or(limit, |found| found.distance);
        self.stays_outside(bodies, lower, scratch).then_some(result)
    }

    /// True if neither body has a part inside the other. Their surfaces must be more than `lower` (m) apart, or just as much.
    fn stays_outside(&mut self, bodies: BodyPair, lower: f64, scratch: &mut Scratch) -> bool {
        let BodyPair { a, b, pose_ab } = bodies;
        if !bodies.has_inside() {
            return true;
        }
        let is_known = self.outside.is_some_and(|(from, distance)| {
            let moved_a = || a.bounding_sphere().displacement(&from.inverse(), &pose_ab.inverse());
            let needed = distance - CONTACT_DISTANCE;
            b.bounding_sphere().displacement(&from, pose_ab) < needed || moved_a() < needed
        });
        let is_outside = is_known || {
            let ScratchParts { work, traversal, .. } = scratch.begin();
            let best_so_far = &mut BestSoFar::new(Goal::CONTACT, work);
            matches!(contained_point(bodies, SearchedPieces::All, best_so_far, traversal), Ok(None))
        };
        self.outside = is_outside.then_some((*pose_ab, lower));
        is_outside
    }
}

impl Group {
    /// Recomputes the bounds of all pairs, from a point of a near the nearest elements.
    fn renew(&mut self, bodies: BodyPair, near_a: &Point, level: Level) {
        self.bounds.renew(bodies, near_a, &self.listed, level);
    }
}

/// The update of a front at a new pose.
struct FrontUpdate<'l> {
    bodies: BodyPair<'l>,
    level: Level,
}

impl FrontUpdate<'_> {
    /// Measures the pair with the least bound, and then all that may still be nearer; returns the number of these.
    fn test_solids(&self, group: &Group, first: usize, best_so_far: &mut BestSoFar) -> usize {
        let Some(first) = group.listed.get(first) else { return 0 };
        self.measure(first, best_so_far);
        let mut unclear = 0;
        for (pair, bound) in group.listed.iter().zip(group.bounds.now().iter().flatten()) {
            // NaN proves nothing
            if *bound <= best_so_far.threshold() || bound.is_nan() {
                unclear += 1;
                self.measure(pair, best_so_far);
            }
        }
        unclear
    }

    fn measure(&self, pair: &ListedPair, best_so_far: &mut BestSoFar) {
        best_so_far.work.primitive_tests += 1;
        let (a, b) = (self.bodies.a.element(pair.elements.a), self.bodies.b.element(pair.elements.b));
        if let Some(found) = separation_within(&a, &b, self.bodies.pose_ab, best_so_far.bound()) {
            best_so_far.offer_elements(found, pair.elements);
        }
    }

    /// As [`Self::test_solids`], after an f32 test of those that may be nearer, eight at a time.
    fn test_triangles(
        &self,
        group: &Group,
        first: usize,
        best_so_far: &mut BestSoFar,
        candidates: &mut TriangleCandidates,
    ) -> usize {
        let BodyPair { a, b, pose_ab } = self.bodies;
        let (Some(a), Some(b)) = (a.surface(), b.surface()) else { return 0 };
        let Some(first) = group.listed.get(first) else { return 0 };
        let relative = &a.tree().relative(b.tree(), pose_ab);
        candidates.begin(None);
        let surfaces = &mut SurfaceSurfaceVisitor { a, b, pose_ab, relative, best_so_far, candidates };
        surfaces.measure(first.elements.a.index(), first.elements.b.index());
        let unclear = dispatch!(self.level, simd => screen_unclear(simd, group, surfaces));
        surfaces.measure_candidates();
        unclear
    }
}

/// Tests the pairs of triangles that may be nearer in f32, eight at a time; returns their number.
#[inline(always)]
fn screen_unclear<S: Simd>(
    simd: S,
    group: &Group,
    surfaces: &mut SurfaceSurfaceVisitor<'_, '_, false>,
) -> usize {
    let (mut eight, mut count, mut unclear) = ([group.listed[0]; LANES], 0, 0);
    for (pairs, bounds) in group.listed.chunks(LANES).zip(group.bounds.now()) {
        let all = u64::from(u8::MAX >> (LANES - pairs.len()));
        let mut near = not_beyond(f32x8::simd_from(simd, *bounds), surfaces.threshold()) & all;
        while near != 0 {
            eight[count] = pairs[near.trailing_zeros() as usize];
            (near, count, unclear) = (near & (near - 1), count + 1, unclear + 1);
            if count == LANES {
                screen(simd, &eight, surfaces);
                count = 0;
            }
        }
    }
    if count > 0 {
        screen(simd, &eight[..count], surfaces);
    }
    unclear
}

#[inline(always)]
fn screen<S: Simd>(simd: S, pairs: &[ListedPair], surfaces: &mut SurfaceSurfaceVisitor<'_, '_, false>) {
    let corners = EightPairs::new(surfaces.a, surfaces.b, pairs);
    let (one, other) = corners.load(simd, surfaces.relative);
    let mask = u64::from(u8::MAX >> (LANES - pairs.len()));
    let slack = triangle_slack(surfaces.relative);
    let indices = |lane: usize| (pairs[lane].elements.a.index(), pairs[lane].elements.b.index());
    surfaces.screen(simd, TrianglePairs { one: &one, other: &other, slack, mask }, indices);
}
