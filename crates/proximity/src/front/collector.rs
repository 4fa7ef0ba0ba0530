//! Collects the pairs of near elements of two bodies that a front lists.

use clearance_geometry::math::{Extremes, MatrixPose, Vector};
use clearance_geometry::simd::{LANES, Simd, not_beyond};

use super::front_limits::FrontLimits;
use super::listed_pair::{ListedPair, MOST};
use crate::body::{BodyPair, SolidLeaf, Surface};
use crate::bounding_volume::Relative;
use crate::bvh::{TreePair, TriangleLeaf, Visitor};
use crate::elements::{ElementId, ElementPair, RoundedShape};
use crate::narrow_phase::{
    LaneTriangles, MovedTriangles, f32_above, separation_within, shortened_to_f32, triangle_slack,
};
use crate::search::{Scratch, ScratchParts, Work};

/// The lists that a collection fills.
pub(super) struct PairLists<'l> {
    /// Pairs with a solid.
    pub with_solids: &'l mut Vec<ListedPair>,
    /// Pairs of triangles.
    pub of_triangles: &'l mut Vec<ListedPair>,
}

/// Lists all pairs of elements within the limits, or the nearest of these. Returns a lower bound on the distances of pairs that are not
/// listed; `None` if the search would cost too much. `direction` (frame of a) separates the nearest elements.
pub(super) fn collect(
    bodies: BodyPair,
    direction: &Vector,
    limits: FrontLimits,
    scratch: &mut Scratch,
    lists: PairLists,
) -> Option<f64> {
    let BodyPair { a, b, pose_ab } = bodies;
    let PairLists { with_solids, of_triangles } = lists;
    let ScratchParts { work, traversal, .. } = scratch.begin();
    let beyond = limits.beyond;
    let most = work.cost().saturating_add(limits.most_work);
    let mut near = Near { beyond: f32_above(beyond), pose_ab, work, most, listed: with_solids };
    if let (Some(a), Some(b)) = (a.solids(), b.solids()) {
        let relative = &a.relative(b, pose_ab);
        traversal.run(TreePair { a, b, relative }, &mut SolidsAndSolids(&mut near));
    }
    if let (Some(solids), Some(surface)) = (a.solids(), b.surface()) {
        let relative = &solids.relative(surface.tree(), pose_ab);
        let visitor = &mut SolidsAndSurface { near: &mut near, surface, solid_is_a: true };
        traversal.run(TreePair { a: solids, b: surface.tree(), relative }, visitor);
    }
    if let (Some(surface), Some(solids)) = (a.surface(), b.solids()) {
        let relative = &solids.relative(surface.tree(), &pose_ab.inverse());
        let visitor = &mut SolidsAndSurface { near: &mut near, surface, solid_is_a: false };
        traversal.run(TreePair { a: solids, b: surface.tree(), relative }, visitor);
    }
    near.keep_nearest(MOST);
    near.listed = of_triangles;
    if let (Some(a), Some(b)) = (a.surface(), b.surface()) {
        let relative = &a.tree().relative(b.tree(), pose_ab);
        let direction = shortened_to_f32(&pose_ab.rotation.tr_mul(direction));
        let visitor = &mut SurfaceAndSurface { near: &mut near, relative, direction };
        traversal.run(TreePair { a: a.tree(), b: b.tree(), relative }, visitor);
    }
    near.keep_nearest(MOST);
    (!near.costs_too_much()).then(|| f64::from(near.beyond).lesser(beyond))
}

/// The pairs listed so far, and the limit for further ones.
struct Near<'n> {
    beyond: f32,
    pose_ab: &'n MatrixPose,
    work: &'n mut Work,
    /// Limit on the work.
    most: u64,
    listed: &'n mut Vec<ListedPair>,
}

