//! Unknown space of an octree, within the box around its known cells.

use super::{Cell, LEVELS, Octomap, Space};

/// The finest pieces of unknown space at the edge of the known space are not smaller than this fraction of its length, to limit their
/// number.
const FINEST_SHARE: u32 = 256;

impl Octomap {
    /// Cells of unknown space within the box around all known cells.
    ///
    /// Larger cells that reach out of the box are halved along each axis. Pieces smaller than a 256th of the box's length are kept whole
    /// and may reach out of the box; the space added this way is unknown, too.
    #[must_use]
    pub fn unknown_cells(&self) -> Vec<Cell> {
        let Some(seen) = self.known_bounds() else { return Vec::new() };
        let length = (0..3).map(|k| seen[1][k] - seen[0][k]).max().unwrap_or_default();
        let finest = (0..LEVELS).find(|&level| length >> level <= FINEST_SHARE).unwrap_or(LEVELS);
        let mut pieces = Vec::new();
        for cell in self.cells.iter().filter(|cell| cell.space == Space::Unknown) {
            cut(*cell, &seen, finest, &mut pieces);
        }
        pieces
    }

    /// The box around all free or occupied cells, in finest cells; `None` if there are none.
    fn known_bounds(&self) -> Option<[[u32; 3]; 2]> {
        let known = self.cells.iter().filter(|cell| cell.space != Space::Unknown);
        known.map(|cell| cell.bounds()).reduce(|[lo, hi], [l, h]| {
            [[0, 1, 2].map(|k| lo[k].min(l[k])), [0, 1, 2].map(|k| hi[k].max(h[k]))]
        })
    }
}

fn cut(cell: Cell, seen: &[[u32; 3]; 2], finest: u8, pieces: &mut Vec<Cell>) {
    let [lo, hi] = cell.bounds();
    let all = |holds: &dyn Fn(usize) -> bool| (0..3).all(holds);
    if !all(&|k| lo[k] < seen[1][k] && seen[0][k] < hi[k]) {
        return;
    }
    if cell.level <= finest || all(&|k| seen[0][k] <= lo[k] && hi[k] <= seen[1][k]) {
        pieces.push(cell);
        return;
    }
    for index in 0..8 {
        cut(cell.child(index, Space::Unknown), seen, finest, pieces);
    }
}
