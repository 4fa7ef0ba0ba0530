//! Traversal of trees with its scratch memory.

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::{Level, dispatch};

use crate::bounding_volume::BoundingVolume;
use crate::bvh::{
    Entry, NodeRef, PlaneVisitor, Tree, TreePair, TreePlane, Visitor, traverse, traverse_to_plane,
};

/// Traverses trees at the SIMD level of the caller, and keeps a lower bound on everything that interrupted traversals left.
#[derive(Clone, Debug)]
pub(crate) struct TreeTraversal {
    level: Level,
    stack: Vec<Entry>,
    /// Start nodes in the second tree.
    starts: Vec<NodeRef>,
    unseen: f64,
}

impl TreeTraversal {
    #[inline]
    pub fn new(level: Level) -> Self {
        Self { level, stack: Vec::new(), starts: Vec::new(), unseen: f64::INFINITY }
    }

    #[inline]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Begins a search: nothing is left out yet.
    #[inline]
    pub fn begin(&mut self) {
        self.unseen = f64::INFINITY;
    }

    /// Lower bound (m) on the distances of everything not searched; infinite if everything was searched.
    #[inline]
    pub fn unseen(&self) -> f64 {
        self.unseen
    }

    /// Notes that nothing is proven about the rest of the bodies.
    #[inline]
    pub fn leave_all(&mut self) {
        self.unseen = 0.0;
    }

    /// Start nodes in the second tree of the next traversals.
    #[inline]
    pub fn starts(&mut self) -> &mut Vec<NodeRef> {
        &mut self.starts
    }

    /// Starts the next traversals at one node of the second tree.
    #[inline]
    pub fn start_at(&mut self, node: NodeRef) {
        self.starts.clear();
        self.starts.push(node);
    }

    /// Passes the near leaves of both trees to a visitor.
    pub fn run<B: BoundingVolume, LA, LB, V: Visitor<LA, LB>>(
        &mut self,
        trees: TreePair<B, LA, LB>,
        visitor: &mut V,
    ) {
        self.start_at(trees.b.root());
        self.run_from_starts(trees, visitor, 0.0);
    }

    /// As [`Self::run`], but in the second tree from its start nodes. Balls around the trees' elements reduce distances by `radius` (m).
    pub fn run_from_starts<B: BoundingVolume, LA, LB, V: Visitor<LA, LB>>(
        &mut self,
        trees: TreePair<B, LA, LB>,
        visitor: &mut V,
        radius: f64,
    ) {
        if visitor.threshold() == f32::NEG_INFINITY || self.starts.is_empty() {
            return;
        }
        let (stack, starts) = (&mut self.stack, &*self.starts);
        dispatch!(self.level, simd => traverse(simd, trees, starts, stack, visitor));
        self.note_unseen(radius);
    }

    /// Passes the leaves of a tree that may be near a plane to a visitor.
    #[inline]
    pub fn run_to_plane<B: BoundingVolume, L, V: PlaneVisitor<L>>(
        &mut self,
        tree: &Tree<B, L>,
        plane: &TreePlane,
        visitor: &mut V,
        radius: f64,
    ) {
        if visitor.threshold() == f32::NEG_INFINITY {
            return;
        }
        let stack = &mut self.stack;
        dispatch!(self.level, simd => traverse_to_plane(simd, tree, plane, stack, visitor));
        self.note_unseen(radius);
    }

    /// Lower bound on what an interrupted traversal left: the distance of the volumes, minus the balls around their elements.
    fn note_unseen(&mut self, radius: f64) {
        for left in &self.stack {
            self.unseen = self.unseen.lesser((f64::from(left.lower) - radius).greater(0.0));
        }
    }
}
