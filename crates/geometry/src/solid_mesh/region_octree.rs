//! Octree of the box around a solid: cells that are inside, cells that are outside, and cells with a part of the surface (Samet 1984,
//! *The quadtree and related hierarchical data structures*, section 2, in three dimensions).
//!
//! A cell that contains no part of the surface is wholly inside or wholly outside, so the winding number of its centre decides for all of
//! its points.

use crate::math::Point;

/// Maximum number of cells.
const MOST_CELLS: usize = 4096;

/// Number of faces for each cell, up to the maximum.
const FACES_PER_CELL: usize = 4;

/// Least maximum number of cells.
const FEWEST_CELLS: usize = 64;

/// Content of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Region {
    Outside,
    Inside,
    /// Undecided: it may contain a part of the surface.
    Boundary,
}

/// A region, or the index of the first of eight children.
#[derive(Clone, Copy, Debug)]
enum Cell {
    Region(Region),
    Children(u32),
}

/// Cells of the box around a solid.
#[derive(Clone, Debug)]
pub(super) struct RegionOctree {
    bounds: [Point; 2],
    /// The first cell is the whole box.
    cells: Vec<Cell>,
}

impl RegionOctree {
    /// Cells of the box `bounds` around a surface of `faces` triangles. `is_clear` is true only for boxes without a part of the surface,
    /// and `is_inside` gives the side of points that are in such boxes.
    pub fn new(
        bounds: [Point; 2],
        faces: usize,
        is_clear: impl Fn(&[Point; 2]) -> bool,
        is_inside: impl Fn(&Point) -> bool,
    ) -> Self {
        let most = (faces / FACES_PER_CELL).clamp(FEWEST_CELLS, MOST_CELLS);
        let mut cells = vec![Cell::Region(Region::Boundary)];
        let mut boxes = vec![bounds];
        let mut number = 0;
        while number < cells.len() && cells.len() + 8 <= most {
            if matches!(cells[number], Cell::Region(Region::Boundary)) {
                cells[number] = Cell::Children(u32::try_from(cells.len()).expect("cells are few"));
                let children = octants(&boxes[number]);
                let regions = regions_of(&children, &is_clear, &is_inside);
                cells.extend(regions.map(Cell::Region));
                boxes.extend(children);
            }
            number += 1;
        }
        Self { bounds, cells }
    }

    /// The region of a point.
    pub fn region(&self, point: &Point) -> Region {
        let [mut low, mut high] = self.bounds;
        if !(0..3).all(|i| (low[i]..=high[i]).contains(&point[i])) {
            return Region::Outside;
        }
        let mut cell = self.cells[0];
        loop {
            match cell {
                Cell::Region(region) => return region,
                Cell::Children(first) => {
                    let middle = middle_of(&[low, high]);
                    let mut octant = 0;
                    for i in 0..3 {
                        if point[i] > middle[i] {
                            low[i] = middle[i];
                            octant |= 1 << i;
                        } else {
                            high[i] = middle[i];
                        }
                    }
                    cell = self.cells[first as usize + octant];
                }
            }
        }
    }

    /// The centre of the largest cell inside; `None` if no cell is wholly inside.
    pub fn inner_point(&self) -> Option<Point> {
        let mut level = vec![(0, self.bounds)];
        while !level.is_empty() {
            let mut below = Vec::new();
            for (number, bounds) in level {
                match self.cells[number] {
                    Cell::Region(Region::Inside) => return Some(middle_of(&bounds)),
                    Cell::Region(_) => {}
                    Cell::Children(first) => below.extend((first as usize..).zip(octants(&bounds))),
                }
            }
            level = below;
        }
        None
    }

    /// The box of all cells.
    pub fn bounds(&self) -> &[Point; 2] {
        &self.bounds
    }

    /// Visits the boxes of all cells that are not outside.
    pub fn for_each_not_outside(&self, mut visit: impl FnMut(&[Point; 2])) {
        let mut open = vec![(0, self.bounds)];
        while let Some((number, bounds)) = open.pop() {
            match self.cells[number] {
                Cell::Region(Region::Outside) => {}
                Cell::Region(_) => visit(&bounds),
                Cell::Children(first) => open.extend((first as usize..).zip(octants(&bounds))),
            }
        }
    }
}

/// The regions of eight cells; neighbours without a surface between them are alike.
fn regions_of(
    children: &[[Point; 2]; 8],
    is_clear: impl Fn(&[Point; 2]) -> bool,
    is_inside: impl Fn(&Point) -> bool,
) -> [Region; 8] {
    let mut regions = [Region::Boundary; 8];
    for octant in 0..8 {
        if is_clear(&children[octant]) {
            let neighbours = [1, 2, 4].map(|bit| octant ^ bit).into_iter().filter(|other| *other < octant);
            let known = neighbours.map(|other| regions[other]).find(|region| *region != Region::Boundary);
            regions[octant] = known.unwrap_or_else(|| {
                if is_inside(&middle_of(&children[octant])) { Region::Inside } else { Region::Outside }
            });
        }
    }
    regions
}

/// The eight equal parts of a box; bit i of their index is set in the upper half along axis i.
fn octants(bounds: &[Point; 2]) -> [[Point; 2]; 8] {
    let [low, high] = bounds;
    let middle = middle_of(bounds);
    std::array::from_fn(|octant| {
        let is_upper = |i: usize| octant >> i & 1 == 1;
        [
            Point::from([0, 1, 2].map(|i| if is_upper(i) { middle[i] } else { low[i] })),
            Point::from([0, 1, 2].map(|i| if is_upper(i) { high[i] } else { middle[i] })),
        ]
    })
}

fn middle_of([low, high]: &[Point; 2]) -> Point {
    low + (high - low) * 0.5
}
