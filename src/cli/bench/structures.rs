//! Broad phase structures: find the boxes that overlap a given box. The library's tree, and alternatives.

use clearance::geometry::simd::Level;
use clearance::proximity::bvh::{AxisBox, DynamicTree};

/// Set of numbered boxes that can be inserted, moved and removed.
pub trait BroadPhase {
    const NAME: &'static str;

    fn build(items: &[(u32, AxisBox)]) -> Self;

    /// Inserts an item, or changes its box.
    fn set(&mut self, item: u32, bounds: &AxisBox);

    fn remove(&mut self, item: u32);

    /// Appends each item whose box overlaps `with` to `found`, once. `query` is the number of the robot part: its next box is often near
    /// this one.
    fn overlapping(&mut self, query: u32, with: &AxisBox, found: &mut Vec<u32>);
}

/// The tree that all checks use.
pub struct Tree {
    boxes: DynamicTree,
    level: Level,
    stack: Vec<u32>,
}

impl BroadPhase for Tree {
    const NAME: &'static str = "tree";

    fn build(items: &[(u32, AxisBox)]) -> Self {
        Self { boxes: DynamicTree::build(items), level: Level::new(), stack: Vec::new() }
    }

    fn set(&mut self, item: u32, bounds: &AxisBox) {
        self.boxes.set(item, *bounds);
    }

    fn remove(&mut self, item: u32) {
        self.boxes.remove(item);
    }

    fn overlapping(&mut self, _: u32, with: &AxisBox, found: &mut Vec<u32>) {
        self.boxes.overlapping(self.level, with, &mut self.stack, found);
    }
}

/// Whether two boxes have a common point.
pub fn overlap(a: &AxisBox, b: &AxisBox) -> bool {
    (0..3).all(|i| a.lo[i] <= b.hi[i] && b.lo[i] <= a.hi[i])
}
