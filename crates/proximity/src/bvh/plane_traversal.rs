//! Traversal of a tree against a plane: every volume has a range along the plane's normal.

use clearance_geometry::constants::{PLACEMENT_SLACK, VOLUME_SLACK};
use clearance_geometry::math::Vector;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, not_beyond};

use super::traversal::{Entry, sort};
use super::tree::{NodeRef, Tree};
use crate::bounding_volume::BoundingVolume;

/// All p with `normal · p = offset`, in the frame of a tree.
#[derive(Clone, Copy, Debug)]
pub struct TreePlane {
    normal: [f32; 3],
    offset: f32,
    /// Amount (m) by which rounding can increase the computed distance, derived as for
    /// [`Relative::of_trees`](crate::bounding_volume::Relative::of_trees).
    slack: f32,
}

impl TreePlane {
    /// A plane of the body's frame, whose normal has length one.
    #[allow(clippy::cast_possible_truncation)] // granted by the slack
    #[must_use]
    #[inline]
    pub fn new<B: BoundingVolume, L>(normal: &Vector, offset: f64, tree: &Tree<B, L>) -> Self {
        let anchor = tree.anchor().coords;
        let from_anchor = offset - normal.dot(&anchor);
        let reach = tree.reach() + from_anchor.abs();
        let entered = anchor.abs().sum() + offset.abs();
        Self {
            normal: [normal.x as f32, normal.y as f32, normal.z as f32],
            offset: from_anchor as f32,
            slack: ((VOLUME_SLACK * reach + PLACEMENT_SLACK * entered) as f32).next_up(),
        }
    }
}

/// Visitor of a tree and a plane.
pub trait PlaneVisitor<L> {
    /// Subtrees farther from the plane than this (m) are skipped. Negative infinity ends the search.
    fn threshold(&self) -> f32;

    fn volume_tests(&mut self, count: u32);

    fn leaf(&mut self, leaf: &L);

    /// True if the search is to stop although subtrees are left.
    fn interrupted(&mut self) -> bool;
}

/// Passes all relevant leaves to the visitor, the nearer first. An interrupted search leaves the remaining subtrees on the stack, as a.
#[inline(always)]
pub fn traverse_to_plane<S: Simd, B: BoundingVolume, L, V: PlaneVisitor<L>>(
    simd: S,
    tree: &Tree<B, L>,
    plane: &TreePlane,
    stack: &mut Vec<Entry>,
    visitor: &mut V,
) {
    let entry = |lower: f32, a: NodeRef| Entry { lower, a, b: a };
    stack.clear();
    stack.push(entry(f32::NEG_INFINITY, tree.root()));
    while let Some(&Entry { lower, a, .. }) = stack.last() {
        let threshold = visitor.threshold();
        if threshold == f32::NEG_INFINITY {
            stack.clear();
            return;
        }
        if visitor.interrupted() {
            return;
        }
        stack.pop();
        if lower > threshold {
            continue;
        }
        if a.is_leaf() {
            visitor.leaf(&tree.leaf(a).content);
            continue;
        }
        let node = tree.node(a);
        visitor.volume_tests(node.child_count);
        let [low, high] = B::extents(simd, &node.pack, &node.axes.turned(&plane.normal));
        let bounds = (low - plane.offset).max(high * -1.0 + plane.offset) - plane.slack;
        let mut near = not_beyond(bounds, threshold) & ((1 << node.child_count) - 1);
        let bounds: [f32; LANES] = bounds.into();
        let base = stack.len();
        while near != 0 {
            let lane = near.trailing_zeros() as usize;
            near &= near - 1;
            stack.push(entry(bounds[lane & 7], node.children[lane & 7]));
        }
        sort(&mut stack[base..]);
    }
}
