//! Simultaneous traversal of two trees: opens both at every step, nearest pairs first.

use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, f32x8, not_beyond};

use super::tree::{Node, NodeRef, Tree};
use crate::bounding_volume::{BoundingVolume, Relative};

/// Two subtrees, with a lower bound on their distance (m); negative where their volumes overlap.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    pub lower: f32,
    pub a: NodeRef,
    pub b: NodeRef,
}

/// Visitor of the traversal: its search limit, and its action for two leaves.
pub trait Visitor<LA, LB> {
    /// True if only the separation of volumes matters; otherwise their distance is used.
    const SEPARATE: bool;

    /// Subtrees farther apart than this (m) are skipped. Negative infinity ends the search.
    fn threshold(&self) -> f32;

    /// A direction (frame of b's tree, length at most one) in which near elements were found, and along which other volumes are probably
    /// separated, too; zeros if there is none.
    fn direction(&self) -> [f32; 3] {
        [0.0; 3]
    }

    fn volume_tests(&mut self, count: u32);

    fn leaves<S: Simd>(&mut self, simd: S, a: &LA, b: &LB);

    /// True if the search is to stop although subtrees are left.
    fn interrupted(&mut self) -> bool {
        false
    }
}

/// Volumes that the steps of a traversal test: those of the trees themselves, or others.
pub trait StepVolumes<LA, LB>: Copy {
    /// Lower bound (m) on the distance between the first tree and a subtree of the second.
    fn start_bound<S: Simd, V: Visitor<LA, LB>>(self, simd: S, start: NodeRef, visitor: &V) -> f32;

    /// Opens two subtrees that are not both leaves: pushes the near pairs of their children.
    fn open<S: Simd, V: Visitor<LA, LB>>(
        self,
        simd: S,
        entry: Entry,
        stack: &mut Vec<Entry>,
        visitor: &mut V,
    );
}

/// Two trees, the frame of the first placed in the frame of the second.
#[derive(Debug)]
pub struct TreePair<'t, B: BoundingVolume, LA, LB> {
    pub a: &'t Tree<B, LA>,
    pub b: &'t Tree<B, LB>,
    /// Pose of a's frame in b's frame.
    pub relative: &'t Relative,
}

impl<B: BoundingVolume, LA, LB> Clone for TreePair<'_, B, LA, LB> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<B: BoundingVolume, LA, LB> Copy for TreePair<'_, B, LA, LB> {}

/// Passes all relevant pairs of leaves of the first tree and of the subtrees of some nodes of the second tree to the visitor. `volumes` are
/// the trees themselves, or other volumes of the same nodes; `stack` is scratch memory.
///
/// An interrupted traversal leaves the remaining subtrees on the stack.
#[inline(always)]
pub fn traverse<S, B, LA, LB, V>(
    simd: S,
    (trees, volumes): (TreePair<B, LA, LB>, impl StepVolumes<LA, LB>),
    starts: &[NodeRef],
    stack: &mut Vec<Entry>,
    visitor: &mut V,
) where
    S: Simd,
    B: BoundingVolume,
    V: Visitor<LA, LB>,
{
    let TreePair { a, b, .. } = trees;
    stack.clear();
    for &start in starts {
        let lower = volumes.start_bound(simd, start, visitor);
        stack.push(Entry { lower, a: a.root(), b: start });
        visitor.volume_tests(1);
    }
    sort(stack);
    while let Some(&entry) = stack.last() {
        let threshold = visitor.threshold();
        if threshold == f32::NEG_INFINITY {
            stack.clear();
            return;
        }
        if visitor.interrupted() {
            return;
        }
        stack.pop();
        if entry.lower > threshold {
            continue;
        }
        let base = stack.len();
        if entry.a.is_leaf() && entry.b.is_leaf() {
            visitor.leaves(simd, &a.leaf(entry.a).content, &b.leaf(entry.b).content);
        } else {
            volumes.open(simd, entry, stack, visitor);
        }
        if V::SEPARATE {
            nearest_to_top(&mut stack[base..]);
        } else {
            sort(&mut stack[base..]);
        }
    }
}

