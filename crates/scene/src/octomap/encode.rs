//! Encoder of OctoMap's binary tree encoding; see [`super::decode`] for the format.

use super::{Cell, LEVELS, Octomap, Space};

/// Code of a child that is an inner node.
const INNER: u16 = 3;

impl Octomap {
    /// The tree of an `octomap_msgs/Octomap` whose `binary` is true; empty if no cell is known. With
    /// `unknown_is_occupied`, the cells of unknown space are occupied cells of the tree (see [`Self::unknown_cells`]).
    #[must_use]
    pub fn to_binary(&self, unknown_is_occupied: bool) -> Vec<u8> {
        let unknown = if unknown_is_occupied { self.unknown_cells() } else { Vec::new() };
        let occupied = unknown.into_iter().map(|cell| Cell { space: Space::Occupied, ..cell });
        let known = self.cells.iter().filter(|cell| cell.space != Space::Unknown).copied();
        let mut cells: Vec<Cell> = known.chain(occupied).collect();
        let leaf_at_root = cells.first().copied().filter(|cell| cell.level == LEVELS);
        if let Some(root) = leaf_at_root {
            // the root of a binary tree is an inner node
            cells = (0..8).map(|index| root.child(index, root.space)).collect();
        }
        cells.sort_by_cached_key(|cell| morton_code(cell.corner));
        let mut bytes = Vec::new();
        if !cells.is_empty() {
            encode(LEVELS, &cells, &mut bytes);
        }
        bytes
    }
}

/// Appends an inner node of this level that contains `cells`, in the order of their Morton codes, and the nodes below
/// it. Space without a cell is unknown. The recursion depth is limited by the number of levels.
fn encode(level: u8, cells: &[Cell], bytes: &mut Vec<u8>) {
    let below = level - 1;
    let mut rest = cells;
    let children = [0, 1, 2, 3, 4, 5, 6, 7].map(|index| {
        let count = rest.partition_point(|cell| octant(cell.corner, below) <= index);
        let (child, others) = rest.split_at(count);
        rest = others;
        child
    });
    let codes = children.map(|child| code(child, below));
    let word = codes.iter().rev().fold(0_u16, |word, &code| word << 2 | code);
    bytes.extend(word.to_le_bytes());
    for (child, code) in children.into_iter().zip(codes) {
        if code == INNER {
            encode(below, child, bytes);
        }
    }
}

/// Code of a child of this level that contains `cells`.
fn code(cells: &[Cell], level: u8) -> u16 {
    match cells {
        [] => 0,
        [cell] if cell.level == level && cell.space == Space::Free => 1,
        [cell] if cell.level == level => 2,
        _ => INNER,
    }
}

/// Position of a cell in an order in which the cells of each node follow one another, child by child.
fn morton_code(corner: [u16; 3]) -> u64 {
    (0..LEVELS).map(|bit| octant(corner, bit) << (3 * bit)).sum()
}

/// Index of the child that contains a cell, among the children of this level of a node.
fn octant(corner: [u16; 3], level: u8) -> u64 {
    [0, 1, 2].map(|axis| u64::from(corner[axis] >> level & 1) << axis).iter().sum()
}
