//! Collects the near elements of two bodies.

use clearance_geometry::math::{Extremes, MatrixPose, Vector};
use clearance_geometry::simd::{LANES, Simd, dispatch, not_beyond};

use super::bounds::round_up;
use super::{Listed, MOST};
use crate::body::CollisionBody;
use crate::bounding_volume::{Obb, Relative};
use crate::bvh::{TriangleLeaf, Visitor, descend};
use crate::core::RoundedCore;
use crate::element::ElementNumber;
use crate::element_pair::separation_within;
use crate::scratch::Scratch;
use crate::solid::SolidLeaf;
use crate::surface::Surface;
use crate::surface_surface::triangle_slack;
use crate::triangle_lanes::{LaneTriangles, MovedTriangles};
use crate::work::Work;

/// Lists all pairs of elements that may be within `beyond` (m), or the nearest of these. Returns a lower bound on the distances of pairs
/// that are not listed; `None` if the search would cost more than `most`. `direction` (frame of a) separates the nearest elements.
pub(super) fn collect(
    (a, b): (&CollisionBody, &CollisionBody),
    pose_ab: &MatrixPose,
    direction: Vector,
    (beyond, most): (f64, u64),
    scratch: &mut Scratch,
    (with_solids, of_triangles): (&mut Vec<Listed>, &mut Vec<Listed>),
) -> Option<f64> {
    let level = scratch.level();
    let Scratch { work, stack, .. } = scratch;
    let most = work.cost().saturating_add(most);
    let mut near = Near { beyond: round_up(beyond), pose_ab, work, most, listed: with_solids };
    if let (Some(a), Some(b)) = (&a.solids, &b.solids) {
        let relative = &a.relative(b, pose_ab);
        dispatch!(level, simd => descend(simd, (a, b), relative, stack, &mut SolidsAndSolids(&mut near)));
    }
    if let (Some(solids), Some(surface)) = (&a.solids, &b.surface) {
        let relative = &solids.relative(&surface.tree, pose_ab);
        let visitor = &mut SolidsAndSurface { near: &mut near, surface, solid_is_a: true };
        dispatch!(level, simd => descend(simd, (solids, &surface.tree), relative, stack, visitor));
    }
    if let (Some(surface), Some(solids)) = (&a.surface, &b.solids) {
        let relative = &solids.relative(&surface.tree, &pose_ab.inverse());
        let visitor = &mut SolidsAndSurface { near: &mut near, surface, solid_is_a: false };
        dispatch!(level, simd => descend(simd, (solids, &surface.tree), relative, stack, visitor));
    }
    near.keep_nearest(MOST);
    near.listed = of_triangles;
    if let (Some(a), Some(b)) = (&a.surface, &b.surface) {
        let relative = &a.tree.relative(&b.tree, pose_ab);
        let visitor = &mut Surfaces {
            near: &mut near,
            relative,
            direction: shortened(&pose_ab.rotation.tr_mul(&direction)),
        };
        dispatch!(level, simd => descend(simd, (&a.tree, &b.tree), relative, stack, visitor));
    }
    near.keep_nearest(MOST);
    (!near.costs_too_much()).then(|| f64::from(near.beyond).lesser(beyond))
}

/// A unit vector in f32, not longer than one.
#[allow(clippy::cast_possible_truncation)] // rounding is meant
fn shortened(n: &Vector) -> [f32; 3] {
    let n = n * (1.0 - f64::from(8.0 * f32::EPSILON));
    [n.x as f32, n.y as f32, n.z as f32]
}

/// The pairs listed so far, and the limit for further ones.
struct Near<'n> {
    beyond: f32,
    pose_ab: &'n MatrixPose,
    work: &'n mut Work,
    /// Limit on the work.
    most: u64,
    listed: &'n mut Vec<Listed>,
}

impl Near<'_> {
    fn costs_too_much(&self) -> bool {
        self.work.cost() > self.most
    }

    /// Removes the farthest pairs, if there are too many: the limit is then the distance of the nearest removed one.
    fn keep_nearest(&mut self, most: usize) {
        if self.listed.len() > most {
            let (_, farthest, _) = self.listed.select_nth_unstable_by(most, Listed::by_distance);
            self.beyond = self.beyond.lesser(farthest.lower);
            self.listed.truncate(most);
        }
    }

    fn list(&mut self, lower: f32, a: ElementNumber, b: ElementNumber) {
        self.listed.push(Listed { lower, a, b });
        if self.listed.len() > 2 * MOST {
            self.keep_nearest(MOST);
        }
    }

    /// Measures a pair with a solid.
    #[allow(clippy::cast_possible_truncation)] // rounded down right after
    fn measure(&mut self, (a, b): (&RoundedCore, &RoundedCore), numbers: (ElementNumber, ElementNumber)) {
        self.work.primitive_tests += 1;
        if let Some(found) = separation_within(a, b, self.pose_ab, f64::from(self.beyond)) {
            self.list((found.distance as f32).next_down(), numbers.0, numbers.1);
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
        let numbers = (ElementNumber::of_solid(a.number), ElementNumber::of_solid(b.number));
        self.0.measure((&a.core, &b.core), numbers);
    }
}

struct SolidsAndSurface<'c, 'n> {
    near: &'c mut Near<'n>,
    surface: &'c Surface<Obb>,
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
        let number = ElementNumber::of_solid(solid.number);
        for i in leaf.first..leaf.first + leaf.count {
            let (other, triangle) = (ElementNumber::of_triangle(i), self.surface.core(i));
            if self.solid_is_a {
                self.near.measure((&solid.core, &triangle), (number, other));
            } else {
                self.near.measure((&triangle, &solid.core), (other, number));
            }
        }
    }
}

struct Surfaces<'c, 'n> {
    near: &'c mut Near<'n>,
    relative: &'c Relative,
    /// Direction of the nearest separation, in the frame of b's tree; length at most one.
    direction: [f32; 3],
}

impl Visitor<TriangleLeaf, TriangleLeaf> for Surfaces<'_, '_> {
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
                let numbers = [a.first + lane, b.first + other].map(ElementNumber::of_triangle);
                self.near.list(lower[other as usize & 7], numbers[0], numbers[1]);
            }
        }
    }
}
