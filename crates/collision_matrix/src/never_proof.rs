//! Proof that two links never collide: branch and bound over boxes of joint positions.
//!
//! A box is free if the distance of the links at its centre exceeds the bound of their relative motion within it. Other boxes are halved
//! along the variable that contributes most to the bound. Boxes of small distance come first, so that a collision is found early. When
//! many boxes are open, the search goes on depth first, which needs little memory.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::joint_box::JointBox;
use crate::options::MatrixOptions;
use crate::pair_problem::{PairProblem, PairWorkspace};
use crate::split_tree::SplitTree;

/// Number of open boxes at which the search becomes depth first.
const MOST_OPEN: usize = 20_000;

/// Number of boxes between two looks at the clock.
const BOXES_PER_LOOK: u64 = 256;

/// Half width (rad, m) below which a box is not halved further: the links touch there.
const NARROWEST: f64 = 1e-7;

/// Part of the motion bound that a distance must have for a look at the gap along a direction.
const GAP_SHARE: f64 = 0.2;

/// Distance (m) of links that almost touch: only a gap along a joint axis proves many of them.
const TOUCHING: f64 = 1e-4;

/// Limits of a search.
#[derive(Clone, Copy, Debug)]
pub struct ProofLimits<'o> {
    /// Largest number of boxes.
    pub boxes: u64,
    /// When the search ends early.
    pub options: &'o MatrixOptions,
}

impl ProofLimits<'_> {
    /// True if the search must end after a number of boxes.
    #[must_use]
    pub fn are_reached(&self, boxes: u64) -> bool {
        boxes >= self.boxes || (boxes.is_multiple_of(BOXES_PER_LOOK) && self.options.is_over())
    }
}

/// Result of the search.
#[derive(Debug)]
pub enum NeverSearch {
    /// All boxes are proven free.
    Proven(SplitTree),
    /// Values of the variables at which the links collide.
    Collision(Vec<f64>),
    /// The limits were reached first.
    Exhausted {
        /// Smallest distance (m) found, and its state.
        least: f64,
        /// Values of the variables.
        values: Vec<f64>,
    },
}

/// A box that is not proven.
struct OpenBox {
    /// Upper bound (m) on the distance at its parent's centre.
    distance: f64,
    node: u32,
    ranges: JointBox,
}

impl PartialEq for OpenBox {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for OpenBox {}

impl PartialOrd for OpenBox {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for OpenBox {
    /// The greatest is the nearest, then the earliest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.node.cmp(&self.node))
    }
}

/// Boxes in the order of their treatment.
enum Queue {
    NearestFirst(BinaryHeap<OpenBox>),
    DepthFirst(Vec<OpenBox>),
}

impl Queue {
    fn pop(&mut self) -> Option<OpenBox> {
        match self {
            Self::NearestFirst(heap) => heap.pop(),
            Self::DepthFirst(stack) => stack.pop(),
        }
    }

    fn push(&mut self, halves: [OpenBox; 2]) {
        match self {
            Self::NearestFirst(heap) => {
                heap.extend(halves);
                if heap.len() > MOST_OPEN {
                    *self = Self::DepthFirst(std::mem::take(heap).into_sorted_vec());
                }
            }
            Self::DepthFirst(stack) => stack.extend(halves),
        }
    }
}

/// Searches a proof that the links of a pair never collide, or a collision.
pub fn search(problem: &PairProblem, limits: ProofLimits, workspace: &mut PairWorkspace) -> NeverSearch {
    let mut tree = SplitTree::default();
    let (mut centre, mut half_widths) = (Vec::new(), Vec::new());
    let (mut least, mut values) = (f64::INFINITY, Vec::new());
    let whole = OpenBox { distance: 0.0, node: 0, ranges: JointBox { ranges: problem.ranges() } };
    let mut open = Queue::NearestFirst(BinaryHeap::from([whole]));
    let mut boxes = 0;
    while let Some(OpenBox { node, ranges, .. }) = open.pop() {
        if limits.are_reached(boxes) {
            return NeverSearch::Exhausted { least, values };
        }
        boxes += 1;
        ranges.centre(&mut centre, &mut half_widths);
        problem.path.place(&centre, &mut workspace.placed);
        if !problem.bound_motion(&half_widths, workspace) {
            return NeverSearch::Exhausted { least, values };
        }
        let limit = workspace.motion.bound + problem.threshold();
        let Some(near) = problem.placed_distance(limit, workspace) else { continue };
        let distance = near.distance;
        if distance < least {
            (least, values) = (distance, centre.clone());
        }
        if distance <= problem.threshold() {
            return NeverSearch::Collision(centre);
        }
        if (distance > GAP_SHARE * limit || distance < TOUCHING)
            && let Some(proof) = problem.gap_proof(&near, &half_widths, workspace)
        {
            tree.prove(node, proof);
            continue;
        }
        let Some(variable) = widest(&workspace.motion.shares, &half_widths) else {
            return NeverSearch::Exhausted { least, values };
        };
        let lower = tree.split(node, variable);
        let [low, high] = ranges.halves(variable);
        // depth first, the lower half is next
        open.push([
            OpenBox { distance, node: lower + 1, ranges: high },
            OpenBox { distance, node: lower, ranges: low },
        ]);
    }
    NeverSearch::Proven(tree)
}

/// The variable that moves the links most, if it can be halved.
pub fn widest(shares: &[f64], half_widths: &[f64]) -> Option<usize> {
    let halvable = (0..shares.len()).filter(|k| half_widths[*k] > NARROWEST);
    halvable.max_by(|i, j| shares[*i].total_cmp(&shares[*j]).then(j.cmp(i)))
}
