//! Trees of other kinds of volumes around the nodes of a tree of boxes (decision 41).
//!
//! The topology of a tree does not depend on its volumes, so a node has the same number in all of them. A tree of another kind has volumes
//! only: items stay in the tree of boxes. One step of the traversal is one call through [`VolumeTree`], so that the searches are compiled
//! once for all other kinds, not once for each.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use clearance_geometry::VolumeKind;
use clearance_geometry::math::{Point, RotationMatrix, Vector};
use clearance_geometry::simd::{LANES, Level, Simd, dispatch};

use super::traversal::{Entry, StepVolumes, TreePair, Visitor};
use super::tree::{Leaf, Node, NodeRef, Tree};
use crate::bounding_volume::{
    Aabb, Axes, BoundingVolume, Capsule, Kdop18, Kios, Obb, Outline, Relative, Rss, Sphere,
};

/// Builds the volumes of a kind around the nodes of a tree; boxes that fit most closely are in the tree itself.
fn volume_tree(kind: VolumeKind, form: &TreeForm) -> Arc<dyn VolumeTree> {
    match kind {
        VolumeKind::Obb => Arc::new(form.with_volumes::<Obb>()),
        VolumeKind::Rss => Arc::new(form.with_volumes::<Rss>()),
        VolumeKind::Lss => Arc::new(form.with_volumes::<Capsule>()),
        VolumeKind::Pss => Arc::new(form.with_volumes::<Sphere>()),
        VolumeKind::Aabb => Arc::new(form.with_volumes::<Aabb>()),
        VolumeKind::Kdop18 => Arc::new(form.with_volumes::<Kdop18>()),
        VolumeKind::Kios => Arc::new(form.with_volumes::<Kios>()),
    }
}

/// Volumes of one kind around the nodes of a tree.
pub trait VolumeTree: Any + Debug + Send + Sync {
    /// Itself, to be compared with a tree of the same kind.
    fn as_any(&self) -> &dyn Any;

    /// Lower bound (m) on the distance between this tree and a subtree of the other one, which is of the same kind.
    fn start_bound(&self, other: &dyn VolumeTree, start: NodeRef, step: &Step) -> f32;

    /// Opens two subtrees, one of each tree: pushes the near pairs of their children, and returns the number of volume tests.
    fn open(&self, other: &dyn VolumeTree, entry: Entry, step: &Step, stack: &mut Vec<Entry>) -> u32;

    /// Shape of the volume around a subtree, in a frame with the origin of the tree and these axes as columns.
    fn outline(&self, of: NodeRef) -> (Outline, RotationMatrix);

    /// Memory in bytes.
    fn bytes(&self) -> usize;
}

/// Input of one step of a traversal.
#[derive(Clone, Copy, Debug)]
pub struct Step<'t> {
    level: Level,
    /// Pose of the first tree's frame in that of the second.
    relative: &'t Relative,
    is_separation: bool,
    threshold: f32,
    direction: [f32; 3],
}

/// Kind of volume that a tree is searched with, and its volumes of other kinds.
#[derive(Clone, Debug, Default)]
pub struct OtherVolumes {
    kind: VolumeKind,
    trees: Vec<(VolumeKind, Arc<dyn VolumeTree>)>,
}

impl OtherVolumes {
    /// Volumes of a kind, and of those other kinds with which this one can meet: of two different kinds, pairs use the greater.
    pub(super) fn new(kind: VolumeKind, kinds: &[VolumeKind], form: &TreeForm) -> Self {
        let needed = VolumeKind::ALL
            .into_iter()
            .filter(|of| *of != VolumeKind::Obb && *of >= kind && (*of == kind || kinds.contains(of)));
        Self { kind, trees: needed.map(|of| (of, volume_tree(of, form))).collect() }
    }

    /// The volumes of the tree's own kind; `None` for oriented boxes.
    #[inline]
    pub fn own(&self) -> Option<&dyn VolumeTree> {
        self.of_kind(self.kind)
    }

