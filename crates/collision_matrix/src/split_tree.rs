//! Proof tree over a box of joint positions, as text: splits, and the kind of proof of each leaf.
//!
//! A digit or letter is a box that is halved along the variable of that number (`0`–`9`, then `A`–`Z`); its lower half follows, then its
//! upper half. A leaf is a box that is proven: `.` by the distance at its centre, `|` by the gap along a joint axis, `/` and three
//! characters by the gap along a direction, `*` by the overlap of two balls.

use crate::plane_direction::{PlaneDirection, three_digits};

/// How a box is proven free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeafProof {
    /// The distance at the centre exceeds the motion.
    Distance,
    /// The gap along a joint axis exceeds the motion along it.
    GapAlongAxis,
    /// The gap along a direction exceeds the motion along it.
    GapAlong(PlaneDirection),
    /// Balls inside the links overlap.
    Overlap {
        /// Numbers of the balls of the first and of the second link.
        balls: [u32; 2],
        /// Direction along which the first solid sticks out of the second, and the reverse, where it matters.
        outside: [Option<PlaneDirection>; 2],
    },
}

/// A box.
#[derive(Clone, Copy, Debug)]
enum Node {
    Leaf(LeafProof),
    /// Index of the lower half; the upper half is the next.
    Split {
        variable: u8,
        children: u32,
    },
}

/// Splits of a box; node 0 is the whole box.
#[derive(Clone, Debug)]
pub struct SplitTree {
    nodes: Vec<Node>,
}

/// Largest number of variables.
pub const MOST_VARIABLES: usize = 36;

impl Default for SplitTree {
    fn default() -> Self {
        Self { nodes: vec![Node::Leaf(LeafProof::Distance)] }
    }
}

impl SplitTree {
    /// Splits a leaf; returns the index of its lower half, which the upper half follows.
    pub fn split(&mut self, leaf: u32, variable: usize) -> u32 {
        let children = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        let variable = u8::try_from(variable).unwrap_or(u8::MAX);
        self.nodes[leaf as usize] = Node::Split { variable, children };
        self.nodes.extend([Node::Leaf(LeafProof::Distance); 2]);
        children
    }

    /// Records the proof of a leaf.
    pub fn prove(&mut self, leaf: u32, proof: LeafProof) {
        self.nodes[leaf as usize] = Node::Leaf(proof);
    }

    /// The tree as text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::with_capacity(self.nodes.len());
        let mut open = vec![0u32];
        while let Some(index) = open.pop() {
            match self.nodes[index as usize] {
                Node::Leaf(LeafProof::Distance) => text.push('.'),
                Node::Leaf(LeafProof::GapAlongAxis) => text.push('|'),
                Node::Leaf(LeafProof::GapAlong(direction)) => {
                    text.push('/');
                    text.extend(direction.text());
                }
                Node::Leaf(LeafProof::Overlap { balls, outside }) => {
                    text.push('*');
                    text.extend(balls.into_iter().flat_map(three_digits));
                    text.push(match outside.map(|direction| direction.is_some()) {
                        [false, false] => '0',
                        [true, false] => '1',
                        [false, true] => '2',
                        [true, true] => '3',
                    });
                    text.extend(outside.into_iter().flatten().flat_map(PlaneDirection::text));
                }
                Node::Split { variable, children } => {
                    text.push(char::from_digit(u32::from(variable), 36).unwrap_or('?').to_ascii_uppercase());
                    open.extend([children + 1, children]);
                }
            }
        }
        text
    }
}
