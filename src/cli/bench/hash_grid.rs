//! Broad phase for comparison: hash grid, which stores boxes in the grid cells that they overlap.
//! Teschner, Heidelberger, Müller, Pomeranets & Gross 2003, *Optimized spatial hashing*.

use std::collections::HashMap;

use clearance::proximity::bvh::AxisBox;

use super::structures::{BroadPhase, ItemBoxes};

/// Maximum number of cells of a box; boxes with more are stored in a separate list.
const MOST_CELLS: usize = 512;

type Cell = [i32; 3];

pub struct HashGrid {
    /// Edge of a cell (m).
    edge: f32,
    cells: HashMap<Cell, Vec<u32>>,
    /// Items that overlap too many cells.
    large: Vec<u32>,
    boxes: ItemBoxes,
    /// Number of the last search that found each item.
    seen: Vec<u32>,
    search: u32,
}

impl BroadPhase for HashGrid {
    const NAME: &'static str = "hash grid";

    fn build(items: &[(u32, AxisBox)]) -> Self {
        let mut sizes: Vec<f32> = items.iter().map(|(_, bounds)| bounds.girth() / 3.0).collect();
        sizes.sort_by(f32::total_cmp);
        // the cell size matches most of the boxes
        let edge = sizes.get(sizes.len() / 2).map_or(0.1, |median| (2.0 * median).max(0.01));
        let (boxes, seen) = (ItemBoxes::default(), Vec::new());
        let mut grid = Self { edge, cells: HashMap::new(), large: Vec::new(), boxes, seen, search: 0 };
        for (item, bounds) in items {
            grid.set(*item, bounds);
        }
        grid
    }

    fn set(&mut self, item: u32, bounds: &AxisBox) {
        self.remove(item);
        self.boxes.insert(item, bounds);
        self.seen.resize(self.boxes.len(), 0);
        match self.cells_of(bounds) {
            Some(cells) => cells.for_each(|cell| self.cells.entry(cell).or_default().push(item)),
            None => self.large.push(item),
        }
    }

    fn remove(&mut self, item: u32) {
        let Some(bounds) = self.boxes.take(item) else { return };
        let Some(cells) = self.cells_of(&bounds) else {
            return self.large.retain(|other| *other != item);
        };
        for cell in cells {
            if let Some(held) = self.cells.get_mut(&cell) {
                held.retain(|other| *other != item);
            }
        }
    }

    fn overlapping(&mut self, _: u32, with: &AxisBox, found: &mut Vec<u32>) {
        self.search += 1;
        let Self { edge, cells, large, boxes, seen, search } = &mut *self;
        let mut look = |item: u32| {
            let known = std::mem::replace(&mut seen[item as usize], *search) == *search;
            if !known && boxes.overlaps(item, with) {
                found.push(item);
            }
        };
        for item in &*large {
            look(*item);
        }
        match cells_within(*edge, with, 64 * MOST_CELLS) {
            Some(near) => near.filter_map(|cell| cells.get(&cell)).flatten().for_each(|item| look(*item)),
            None => cells.values().flatten().for_each(|item| look(*item)),
        }
    }
}

impl HashGrid {
    fn cells_of(&self, bounds: &AxisBox) -> Option<impl Iterator<Item = Cell> + use<>> {
        cells_within(self.edge, bounds, MOST_CELLS)
    }
}

/// Cells that a box overlaps; `None` if there are more than `most`.
fn cells_within(edge: f32, bounds: &AxisBox, most: usize) -> Option<impl Iterator<Item = Cell> + use<>> {
    #[expect(clippy::cast_possible_truncation, reason = "beyond 32 bits all is one cell")]
    let number = |x: f32| (x / edge).floor() as i32;
    let (lo, hi) = (bounds.lo.map(number), bounds.hi.map(number));
    let counts: [usize; 3] = std::array::from_fn(|i| {
        usize::try_from(i64::from(hi[i]) - i64::from(lo[i]) + 1).unwrap_or(usize::MAX)
    });
    let count = counts.iter().try_fold(1_usize, |all, count| all.checked_mul(*count))?;
    (count <= most).then(|| {
        (lo[0]..=hi[0])
            .flat_map(move |x| (lo[1]..=hi[1]).flat_map(move |y| (lo[2]..=hi[2]).map(move |z| [x, y, z])))
    })
}
