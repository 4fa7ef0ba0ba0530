//! Type `Tree`, a bounding volume hierarchy: its nodes, its leaves, and the trait of leaf contents.

use clearance_geometry::VolumeKind;
use clearance_geometry::math::{MatrixPose, Point, RotationMatrix};
use clearance_geometry::simd::LANES;

use super::volume_trees::{OtherVolumes, TreeForm};
use crate::bounding_volume::{AnchoredReach, Axes, BoundingVolume, Obb, Relative};

/// A tree of volumes `B` over leaves that hold `L`.
#[derive(Clone, Debug)]
pub struct Tree<B: BoundingVolume, L> {
    /// The origin of all frames of the tree, in the frame of the body.
    anchor: Point,
    /// Largest distance (m, 1-norm) of anything in the tree from the anchor.
    reach: f64,
    root: NodeRef,
    nodes: Vec<Node<B>>,
    leaves: Vec<Leaf<B, L>>,
    other_volumes: OtherVolumes,
}

/// Content of leaves: a few items that are tested together.
pub trait Content: Sized {
    /// Items that a tree is built over.
    type Item;

    /// Maximum number of items in a leaf.
    const CAPACITY: usize;

    /// Appends points whose convex hull contains the item.
    fn corners(item: &Self::Item, corners: &mut Vec<Point>);

    /// Axes, as columns, of a suitable frame for a leaf with these items; `None` to let the type of volume choose.
    fn axes(items: &[&Self::Item]) -> Option<RotationMatrix>;

    /// A leaf with some items of a tree with this anchor; `first` is the first item's index in the order of the tree, and the others
    /// follow.
    fn new(anchor: &Point, first: u32, items: &[&Self::Item]) -> Self;
}

/// A node with up to eight children.
#[derive(Clone, Debug)]
pub struct Node<B: BoundingVolume> {
    pub axes: Axes,
    /// Volume around all children, in this node's frame.
    pub volume: B,
    /// Volume around each child, in this node's frame.
    pub pack: B::Pack,
    pub children: [NodeRef; LANES],
    pub child_count: u32,
}

/// The items of the leaf.
#[derive(Clone, Debug)]
pub struct Leaf<B, L> {
    pub axes: Axes,
    /// Volume around the content, in this leaf's frame.
    pub volume: B,
    pub content: L,
}

/// The index of a node or of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NodeRef(u32);

impl NodeRef {
    const LEAF: u32 = 1 << 31;

    #[inline]
    pub(super) fn node(index: usize) -> Self {
        Self(u32::try_from(index).expect("node count fits 31 bits"))
    }

    #[inline]
    pub(super) fn leaf(index: usize) -> Self {
        Self(u32::try_from(index).expect("leaf count fits 31 bits") | Self::LEAF)
    }

    /// True if it refers to a leaf.
    #[must_use]
    #[inline]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    #[inline]
    pub(super) fn index(self) -> usize {
        (self.0 & !Self::LEAF) as usize
    }
}

impl<B: BoundingVolume, L> Tree<B, L> {
    #[inline]
    pub(super) fn new(
        anchor: Point,
        reach: f64,
        root: NodeRef,
        nodes: Vec<Node<B>>,
        leaves: Vec<Leaf<B, L>>,
    ) -> Self {
        Self { anchor, reach, root, nodes, leaves, other_volumes: OtherVolumes::default() }
    }

    #[must_use]
    #[inline]
    pub fn anchor(&self) -> &Point {
        &self.anchor
    }

    #[must_use]
    #[inline]
    pub fn reach(&self) -> f64 {
        self.reach
    }

    #[must_use]
    #[inline]
    pub fn root(&self) -> NodeRef {
        self.root
    }

    /// # Panics
    /// If it is a leaf.
    #[inline(always)]
    #[must_use]
    pub fn node(&self, node: NodeRef) -> &Node<B> {
        &self.nodes[node.0 as usize]
    }

    /// # Panics
    /// If it is not a leaf.
    #[inline(always)]
    #[must_use]
    pub fn leaf(&self, leaf: NodeRef) -> &Leaf<B, L> {
        &self.leaves[leaf.index()]
    }

    #[inline]
    pub(super) fn nodes(&self) -> &[Node<B>] {
        &self.nodes
    }

    /// Volumes of other kinds around the same nodes.
    #[inline]
    pub fn other_volumes(&self) -> &OtherVolumes {
        &self.other_volumes
    }

    #[must_use]
    #[inline]
    pub fn leaves(&self) -> &[Leaf<B, L>] {
        &self.leaves
    }

    /// The nodes at a given depth below the root, and the leaves nearer to the root: together they contain the whole tree.
    #[must_use]
    #[inline]
    pub fn at_level(&self, level: usize) -> Vec<NodeRef> {
        let below = |of: NodeRef| {
            if of.is_leaf() {
                return vec![of];
            }
            let node = self.node(of);
            node.children[..node.child_count as usize].to_vec()
        };
        let mut found = vec![self.root];
        for _ in 0..level {
            if found.iter().all(|of| of.is_leaf()) {
                break;
            }
            found = found.into_iter().flat_map(below).collect();
        }
        found
    }

    /// The volume around a subtree, and its frame.
    #[inline(always)]
    #[must_use]
    pub fn volume(&self, of: NodeRef) -> (&B, &Axes) {
        if of.is_leaf() {
            let leaf = self.leaf(of);
            (&leaf.volume, &leaf.axes)
        } else {
            let node = self.node(of);
            (&node.volume, &node.axes)
        }
    }

    /// The frame of this tree in the frame of another, which belongs to body b.
    #[must_use]
    #[inline]
    pub fn relative<M>(&self, other: &Tree<B, M>, pose_ab: &MatrixPose) -> Relative {
        let a = AnchoredReach { anchor: &self.anchor, reach: self.reach };
        let b = AnchoredReach { anchor: &other.anchor, reach: other.reach };
        Relative::of_trees(pose_ab, a, b)
    }

    /// Memory of nodes and leaves, in bytes.
    #[must_use]
    #[inline]
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node<B>>()
            + self.leaves.capacity() * size_of::<Leaf<B, L>>()
            + self.other_volumes.bytes()
    }
}

impl<L> Tree<Obb, L> {
    /// Adds volumes of another kind, with which the tree is then searched, and of those of `kinds` that it can meet. `points_of` appends points
    /// whose convex hull contains the items of a leaf, in the frame of the body.
    pub fn set_volumes(
        &mut self,
        kind: VolumeKind,
        kinds: &[VolumeKind],
        points_of: impl Fn(&Leaf<Obb, L>, &mut Vec<Point>),
    ) {
        self.other_volumes = OtherVolumes::new(kind, kinds, &TreeForm::new(self, points_of));
    }
}
