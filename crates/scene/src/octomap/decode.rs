//! Decoders of OctoMap's two tree encodings, both depth first.
//!
//! Binary, without probabilities: each inner node is 16 bits, two for each child from the lowest on: 0 unknown, 1 free, 2 occupied, 3 an
//! inner node, whose data follows in turn. Full: each node is its log-odds (f32) and, for coloured trees, three bytes of colour, then a
//! byte whose bits mark the existing children; their data follows. A node without children is a leaf, and is occupied if its log-odds are
//! not below zero (a probability of one half).

#![allow(clippy::redundant_closure_for_method_calls)] // a method's lifetimes are not general enough

use super::{Cell, MOST_CELLS, Octomap, OctomapError, Space};

struct Decoder<'b> {
    bytes: &'b [u8],
    /// The next byte.
    at: usize,
    /// Number of bytes before the tree in its file, so that errors give offsets in the file.
    skipped: usize,
    cells: Vec<Cell>,
    nodes: usize,
}

impl Octomap {
    /// The tree of an `octomap_msgs/Octomap`. A binary tree has the same encoding for all types.
    pub fn from_message(binary: bool, id: &str, resolution: f64, data: &[u8]) -> Result<Self, OctomapError> {
        if binary { Self::from_binary(resolution, data) } else { Self::from_full(resolution, id, data) }
    }

    /// The tree of an `octomap_msgs/Octomap` whose `binary` is true.
    pub fn from_binary(resolution: f64, data: &[u8]) -> Result<Self, OctomapError> {
        Self::new(resolution, decoded(data, 0, None, |decoder, root| decoder.binary_node(root))?)
    }

    /// The tree of an `octomap_msgs/Octomap` whose `binary` is false; `id` is its type.
    pub fn from_full(resolution: f64, id: &str, data: &[u8]) -> Result<Self, OctomapError> {
        Self::new(resolution, full(id, data, 0)?)
    }
}

/// The cells of a binary tree with exactly `announced` nodes; `skipped` bytes precede it.
pub(super) fn binary(data: &[u8], skipped: usize, announced: usize) -> Result<Vec<Cell>, OctomapError> {
    decoded(data, skipped, Some(announced), |decoder, root| decoder.binary_node(root))
}

/// The cells of a full tree.
pub(super) fn full(id: &str, data: &[u8], skipped: usize) -> Result<Vec<Cell>, OctomapError> {
    match id {
        "OcTree" => decoded(data, skipped, None, |decoder, root| decoder.full_node(root, 0)),
        "ColorOcTree" => decoded(data, skipped, None, |decoder, root| decoder.full_node(root, 3)),
        other => Err(OctomapError::UnknownType(other.chars().take(40).collect())),
    }
}

fn decoded(
    bytes: &[u8],
    skipped: usize,
    announced: Option<usize>,
    read: impl FnOnce(&mut Decoder, Cell) -> Result<(), OctomapError>,
) -> Result<Vec<Cell>, OctomapError> {
    let mut decoder = Decoder { bytes, at: 0, skipped, cells: Vec::new(), nodes: 1 };
    // an empty tree has no root, and takes no bytes
    if bytes.is_empty() {
        decoder.nodes = 0;
        decoder.cells.push(Cell::ROOT);
    } else {
        read(&mut decoder, Cell::ROOT)?;
    }
    let count = bytes.len() - decoder.at;
    match announced {
        _ if count > 0 => Err(OctomapError::Trailing { byte: decoder.place(), count }),
        Some(announced) if announced != decoder.nodes => {
            Err(OctomapError::WrongSize { announced, found: decoder.nodes })
        }
        _ => Ok(decoder.cells),
    }
}

impl Decoder<'_> {
    fn place(&self) -> usize {
        self.skipped + self.at
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], OctomapError> {
        let taken = self.bytes[self.at..].first_chunk();
        let taken = taken.ok_or(OctomapError::Truncated { byte: self.place() })?;
        self.at += N;
        Ok(*taken)
    }

    fn keep(&mut self, cell: Cell) -> Result<(), OctomapError> {
        self.cells.push(cell);
        (self.cells.len() <= MOST_CELLS).then_some(()).ok_or(OctomapError::TooManyCells)
    }

    /// The recursion depth is limited by the number of levels.
    fn binary_node(&mut self, node: Cell) -> Result<(), OctomapError> {
        let byte = self.place();
        if node.level == 0 {
            return Err(OctomapError::TooDeep { byte });
        }
        let word = u16::from_le_bytes(self.take()?);
        let code = |index: usize| word >> (2 * index) & 3;
        for index in 0..8 {
            self.nodes += usize::from(code(index) != 0);
            match code(index) {
                0 => self.keep(node.child(index, Space::Unknown))?,
                1 => self.keep(node.child(index, Space::Free))?,
                2 => self.keep(node.child(index, Space::Occupied))?,
                _ => {}
            }
        }
        for index in (0..8).filter(|&index| code(index) == 3) {
            self.binary_node(node.child(index, Space::Unknown))?;
        }
        Ok(())
    }

    fn full_node(&mut self, node: Cell, colour: usize) -> Result<(), OctomapError> {
        let byte = self.place();
        let log_odds = f32::from_le_bytes(self.take()?);
        if colour == 3 {
            self.take::<3>()?;
        }
        let [children] = self.take()?;
        if log_odds.is_nan() {
            return Err(OctomapError::NoNumber { byte });
        }
        if children == 0 {
            let space = if log_odds >= 0.0 { Space::Occupied } else { Space::Free };
            return self.keep(Cell { space, ..node });
        }
        if node.level == 0 {
            return Err(OctomapError::TooDeep { byte });
        }
        for index in 0..8 {
            let child = node.child(index, Space::Unknown);
            if children >> index & 1 == 0 {
                self.keep(child)?;
            } else {
                self.nodes += 1;
                self.full_node(child, colour)?;
            }
        }
        Ok(())
    }
}