impl<B: BoundingVolume, LA, LB> StepVolumes<LA, LB> for TreePair<'_, B, LA, LB> {
    #[inline(always)]
    fn start_bound<S: Simd, V: Visitor<LA, LB>>(self, simd: S, start: NodeRef, _: &V) -> f32 {
        start_bound::<S, B, LA, LB, V>(simd, self, start)
    }

    #[inline(always)]
    fn open<S: Simd, V: Visitor<LA, LB>>(
        self,
        simd: S,
        entry: Entry,
        stack: &mut Vec<Entry>,
        visitor: &mut V,
    ) {
        let Self { a, b, relative } = self;
        match (entry.a.is_leaf(), entry.b.is_leaf()) {
            (false, false) => open_both(simd, self, entry, stack, visitor),
            (true, false) => {
                let ((volume, axes), node) = (a.volume(entry.a), b.node(entry.b));
                let relative = &relative.of_nodes(axes, &node.axes);
                let (bounds, near) = open_one::<S, B, LA, LB, V>(simd, volume, node, relative, visitor);
                each_lane(bounds, near, |j, bound| {
                    stack.push(Entry { lower: bound - relative.slack, a: entry.a, b: node.children[j] });
                });
            }
            (false, true) => {
                let ((volume, axes), node) = (b.volume(entry.b), a.node(entry.a));
                let relative = &relative.inverse().of_nodes(axes, &node.axes);
                let (bounds, near) = open_one::<S, B, LA, LB, V>(simd, volume, node, relative, visitor);
                each_lane(bounds, near, |j, bound| {
                    stack.push(Entry { lower: bound - relative.slack, a: node.children[j], b: entry.b });
                });
            }
            (true, true) => {}
        }
    }
}

/// Swaps the nearest to the end; for contact tests the order of the others matters little.
#[inline(always)]
fn nearest_to_top(entries: &mut [Entry]) {
    let Some(last) = entries.len().checked_sub(1) else { return };
    let mut nearest = last;
    for (i, entry) in entries.iter().enumerate() {
        if entry.lower < entries[nearest].lower {
            nearest = i;
        }
    }
    entries.swap(nearest, last);
}

/// Insertion sort, the nearest last: there are few entries.
#[inline(always)]
pub(super) fn sort(entries: &mut [Entry]) {
    for i in 1..entries.len() {
        let entry = entries[i];
        let mut place = i;
        while place > 0 && entries[place - 1].lower < entry.lower {
            entries[place] = entries[place - 1];
            place -= 1;
        }
        entries[place] = entry;
    }
}

/// Lower bound on the distance (m) between the first tree and a subtree of the second.
#[inline(always)]
fn start_bound<S, B, LA, LB, V>(simd: S, trees: TreePair<B, LA, LB>, node: NodeRef) -> f32
where
    S: Simd,
    B: BoundingVolume,
    V: Visitor<LA, LB>,
{
    let TreePair { a, b, relative } = trees;
    let ((volume_a, axes_a), (volume_b, axes_b)) = (a.volume(a.root()), b.volume(node));
    let relative = relative.of_nodes(axes_a, axes_b);
    let seen = B::seen(simd, &volume_a.splat(), &relative);
    let facing = B::facing(simd, &volume_b.splat(), &relative);
    let bounds: [f32; LANES] = bounds::<S, B, LA, LB, V>(simd, &facing, &seen, 0, &relative).into();
    bounds[0] - relative.slack
}

/// Every child of one node against every child of the other.
#[inline(always)]
fn open_both<S, B, LA, LB, V>(
    simd: S,
    trees: TreePair<B, LA, LB>,
    entry: Entry,
    stack: &mut Vec<Entry>,
    visitor: &mut V,
) where
    S: Simd,
    B: BoundingVolume,
    V: Visitor<LA, LB>,
{
    let (node_a, node_b) = (trees.a.node(entry.a), trees.b.node(entry.b));
    let relative = trees.relative.of_nodes(&node_a.axes, &node_b.axes);
    let limit = visitor.threshold() + relative.slack;
    let seen = B::seen(simd, &node_a.pack, &relative);
    let coarse = B::coarse_bounds(simd, &seen, &node_b.volume, &relative);
    let mut lanes = not_beyond(coarse, limit) & mask(node_a.child_count);
    visitor.volume_tests(node_a.child_count + lanes.count_ones() * node_b.child_count);
    if lanes == 0 {
        return;
    }
    let facing = B::facing(simd, &node_b.pack, &relative);
    let along = Along::<S>::new::<B, LA, LB, V>(simd, node_a, node_b, &relative, visitor);
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize;
        lanes &= lanes - 1;
        let bounds = along.and(lane, bounds::<S, B, LA, LB, V>(simd, &facing, &seen, lane, &relative));
        let near = not_beyond(bounds, limit) & mask(node_b.child_count);
        each_lane(bounds, near, |j, bound| {
            let lower = bound - relative.slack;
            stack.push(Entry { lower, a: node_a.children[lane], b: node_b.children[j] });
        });
    }
}

