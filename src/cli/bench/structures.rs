//! Trait of the broad phase structures that `clearance bench` compares, and its implementation by the library's tree.

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

/// Box of each item that is in a set, by the number of the item.
#[derive(Default)]
pub struct ItemBoxes(Vec<Option<AxisBox>>);

impl ItemBoxes {
    /// Largest number of an item, plus one.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn insert(&mut self, item: u32, bounds: &AxisBox) {
        if self.0.len() <= item as usize {
            self.0.resize(item as usize + 1, None);
        }
        self.0[item as usize] = Some(*bounds);
    }

    /// Removes an item; its box, if it was in the set.
    pub fn take(&mut self, item: u32) -> Option<AxisBox> {
        self.0.get_mut(item as usize).and_then(Option::take)
    }

    pub fn get(&self, item: u32) -> Option<AxisBox> {
        self.0.get(item as usize).copied().flatten()
    }

    /// Whether the box of an item has a common point with another one.
    pub fn overlaps(&self, item: u32, with: &AxisBox) -> bool {
        self.get(item).is_some_and(|bounds| overlap(&bounds, with))
    }

    /// The items of the set.
    pub fn items(&self) -> impl Iterator<Item = u32> {
        (0..).zip(&self.0).filter_map(|(item, bounds)| bounds.map(|_| item))
    }
}

/// Whether two boxes have a common point.
pub fn overlap(a: &AxisBox, b: &AxisBox) -> bool {
    (0..3).all(|i| a.lo[i] <= b.hi[i] && b.lo[i] <= a.hi[i])
}
