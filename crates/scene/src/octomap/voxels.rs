//! Converts octrees to solid cubes.

use std::sync::Arc;

use clearance_geometry::math::Extremes;
use clearance_geometry::{Cube, Voxels, VoxelsError};

use super::{Cell, ORIGIN, Octomap, Space};

impl Octomap {
    /// The occupied cells, and optionally the cells of unknown space (see [`Self::unknown_cells`]), as solid cubes in the frame of the
    /// tree; `None` if there are none. Each cube contains its whole cell: its edge is enlarged by the error of rounding to 32-bit floats.
    pub fn to_voxels(&self, unknown_is_occupied: bool) -> Result<Option<Arc<Voxels>>, VoxelsError> {
        let occupied = self.cells.iter().filter(|cell| cell.space == Space::Occupied).copied();
        let unknown = if unknown_is_occupied { self.unknown_cells() } else { Vec::new() };
        let cubes: Vec<Cube> = occupied.chain(unknown).map(|cell| self.cube(cell)).collect();
        if cubes.is_empty() {
            return Ok(None);
        }
        Voxels::new(cubes).map(|voxels| Some(Arc::new(voxels)))
    }

    /// Lower and upper corner of a cell (m).
    #[must_use]
    pub fn corners(&self, cell: Cell) -> [[f64; 3]; 2] {
        cell.bounds().map(|corner| corner.map(|c| (f64::from(c) - f64::from(ORIGIN)) * self.resolution))
    }

    #[allow(clippy::cast_possible_truncation)] // what is lost is added to the edge
    fn cube(&self, cell: Cell) -> Cube {
        let [lo, hi] = self.corners(cell);
        let centre = [0, 1, 2].map(|k| lo[k].midpoint(hi[k]) as f32);
        let reach = |k: usize| (hi[k] - f64::from(centre[k])).greater(f64::from(centre[k]) - lo[k]);
        Cube { centre, half_edge: rounded_up(reach(0).greater(reach(1)).greater(reach(2))) }
    }
}

#[allow(clippy::cast_possible_truncation)]
fn rounded_up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}