    fn of_kind(&self, kind: VolumeKind) -> Option<&dyn VolumeTree> {
        self.trees.iter().find(|(of, _)| *of == kind).map(|(_, tree)| &**tree)
    }

    /// Memory in bytes.
    #[inline]
    pub fn bytes(&self) -> usize {
        self.trees.iter().map(|(_, tree)| tree.bytes()).sum()
    }
}

/// The other volumes of two trees, of one kind.
#[derive(Clone, Copy, Debug)]
pub struct VolumeTreePair<'t> {
    a: &'t dyn VolumeTree,
    b: &'t dyn VolumeTree,
    relative: &'t Relative,
    level: Level,
}

impl<'t> VolumeTreePair<'t> {
    /// `None` if the trees are searched with their own boxes: both are of this kind, or one has no volumes of the greater kind.
    #[inline]
    pub fn new<B: BoundingVolume, LA, LB>(trees: TreePair<'t, B, LA, LB>, level: Level) -> Option<Self> {
        let (a, b) = (trees.a.other_volumes(), trees.b.other_volumes());
        let kind = if a.kind > b.kind { a.kind } else { b.kind };
        if kind == VolumeKind::Obb {
            return None;
        }
        Some(Self { a: a.of_kind(kind)?, b: b.of_kind(kind)?, relative: trees.relative, level })
    }

    #[inline(always)]
    fn step<LA, LB, V: Visitor<LA, LB>>(&self, visitor: &V) -> Step<'t> {
        Step {
            level: self.level,
            relative: self.relative,
            is_separation: V::SEPARATE,
            threshold: visitor.threshold(),
            direction: if V::SEPARATE { [0.0; 3] } else { visitor.direction() },
        }
    }
}

impl<LA, LB> StepVolumes<LA, LB> for VolumeTreePair<'_> {
    #[inline(always)]
    fn start_bound<S: Simd, V: Visitor<LA, LB>>(self, _: S, start: NodeRef, visitor: &V) -> f32 {
        self.a.start_bound(self.b, start, &self.step(visitor))
    }

    #[inline(always)]
    fn open<S: Simd, V: Visitor<LA, LB>>(self, _: S, entry: Entry, stack: &mut Vec<Entry>, visitor: &mut V) {
        let tests = self.a.open(self.b, entry, &self.step(visitor), stack);
        visitor.volume_tests(tests);
    }
}

impl<B: BoundingVolume> VolumeTree for Tree<B, ()> {
    fn as_any(&self) -> &dyn Any {
        self
    }

    fn start_bound(&self, other: &dyn VolumeTree, start: NodeRef, step: &Step) -> f32 {
        let trees = TreePair { a: self, b: same_kind(self, other), relative: step.relative };
        let visitor = OneStep::<false> { step, tests: 0 };
        dispatch!(step.level, simd => trees.start_bound(simd, start, &visitor))
    }

    fn open(&self, other: &dyn VolumeTree, entry: Entry, step: &Step, stack: &mut Vec<Entry>) -> u32 {
        let trees = TreePair { a: self, b: same_kind(self, other), relative: step.relative };
        if step.is_separation {
            let mut visitor = OneStep::<true> { step, tests: 0 };
            dispatch!(step.level, simd => trees.open(simd, entry, stack, &mut visitor));
            return visitor.tests;
        }
        let mut visitor = OneStep::<false> { step, tests: 0 };
        dispatch!(step.level, simd => trees.open(simd, entry, stack, &mut visitor));
        visitor.tests
    }

    fn outline(&self, of: NodeRef) -> (Outline, RotationMatrix) {
        let (volume, axes) = self.volume(of);
        (volume.outline(), axes.columns())
    }

    fn bytes(&self) -> usize {
        Tree::bytes(self)
    }
}

