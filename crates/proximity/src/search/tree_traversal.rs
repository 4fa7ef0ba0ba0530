//! Traversal of trees with its scratch memory and start nodes, and a bound on what interruptions leave out.

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::{Level, dispatch};

use crate::bounding_volume::Obb;
use crate::bvh::{
    Entry, NodeRef, PlaneVisitor, Tree, TreePair, TreePlane, Visitor, VolumeTreePair, traverse,
    traverse_to_plane,
};

/// Traverses trees at the SIMD level of the caller, and keeps a lower bound on everything that interrupted traversals left.
#[derive(Clone, Debug)]
pub(crate) struct TreeTraversal {
    level: Level,
    stack: Vec<Entry>,
    /// Start nodes in the second tree.
    starts: Vec<NodeRef>,
    unseen: f64,
    /// True while trees are searched with their boxes, whatever other volumes they have.
    boxes_only: bool,
    /// True if trees were searched with other volumes.
    uses_other_volumes: bool,
}

impl TreeTraversal {
    #[inline]
    pub fn new(level: Level) -> Self {
        Self {
            level,
            stack: Vec::new(),
            starts: Vec::new(),
            unseen: f64::INFINITY,
            boxes_only: false,
            uses_other_volumes: false,
        }
    }

    #[inline]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Begins a search: nothing is left out yet.
    #[inline]
    pub fn begin(&mut self) {
        self.unseen = f64::INFINITY;
        self.uses_other_volumes = false;
    }

    /// Whether the next searches use only the boxes of the trees, whatever other volumes they have.
    #[inline]
    pub fn set_boxes_only(&mut self, boxes_only: bool) {
        self.boxes_only = boxes_only;
    }

    /// True if this search has used other volumes than the boxes of the trees.
    #[inline]
    pub fn uses_other_volumes(&self) -> bool {
        self.uses_other_volumes
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
    pub fn run<LA, LB, V: Visitor<LA, LB>>(&mut self, trees: TreePair<Obb, LA, LB>, visitor: &mut V) {
        self.start_at(trees.b.root());
        self.run_from_starts(trees, visitor, 0.0);
    }

    /// As [`Self::run`], but in the second tree from its start nodes. Balls around the trees' elements reduce distances by `radius` (m).
    pub fn run_from_starts<LA, LB, V: Visitor<LA, LB>>(
        &mut self,
        trees: TreePair<Obb, LA, LB>,
        visitor: &mut V,
        radius: f64,
    ) {
        if visitor.threshold() == f32::NEG_INFINITY || self.starts.is_empty() {
            return;
        }
        let volumes = if self.boxes_only { None } else { VolumeTreePair::new(trees, self.level) };
        let (stack, starts) = (&mut self.stack, &*self.starts);
        if let Some(volumes) = volumes {
            self.uses_other_volumes = true;
            dispatch!(self.level, simd => traverse(simd, (trees, volumes), starts, stack, visitor));
        } else {
            dispatch!(self.level, simd => traverse(simd, (trees, trees), starts, stack, visitor));
        }
        self.note_unseen(radius);
    }

    /// As [`Self::run_from_starts`], but always with boxes and at the baseline of SIMD: for visitors that spend more time on a pair of
    /// elements than its discovery takes.
    pub fn enumerate_from_starts<LA, LB, V: Visitor<LA, LB>>(
        &mut self,
        trees: TreePair<Obb, LA, LB>,
        visitor: &mut V,
        radius: f64,
    ) {
        if visitor.threshold() == f32::NEG_INFINITY || self.starts.is_empty() {
            return;
        }
        let (stack, starts) = (&mut self.stack, &*self.starts);
        dispatch!(baseline, simd => traverse(simd, (trees, trees), starts, stack, visitor));
        self.note_unseen(radius);
    }

    /// Passes the leaves of a tree that may be near a plane to a visitor.
    #[inline]
    pub fn run_to_plane<L, V: PlaneVisitor<L>>(
        &mut self,
        tree: &Tree<Obb, L>,
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
