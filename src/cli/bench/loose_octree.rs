//! Broad phase for comparison: loose octree, where a box belongs to the cell of its size that holds its centre.
//! Ulrich 2000, *Loose octrees*, in *Game Programming Gems*. A cell with its boxes extends by half an edge beyond
//! its sides.

use clearance::proximity::bvh::AxisBox;

use super::structures::{BroadPhase, ItemBoxes, overlap};

/// Depth of the smallest cells below the root.
const MOST_LEVELS: u32 = 12;

/// Cells of halved edges. Boxes that do not fit into the root, or whose centre is outside of it, are in the root.
pub struct LooseOctree {
    /// Corner with the least coordinates (m).
    corner: [f32; 3],
    /// Edge of the root (m).
    edge: f32,
    cells: Vec<Cell>,
    boxes: ItemBoxes,
    stack: Vec<(u32, [f32; 3], f32)>,
}

#[derive(Default)]
struct Cell {
    /// Numbers of the eight cells within; zero for none.
    children: [u32; 8],
    items: Vec<u32>,
}

impl BroadPhase for LooseOctree {
    const NAME: &'static str = "loose octree";

    fn build(items: &[(u32, AxisBox)]) -> Self {
        let all = items.iter().fold(AxisBox::EMPTY, |all, (_, bounds)| all.union(bounds));
        let edge = (0..3).map(|i| all.hi[i] - all.lo[i]).fold(0.01, f32::max);
        let (cells, boxes) = (vec![Cell::default()], ItemBoxes::default());
        let mut tree = Self { corner: all.lo, edge, cells, boxes, stack: Vec::new() };
        for (item, bounds) in items {
            tree.set(*item, bounds);
        }
        tree
    }

    fn set(&mut self, item: u32, bounds: &AxisBox) {
        self.remove(item);
        self.boxes.insert(item, bounds);
        let cell = self.cell_of(bounds);
        self.cells[cell].items.push(item);
    }

    fn remove(&mut self, item: u32) {
        if let Some(bounds) = self.boxes.take(item) {
            let cell = self.cell_of(&bounds);
            self.cells[cell].items.retain(|other| *other != item);
        }
    }

    fn overlapping(&mut self, _: u32, with: &AxisBox, found: &mut Vec<u32>) {
        self.stack.push((0, self.corner, self.edge));
        while let Some((number, corner, edge)) = self.stack.pop() {
            let cell = &self.cells[number as usize];
            found.extend(cell.items.iter().filter(|item| self.boxes.overlaps(**item, with)));
            let half = 0.5 * edge;
            for (octant, &child) in cell.children.iter().enumerate().filter(|(_, child)| **child != 0) {
                let corner: [f32; 3] =
                    std::array::from_fn(|i| corner[i] + if octant >> i & 1 == 1 { half } else { 0.0 });
                // half an edge on either side, and a little for rounding
                let slack = 0.5 * half + 1e-5 * self.edge;
                let loose = AxisBox { lo: corner.map(|x| x - slack), hi: corner.map(|x| x + half + slack) };
                if overlap(&loose, with) {
                    self.stack.push((child, corner, half));
                }
            }
        }
    }
}

impl LooseOctree {
    /// Number of the cell of a box; it is made if it is new.
    fn cell_of(&mut self, bounds: &AxisBox) -> usize {
        let size = (0..3).map(|i| bounds.hi[i] - bounds.lo[i]).fold(0.0, f32::max);
        let centre: [f32; 3] = std::array::from_fn(|i| 0.5 * (bounds.lo[i] + bounds.hi[i]));
        let is_within = (0..3).all(|i| (0.0..=self.edge).contains(&(centre[i] - self.corner[i])));
        let (mut cell, mut corner, mut half) = (0, self.corner, 0.5 * self.edge);
        for _ in 0..if is_within { MOST_LEVELS } else { 0 } {
            if size > half {
                break;
            }
            let mut octant = 0;
            for i in 0..3 {
                if centre[i] >= corner[i] + half {
                    octant |= 1 << i;
                    corner[i] += half;
                }
            }
            cell = self.child(cell, octant);
            half *= 0.5;
        }
        cell
    }

    fn child(&mut self, cell: usize, octant: usize) -> usize {
        let child = self.cells[cell].children[octant] as usize;
        if child != 0 {
            return child;
        }
        let new = self.cells.len();
        self.cells.push(Cell::default());
        self.cells[cell].children[octant] = u32::try_from(new).expect("fewer cells than items times levels");
        new
    }
}