/// The other tree, which a pair of trees has for the same kind and therefore with the same type.
#[inline(always)]
fn same_kind<'o, B: BoundingVolume>(_: &Tree<B, ()>, other: &'o dyn VolumeTree) -> &'o Tree<B, ()> {
    other.as_any().downcast_ref().expect("both trees of a pair have volumes of one kind")
}

/// Visitor of one step: its limit, and the number of tests.
struct OneStep<'s, const SEPARATE: bool> {
    step: &'s Step<'s>,
    tests: u32,
}

impl<const SEPARATE: bool> Visitor<(), ()> for OneStep<'_, SEPARATE> {
    const SEPARATE: bool = SEPARATE;

    #[inline(always)]
    fn threshold(&self) -> f32 {
        self.step.threshold
    }

    #[inline(always)]
    fn direction(&self) -> [f32; 3] {
        self.step.direction
    }

    #[inline(always)]
    fn volume_tests(&mut self, count: u32) {
        self.tests += count;
    }

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, _: S, (): &(), (): &()) {}
}

/// Topology of a tree, and points around its items.
pub(super) struct TreeForm {
    anchor: Point,
    reach: f64,
    root: NodeRef,
    nodes: Vec<([NodeRef; LANES], u32)>,
    /// Points of all leaves in turn, from the anchor.
    points: Vec<Vector>,
    /// End of each leaf's points, after a zero.
    ends: Vec<usize>,
}

impl TreeForm {
    /// The form of a tree; `points_of` appends points (frame of the body) whose convex hull contains the items of a leaf.
    pub fn new<L>(tree: &Tree<Obb, L>, points_of: impl Fn(&Leaf<Obb, L>, &mut Vec<Point>)) -> Self {
        let (mut points, mut ends, anchor) = (Vec::new(), vec![0], *tree.anchor());
        for leaf in tree.leaves() {
            points_of(leaf, &mut points);
            ends.push(points.len());
        }
        Self {
            anchor,
            reach: tree.reach(),
            root: tree.root(),
            nodes: tree.nodes().iter().map(|node| (node.children, node.child_count)).collect(),
            points: points.iter().map(|p| p - anchor).collect(),
            ends,
        }
    }

    fn with_volumes<B: BoundingVolume>(&self) -> Tree<B, ()> {
        let nodes = (0..self.nodes.len()).map(|index| self.node(NodeRef::node(index))).collect();
        let leaves = (0..self.ends.len() - 1).map(|index| {
            let points = self.points_of(NodeRef::leaf(index));
            let axes = Axes::from_columns(&B::axes(points));
            Leaf { axes, volume: fitted(points, &axes), content: () }
        });
        Tree::new(self.anchor, self.reach, self.root, nodes, leaves.collect())
    }

    fn node<B: BoundingVolume>(&self, of: NodeRef) -> Node<B> {
        let (children, child_count) = self.nodes[of.index()];
        let points = self.points_of(of);
        let axes = Axes::from_columns(&B::axes(points));
        let of_child = |child: &NodeRef| fitted(self.points_of(*child), &axes);
        let volumes: Vec<B> = children[..child_count as usize].iter().map(of_child).collect();
        Node { axes, volume: fitted(points, &axes), pack: B::pack(&volumes), children, child_count }
    }

    /// Points of a subtree: leaves are in the order of the tree.
    fn points_of(&self, of: NodeRef) -> &[Vector] {
        let (mut first, mut last) = (of, of);
        while !first.is_leaf() {
            first = self.nodes[first.index()].0[0];
        }
        while !last.is_leaf() {
            let (children, count) = self.nodes[last.index()];
            last = children[count as usize - 1];
        }
        &self.points[self.ends[first.index()]..self.ends[last.index() + 1]]
    }
}

fn fitted<B: BoundingVolume>(points: &[Vector], axes: &Axes) -> B {
    B::fit(&points.iter().map(|p| axes.along(p)).collect::<Vec<_>>())
}
