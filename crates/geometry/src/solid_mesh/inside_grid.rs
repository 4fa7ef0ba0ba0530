//! Grid over the box around a solid, with a bit for each cell that may contain points inside: a lookup for points in single precision.

use super::region_octree::RegionOctree;
use crate::math::{Point, Vector};

/// Cells of equal size in the box around a solid, [`Self::CELLS`] along each axis.
#[derive(Clone, Debug)]
pub struct InsideGrid {
    bounds: [Point; 2],
    /// For each cell along z and y, a bit mask of the cells along x that may contain points inside.
    rows: Vec<u32>,
}

impl InsideGrid {
    /// Number of cells along each axis.
    pub const CELLS: u8 = 32;

    /// Largest error of a coordinate, in cells, with which a point may be looked up.
    pub const MARGIN: f32 = 0.0625;

    pub(super) fn new(regions: &RegionOctree) -> Self {
        let cells = usize::from(Self::CELLS);
        let mut grid = Self { bounds: *regions.bounds(), rows: vec![0; cells * cells] };
        let scale = grid.cells_per_metre();
        regions.for_each_not_outside(|[low, high]| {
            let range = |i: usize| {
                let [from, to] = [low, high].map(|corner| (corner[i] - grid.bounds[0][i]) * scale[i]);
                Self::cells_between(from, to)
            };
            let [x, y, z] = [0, 1, 2].map(range);
            let mask = x.fold(0, |mask, cell| mask | 1 << cell);
            for z in z {
                for y in y.clone() {
                    grid.rows[cells * z + y] |= mask;
                }
            }
        });
        grid
    }

    /// The cells that come within twice the margin of an interval.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
    fn cells_between(from: f64, to: f64) -> std::ops::RangeInclusive<usize> {
        let (margin, last) = (2.0 * f64::from(Self::MARGIN), f64::from(Self::CELLS - 1));
        let cell = |coordinate: f64| coordinate.floor().clamp(0.0, last) as usize;
        cell(from - margin)..=cell(to + margin)
    }

    /// Smallest and largest corner of the box, in the frame of the mesh.
    #[must_use]
    pub fn bounds(&self) -> &[Point; 2] {
        &self.bounds
    }

    /// Number of cells per metre along each axis; 0 where the box has no extent.
    #[must_use]
    pub fn cells_per_metre(&self) -> Vector {
        let extents = self.bounds[1] - self.bounds[0];
        extents.map(|extent| if extent > 0.0 { f64::from(Self::CELLS) / extent } else { 0.0 })
    }

    /// False if a point is certainly outside, given its distance from the smallest corner in cells, with an error of at most the margin.
    #[must_use]
    #[inline]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
    pub fn may_contain(&self, point: [f32; 3]) -> bool {
        let cells = f32::from(Self::CELLS);
        let is_in_box = point.iter().all(|c| *c >= -Self::MARGIN && *c <= cells + Self::MARGIN);
        let [x, y, z] = point.map(|c| c.clamp(0.0, cells - 1.0) as usize);
        is_in_box && self.rows[usize::from(Self::CELLS) * z + y] & 1 << x != 0
    }
}