impl Near<'_> {
    fn costs_too_much(&self) -> bool {
        self.work.cost() > self.most
    }

    /// Removes the farthest pairs, if there are too many: the limit is then the distance of the nearest removed one.
    fn keep_nearest(&mut self, most: usize) {
        if self.listed.len() > most {
            let (_, farthest, _) = self.listed.select_nth_unstable_by(most, ListedPair::by_distance);
            self.beyond = self.beyond.lesser(farthest.lower);
            self.listed.truncate(most);
        }
    }

    fn list(&mut self, lower: f32, elements: ElementPair) {
        self.listed.push(ListedPair { lower, elements });
        if self.listed.len() > 2 * MOST {
            self.keep_nearest(MOST);
        }
    }

    /// Measures a pair with a solid.
    #[allow(clippy::cast_possible_truncation)] // rounded down right after
    fn measure(&mut self, a: &RoundedShape, b: &RoundedShape, elements: ElementPair) {
        self.work.primitive_tests += 1;
        if let Some(found) = separation_within(a, b, self.pose_ab, f64::from(self.beyond)) {
            self.list((found.distance as f32).next_down(), elements);
        }
    }
}

struct SolidsAndSolids<'c, 'n>(&'c mut Near<'n>);

impl Visitor<SolidLeaf, SolidLeaf> for SolidsAndSolids<'_, '_> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.0.beyond
    }

    fn volume_tests(&mut self, count: u32) {
        self.0.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.0.costs_too_much()
    }

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, _: S, a: &SolidLeaf, b: &SolidLeaf) {
        let elements = ElementPair { a: ElementId::of_solid(a.index), b: ElementId::of_solid(b.index) };
        self.0.measure(&a.shape, &b.shape, elements);
    }
}

struct SolidsAndSurface<'c, 'n> {
    near: &'c mut Near<'n>,
    surface: &'c Surface,
    solid_is_a: bool,
}

impl Visitor<SolidLeaf, TriangleLeaf> for SolidsAndSurface<'_, '_> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.near.beyond
    }

    fn volume_tests(&mut self, count: u32) {
        self.near.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.near.costs_too_much()
    }

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, _: S, solid: &SolidLeaf, leaf: &TriangleLeaf) {
        let id = ElementId::of_solid(solid.index);
        for i in leaf.first..leaf.first + leaf.count {
            let triangle = &self.surface.shape(i);
            let elements = ElementPair::ordered(id, ElementId::of_triangle(i), self.solid_is_a);
            if self.solid_is_a {
                self.near.measure(&solid.shape, triangle, elements);
            } else {
                self.near.measure(triangle, &solid.shape, elements);
            }
        }
    }
}

struct SurfaceAndSurface<'c, 'n> {
    near: &'c mut Near<'n>,
    relative: &'c Relative,
    /// Direction of the nearest separation, in the frame of b's tree; length at most one.
    direction: [f32; 3],
}

impl Visitor<TriangleLeaf, TriangleLeaf> for SurfaceAndSurface<'_, '_> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.near.beyond
    }

    fn direction(&self) -> [f32; 3] {
        self.direction
    }

    fn volume_tests(&mut self, count: u32) {
        self.near.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.near.costs_too_much()
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, a: &TriangleLeaf, b: &TriangleLeaf) {
        let slack = triangle_slack(self.relative);
        let margin = self.near.beyond + 4.0 * slack;
        let (moved, mut lanes) = MovedTriangles::new(simd, a, self.relative, (&b.low, &b.high), margin);
        if lanes == 0 {
            return;
        }
        let eight = LaneTriangles::of_leaf(simd, b);
        while lanes != 0 {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            self.near.work.screened_pairs += u64::from(b.count);
            let one = moved.one(simd, lane as usize);
            let coarse = one.coarse_bounds(simd, &eight, &self.direction, slack);
            if not_beyond(coarse, self.near.beyond) & b.mask() == 0 {
                continue;
            }
            let lower = one.bounds(simd, &eight, slack).lower;
            let mut near = not_beyond(lower, self.near.beyond) & b.mask();
            let lower: [f32; LANES] = lower.into();
            while near != 0 {
                let other = near.trailing_zeros();
                near &= near - 1;
                let [i, j] = [a.first + lane, b.first + other].map(ElementId::of_triangle);
                self.near.list(lower[other as usize & 7], ElementPair { a: i, b: j });
            }
        }
    }
}
