//! Priority queue of the search for the nearest pair.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::LANES;
use clearance_proximity::bvh::Child;

use crate::capsules::round_up;
use crate::world::SearchNode;

/// A node of the search with its bound; the nearest are searched first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueuedNode {
    /// Lower bound (m) on its distances.
    pub lower: f64,
    pub node: SearchNode,
}

/// Priority queue by lower bound of the distance; equal ones are in order of insertion.
///
/// The key is one word: a lower bound on the distance (m, not negative, f32) and an index. Candidates inserted together
/// are queued under the smallest of their bounds: most of the others are never taken out.
#[derive(Clone, Debug, Default)]
pub struct NearestFirstQueue {
    order: BinaryHeap<Reverse<u64>>,
    all: Vec<Queued>,
    opened: Vec<Opened>,
}

#[derive(Clone, Copy, Debug)]
enum Queued {
    One(SearchNode),
    /// By index.
    Opened(usize),
}

/// The children of a node of the tree of pieces, with lower bounds (m) on their distances from a part; infinite once
/// taken out.
#[derive(Clone, Debug)]
struct Opened {
    part: usize,
    lowers: [f32; LANES],
    children: [Child; LANES],
}

impl NearestFirstQueue {
    pub fn clear(&mut self) {
        self.order.clear();
        self.all.clear();
        self.opened.clear();
    }

    /// Inserts a node. It is called for every pair of the robot: not inlined, it made distances of PR2 8 % slower.
    #[inline(always)]
    pub fn push(&mut self, QueuedNode { lower, node }: QueuedNode) {
        // rounded down
        self.order.push(key(-round_up(-lower), self.all.len()));
        self.all.push(Queued::One(node));
    }

    /// Inserts the children of a node with their lower bounds (m); NaN is no bound.
    pub fn push_children(&mut self, part: usize, lowers: [f32; LANES], children: [Child; LANES]) {
        let bound = |lane: usize| match children[lane] {
            Child::Nothing => f32::INFINITY,
            // an infinite bound would mark a child as taken out
            _ => lowers[lane].greater(0.0).lesser(f32::MAX),
        };
        let opened = Opened { part, lowers: std::array::from_fn(bound), children };
        if let Some((_, lower)) = opened.nearest() {
            self.order.push(key(lower, self.all.len()));
            self.all.push(Queued::Opened(self.opened.len()));
            self.opened.push(opened);
        }
    }

    /// Removes the candidate with the smallest bound.
    #[allow(clippy::cast_possible_truncation)] // halves of the key
    pub fn pop(&mut self) -> Option<QueuedNode> {
        loop {
            let Reverse(key) = self.order.pop()?;
            let (lower, index) = (f64::from(f32::from_bits((key >> 32) as u32)), (key as u32) as usize);
            let node = match self.all[index] {
                Queued::One(node) => Some(node),
                Queued::Opened(number) => self.take_child(number, index),
            };
            if let Some(node) = node {
                return Some(QueuedNode { lower, node });
            }
        }
    }

    fn take_child(&mut self, number: usize, index: usize) -> Option<SearchNode> {
        let opened = &mut self.opened[number];
        let (lane, _) = opened.nearest()?;
        opened.lowers[lane] = f32::INFINITY;
        if let Some((_, lower)) = opened.nearest() {
            self.order.push(key(lower, index));
        }
        let part = opened.part;
        match opened.children[lane] {
            Child::Item(piece) => Some(SearchNode::BoxedPiece { part, piece }),
            Child::Node(node) => Some(SearchNode::TreeNode { part, node }),
            Child::Nothing => None,
        }
    }
}

impl Opened {
    /// The remaining child with the smallest bound: its lane, and the bound (m).
    #[inline]
    fn nearest(&self) -> Option<(usize, f32)> {
        let mut nearest = (0, f32::INFINITY);
        for (lane, lower) in self.lowers.iter().enumerate() {
            if *lower < nearest.1 {
                nearest = (lane, *lower);
            }
        }
        (nearest.1 < f32::INFINITY).then_some(nearest)
    }
}

/// Key of the queue. The bits of non-negative floats have the same order as the floats.
fn key(lower: f32, index: usize) -> Reverse<u64> {
    Reverse(u64::from(lower.greater(0.0).to_bits()) << 32 | index as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::testing::Random;

    #[test]
    fn what_may_be_nearest_comes_first_with_a_number_that_is_not_larger() {
        let mut random = Random::new(4);
        let mut queue = NearestFirstQueue::default();
        for round in 0..3 {
            let lowers: Vec<f64> = (0..500).map(|_| random.within(2.0)).chain([0.0, f64::INFINITY]).collect();
            for (index, &lower) in lowers.iter().enumerate() {
                queue.push(QueuedNode { lower, node: SearchNode::Pair(index) });
            }
            let mut last = 0.0;
            for _ in 0..lowers.len() - 100 * round {
                let Some(QueuedNode { lower, node: SearchNode::Pair(index) }) = queue.pop() else {
                    panic!("nothing left")
                };
                let pushed = lowers[index].max(0.0);
                assert!(last <= lower && lower <= pushed && (pushed - lower <= 1e-6 || pushed == lower));
                last = lower;
            }
            assert!(round > 0 || queue.pop().is_none());
            queue.clear();
            assert!(queue.pop().is_none());
        }
    }

    #[test]
    fn what_came_together_comes_out_as_if_it_came_alone() {
        let mut random = Random::new(5);
        let (mut queue, mut expected) = (NearestFirstQueue::default(), Vec::new());
        for part in 0..100 {
            let children: [Child; LANES] = std::array::from_fn(|lane| {
                let number = u32::try_from(LANES * part + lane).unwrap();
                [Child::Nothing, Child::Item(number), Child::Node(number)][random.below(3)]
            });
            let lowers =
                std::array::from_fn(|_| [f32::NAN, -1.0, round_up(random.within(2.0))][random.below(3)]);
            queue.push_children(part, lowers, children);
            for (lower, child) in lowers.into_iter().zip(children) {
                let node = match child {
                    Child::Nothing => continue,
                    Child::Item(piece) => SearchNode::BoxedPiece { part, piece },
                    Child::Node(node) => SearchNode::TreeNode { part, node },
                };
                expected.push((f64::from(lower.max(0.0)), node));
            }
        }
        expected.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let mut found: Vec<_> = std::iter::from_fn(|| queue.pop()).map(|q| (q.lower, q.node)).collect();
        assert!(found.is_sorted_by(|p, q| p.0 <= q.0));
        found.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        assert_eq!(found, expected);
    }

    #[test]
    fn of_equal_ones_the_first_comes_first_and_what_is_no_number_before_all() {
        let mut queue = NearestFirstQueue::default();
        for (index, lower) in [0.5, 0.25, 0.5, f64::NAN, -1.0].into_iter().enumerate() {
            queue.push(QueuedNode { lower, node: SearchNode::Pair(index) });
        }
        let order: Vec<SearchNode> = std::iter::from_fn(|| queue.pop()).map(|queued| queued.node).collect();
        assert_eq!(order, [3, 4, 1, 0, 2].map(SearchNode::Pair));
    }
}
