//! OctoMap octrees of occupied, free and unknown space.
//!
//! There is no well-maintained OctoMap reader in Rust, and the format is short: see [`decode`] for the trees and [`files`] for the
//! headers of files.

mod decode;
mod encode;
mod files;
mod unknown;
mod voxels;

use clearance_geometry::constants::LARGEST_COORDINATE;

/// Number of levels from the root cube down to the finest cells.
const LEVELS: u8 = 16;
/// Coordinate of the finest cell whose lower corner is the origin.
const ORIGIN: i32 = 1 << (LEVELS - 1);
/// Maximum number of stored cells, which take 270 MB.
const MOST_CELLS: usize = 1 << 25;

/// An octree as a partition of its root cube.
#[derive(Clone, Debug, PartialEq)]
pub struct Octomap {
    /// Edge of the finest cells (m).
    resolution: f64,
    cells: Vec<Cell>,
}

/// One cube of the partition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// The lower corner, in finest cells from the root cube's corner.
    pub corner: [u16; 3],
    /// The edge is `1 << level` finest cells.
    pub level: u8,
    /// State of the cell.
    pub space: Space,
}

/// State of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// No obstacle.
    Free,
    /// Occupied by an obstacle.
    Occupied,
    /// Never observed.
    Unknown,
}

/// Errors of octree decoding.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum OctomapError {
    #[error("the tree ends in the middle of a node at byte {byte}")]
    Truncated { byte: usize },
    #[error("the node at byte {byte} has children below the {LEVELS} levels that an octree has")]
    TooDeep { byte: usize },
    #[error("the tree ends at byte {byte}, but {count} bytes follow")]
    Trailing { byte: usize, count: usize },
    #[error("the node at byte {byte} has an occupancy that is no number")]
    NoNumber { byte: usize },
    #[error("the tree has more than the {MOST_CELLS} cells that are read")]
    TooManyCells,
    #[error(
        "the resolution is {0}, but must be above zero, and the whole tree no larger than {LARGEST_COORDINATE:e} m"
    )]
    BadResolution(f64),
    #[error("trees of type '{0}' are not read; OcTree and ColorOcTree are")]
    UnknownType(String),
    #[error("the header says {announced} nodes, but the tree has {found}")]
    WrongSize { announced: usize, found: usize },
    #[error("the file does not begin as an octomap file does")]
    NoOctomap,
    #[error("the header lacks '{0}'")]
    Incomplete(&'static str),
    #[error("the header has '{0}' twice, with different values")]
    Contradiction(&'static str),
    #[error("the header has {key} '{value}', which is no number")]
    BadHeader { key: &'static str, value: String },
}

impl Octomap {
    /// Edge of the finest cells (m).
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// All cells, in arbitrary order; together they fill the root cube.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// True if any cell is free or occupied.
    #[must_use]
    pub fn has_known_cells(&self) -> bool {
        self.cells.iter().any(|cell| cell.space != Space::Unknown)
    }

    fn new(resolution: f64, cells: Vec<Cell>) -> Result<Self, OctomapError> {
        let largest = LARGEST_COORDINATE / f64::from(ORIGIN);
        // coordinates of smaller cells cannot be stored as 32-bit floats
        let usable = (f64::from(f32::MIN_POSITIVE)..=largest).contains(&resolution);
        usable.then_some(Self { resolution, cells }).ok_or(OctomapError::BadResolution(resolution))
    }
}

impl Cell {
    const ROOT: Self = Self { corner: [0; 3], level: LEVELS, space: Space::Unknown };

    /// One of the eight children: bit 0 of `index` is along x, bit 1 along y, bit 2 along z.
    fn child(self, index: usize, space: Space) -> Self {
        let level = self.level - 1;
        let bit = |axis: usize| u16::try_from(index >> axis & 1).unwrap_or_default();
        let corner = [0, 1, 2].map(|axis| self.corner[axis] | bit(axis) << level);
        Self { corner, level, space }
    }

    /// Lower and upper corner, in finest cells from the root cube's corner.
    fn bounds(self) -> [[u32; 3]; 2] {
        let lo = self.corner.map(u32::from);
        [lo, lo.map(|c| c + (1 << self.level))]
    }
}

#[cfg(test)]
mod tests;
