//! Pair of elements in the front, with a lower bound on their distance.

use crate::elements::ElementPair;

/// Maximum number of pairs; more would cost as much as a search.
pub(super) const MOST: usize = 512;

/// Two elements, and a lower bound (m) on their distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ListedPair {
    pub lower: f32,
    pub elements: ElementPair,
}

impl ListedPair {
    pub fn by_distance(x: &Self, y: &Self) -> std::cmp::Ordering {
        x.lower.total_cmp(&y.lower).then(x.elements.cmp(&y.elements))
    }
}
