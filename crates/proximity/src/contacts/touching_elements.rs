//! Enumeration of the elements of two bodies that touch, with bounded work.
//!
//! Where there are too many, the second body is divided into subtrees, each of which gets the same share: what is left out is then left
//! out evenly.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_geometry::simd::{Simd, not_beyond};

use crate::body::SolidLeaf;
use crate::bounding_volume::{Obb, Relative};
use crate::bvh::{CubeLeaf, NodeRef, Tree, TreePair, TriangleLeaf, Visitor};
use crate::narrow_phase::{
    LaneTriangles, MovedTriangles, OneTriangle, f32_above, lower_bounds_of_cubes, lower_bounds_of_triangles,
    triangle_slack, widened,
};
use crate::search::{Scratch, ScratchParts, Work};

/// Most pairs of elements that are passed on.
const MOST_PAIRS: usize = 4096;

/// Most pairs of subtrees that are opened or compared.
const MOST_STEPS: usize = 1 << 15;

/// Number of leaves of the second tree from which it is divided.
const LARGE: usize = 512;

/// Level of the second tree's nodes that get equal shares: 64 of them, with eight children to a node.
const SHARED_LEVEL: usize = 2;

/// Passes the indices of all elements that may come within `reach` (m) to `meets`, which returns whether they do. Balls of `radius` (m)
/// around the elements of the second tree count.
pub(super) fn for_touching<LA, LB>(
    trees: TreePair<Obb, LA, LB>,
    reach: f64,
    radius: f64,
    scratch: &mut Scratch,
    meets: &mut dyn FnMut(u32, u32) -> bool,
) where
    for<'w> TouchingElements<'w, true>: Visitor<LA, LB>,
    for<'w> TouchingElements<'w, false>: Visitor<LA, LB>,
{
    if reach + radius > CONTACT_DISTANCE {
        run::<LA, LB, false>(trees, reach, radius, scratch, meets);
    } else {
        run::<LA, LB, true>(trees, reach, radius, scratch, meets);
    }
}

fn run<LA, LB, const SEPARATE: bool>(
    trees: TreePair<Obb, LA, LB>,
    reach: f64,
    radius: f64,
    scratch: &mut Scratch,
    meets: &mut dyn FnMut(u32, u32) -> bool,
) where
    for<'w> TouchingElements<'w, SEPARATE>: Visitor<LA, LB>,
{
    let ScratchParts { work, traversal, .. } = scratch.begin();
    let starts = starts(trees.b);
    let share = Share { steps: MOST_STEPS / starts.len(), pairs: MOST_PAIRS / starts.len() };
    let threshold = widened(f32_above(reach.greater(CONTACT_DISTANCE)), radius);
    let mut visitor =
        TouchingElements::<SEPARATE> { threshold, relative: trees.relative, left: share, meets, work };
    for start in starts {
        visitor.left = share;
        traversal.start_at(start);
        traversal.enumerate_from_starts(trees, &mut visitor, radius);
    }
}

/// The nodes of a tree that get equal shares of the work.
fn starts<L>(tree: &Tree<Obb, L>) -> Vec<NodeRef> {
    if tree.leaves().len() < LARGE { vec![tree.root()] } else { tree.at_level(SHARED_LEVEL) }
}

/// Work that one subtree may still take.
#[derive(Clone, Copy)]
struct Share {
    steps: usize,
    pairs: usize,
}

/// Visitor that passes on pairs of elements; with `SEPARATE` only those that touch.
pub(super) struct TouchingElements<'w, const SEPARATE: bool> {
    /// Elements farther apart than this (m) are left out.
    threshold: f32,
    /// Pose of the first tree in the second.
    relative: &'w Relative,
    left: Share,
    meets: &'w mut dyn FnMut(u32, u32) -> bool,
    work: &'w mut Work,
}

impl<const SEPARATE: bool> TouchingElements<'_, SEPARATE> {
    /// Passes on element `a` with those elements after `first` of the other leaf that a bit mask selects.
    fn offer(&mut self, a: u32, first: u32, mut near: u64) {
        while near != 0 && self.left.pairs > 0 {
            let b = first + near.trailing_zeros();
            near &= near - 1;
            self.work.primitive_tests += 1;
            self.left.pairs -= usize::from((self.meets)(a, b));
        }
    }

    fn is_used_up(&mut self) -> bool {
        let Some(steps) = self.left.steps.checked_sub(1).filter(|_| self.left.pairs > 0) else { return true };
        self.left.steps = steps;
        false
    }
}