/// The volume of a leaf against every child of a node, in whose frame `relative` places the leaf's frame. Returns lower bounds (m) on the
/// distances, from which the slack is not yet subtracted, and the mask of the children that are near.
#[inline(always)]
fn open_one<S, B, LA, LB, V>(
    simd: S,
    volume: &B,
    node: &Node<B>,
    relative: &Relative,
    visitor: &mut V,
) -> (f32x8<S>, u64)
where
    S: Simd,
    B: BoundingVolume,
    V: Visitor<LA, LB>,
{
    let limit = visitor.threshold() + relative.slack;
    visitor.volume_tests(node.child_count);
    let seen = B::seen(simd, &volume.splat(), relative);
    let facing = B::facing(simd, &node.pack, relative);
    let bounds = bounds::<S, B, LA, LB, V>(simd, &facing, &seen, 0, relative);
    (bounds, not_beyond(bounds, limit) & mask(node.child_count))
}

/// Ranges of the volumes along the visitor's direction.
#[derive(Clone, Copy)]
struct Along<S: Simd> {
    /// None while there is no direction.
    of_a: Option<[[f32; LANES]; 2]>,
    of_b: [f32x8<S>; 2],
    simd: S,
}

impl<S: Simd> Along<S> {
    #[inline(always)]
    fn new<B: BoundingVolume, LA, LB, V: Visitor<LA, LB>>(
        simd: S,
        a: &Node<B>,
        b: &Node<B>,
        relative: &Relative,
        visitor: &V,
    ) -> Self {
        let zero = f32x8::splat(simd, 0.0);
        let direction = if V::SEPARATE { [0.0; 3] } else { visitor.direction() };
        if direction == [0.0; 3] {
            return Self { of_a: None, of_b: [zero; 2], simd };
        }
        let in_b = b.axes.turned(&direction);
        let offset = relative.offset_along(&in_b);
        let [low, high] = B::extents(simd, &a.pack, &relative.along_a(&in_b));
        Self {
            of_a: Some([(low + offset).into(), (high + offset).into()]),
            of_b: B::extents(simd, &b.pack, &in_b),
            simd,
        }
    }

    /// Lower bounds for a volume of a against eight of b, or their gaps along the direction where these are larger.
    #[inline(always)]
    fn and(&self, lane: usize, bounds: f32x8<S>) -> f32x8<S> {
        let Some([low, high]) = &self.of_a else { return bounds };
        let [low_b, high_b] = self.of_b;
        bounds.max(low_b - high[lane & 7]).max(f32x8::splat(self.simd, low[lane & 7]) - high_b)
    }
}

#[inline(always)]
fn bounds<S: Simd, B: BoundingVolume, LA, LB, V: Visitor<LA, LB>>(
    simd: S,
    facing: &B::Facing<S>,
    seen: &B::Seen,
    lane: usize,
    relative: &Relative,
) -> f32x8<S> {
    if V::SEPARATE {
        B::bounds::<S, true>(simd, facing, seen, lane, relative)
    } else {
        B::bounds::<S, false>(simd, facing, seen, lane, relative)
    }
}

#[inline(always)]
fn each_lane<S: Simd>(numbers: f32x8<S>, mut mask: u64, mut f: impl FnMut(usize, f32)) {
    if mask == 0 {
        return;
    }
    let numbers: [f32; LANES] = numbers.into();
    while mask != 0 {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        f(lane, numbers[lane & 7]);
    }
}

#[inline(always)]
fn mask(count: u32) -> u64 {
    (1 << count) - 1
}
