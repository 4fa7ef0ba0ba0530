//! Search tree of robot states: adds nodes, finds the nearest node, and returns the path to the root.

use crate::space::squared_distance;

/// A tree of states; each edge to a parent is proven free.
#[derive(Clone, Debug)]
pub struct Tree {
    dimension: usize,
    positions: Vec<f64>,
    parents: Vec<usize>,
}

impl Tree {
    /// A tree of its root.
    pub fn new(root: &[f64]) -> Self {
        Self { dimension: root.len(), positions: root.to_vec(), parents: vec![0] }
    }

    pub fn len(&self) -> usize {
        self.parents.len()
    }

    pub fn state(&self, node: usize) -> &[f64] {
        &self.positions[node * self.dimension..][..self.dimension]
    }

    /// Adds a node and returns its number.
    pub fn add(&mut self, state: &[f64], parent: usize) -> usize {
        self.positions.extend_from_slice(state);
        self.parents.push(parent);
        self.parents.len() - 1
    }

    /// The node nearest to a state; the first of several.
    pub fn nearest(&self, state: &[f64]) -> usize {
        let nodes = self.positions.chunks_exact(self.dimension).map(|node| squared_distance(node, state));
        let least = |best: (usize, f64), node: (usize, f64)| if node.1 < best.1 { node } else { best };
        nodes.enumerate().fold((0, f64::INFINITY), least).0
    }

    /// The states from a node to the root.
    pub fn way_to_root(&self, node: usize) -> Vec<Vec<f64>> {
        let mut way = vec![self.state(node).to_vec()];
        let mut at = node;
        while at != 0 {
            at = self.parents[at];
            way.push(self.state(at).to_vec());
        }
        way
    }
}