/// The members of [`Visitor`] that do not depend on the kinds of elements.
macro_rules! of_any_elements {
    () => {
        const SEPARATE: bool = SEPARATE;

        fn threshold(&self) -> f32 {
            self.threshold
        }

        fn volume_tests(&mut self, count: u32) {
            self.work.volume_tests += u64::from(count);
        }

        fn interrupted(&mut self) -> bool {
            self.is_used_up()
        }
    };
}

/// The indices of the bits of a mask.
fn bits(mut mask: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros();
        mask &= mask.checked_sub(1)?;
        Some(bit)
    })
}

impl<const SEPARATE: bool> Visitor<TriangleLeaf, TriangleLeaf> for TouchingElements<'_, SEPARATE> {
    of_any_elements!();

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, simd: S, a: &TriangleLeaf, b: &TriangleLeaf) {
        let slack = triangle_slack(self.relative);
        let margin = self.threshold + 4.0 * slack;
        let (moved, lanes) = MovedTriangles::new(simd, a, self.relative, (&b.low, &b.high), margin);
        if lanes == 0 {
            return;
        }
        let eight = LaneTriangles::of_leaf(simd, b);
        for lane in bits(lanes) {
            let one = moved.one(simd, lane as usize);
            let near = if SEPARATE {
                one.may_touch(simd, &eight, slack)
            } else {
                not_beyond(one.coarse_bounds(simd, &eight, &[0.0; 3], slack), self.threshold)
            };
            self.work.screened_pairs += u64::from(b.count);
            self.offer(a.first + lane, b.first, near & b.mask());
        }
    }
}

impl<const SEPARATE: bool> Visitor<SolidLeaf, TriangleLeaf> for TouchingElements<'_, SEPARATE> {
    of_any_elements!();

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, simd: S, solid: &SolidLeaf, leaf: &TriangleLeaf) {
        self.work.screened_pairs += u64::from(leaf.count);
        let lower = lower_bounds_of_triangles(simd, solid, leaf, self.relative, &[0.0; 3]);
        self.offer(solid.index, leaf.first, not_beyond(lower, self.threshold) & leaf.mask());
    }
}

impl<const SEPARATE: bool> Visitor<SolidLeaf, SolidLeaf> for TouchingElements<'_, SEPARATE> {
    of_any_elements!();

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, _: S, a: &SolidLeaf, b: &SolidLeaf) {
        self.offer(a.index, b.index, 1);
    }
}

impl<const SEPARATE: bool> Visitor<SolidLeaf, CubeLeaf> for TouchingElements<'_, SEPARATE> {
    of_any_elements!();

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, simd: S, solid: &SolidLeaf, cubes: &CubeLeaf) {
        self.work.screened_pairs += u64::from(cubes.count);
        let lower = lower_bounds_of_cubes(simd, solid, cubes, &self.relative.inverse());
        self.offer(solid.index, cubes.first, not_beyond(lower, self.threshold) & cubes.mask());
    }
}

impl<const SEPARATE: bool> Visitor<TriangleLeaf, CubeLeaf> for TouchingElements<'_, SEPARATE> {
    of_any_elements!();

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, simd: S, leaf: &TriangleLeaf, cubes: &CubeLeaf) {
        let slack = triangle_slack(self.relative);
        let corners = (&cubes.low, &cubes.high);
        let (moved, lanes) =
            MovedTriangles::new(simd, leaf, self.relative, corners, self.threshold + 4.0 * slack);
        for lane in bits(lanes) {
            self.work.screened_pairs += u64::from(cubes.count);
            let lower = OneTriangle::new(moved.corners(lane as usize)).lower_bounds(
                simd,
                cubes,
                self.threshold,
                slack,
            );
            self.offer(leaf.first + lane, cubes.first, not_beyond(lower, self.threshold) & cubes.mask());
        }
    }
}
