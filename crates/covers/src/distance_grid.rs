//! Signed distances from a solid on a regular grid: fast approximate values for the search of covers. Nothing is proven with it.

use clearance_geometry::math::{Extremes, Point, Vector};

use crate::link_solid::LinkSolid;
use crate::search_limit::SearchLimit;

/// Largest number of grid points.
const MOST_POINTS: f64 = 120_000.0;

/// Width of the border around the solid's box, relative to the diagonal of the box.
const BORDER: f64 = 0.12;

/// Grid of signed distances (m).
#[derive(Clone, Debug)]
pub struct DistanceGrid {
    /// Position of the first grid point (m).
    pub origin: Point,
    /// Distance (m) between neighbours along an axis.
    pub step: f64,
    /// Number of points along each axis.
    pub size: [usize; 3],
    /// Values: x varies fastest.
    pub values: Vec<f64>,
}

impl DistanceGrid {
    /// A grid over the box around a solid, and a border; `None` if the limit ends before.
    pub fn new(solid: &LinkSolid, limit: &SearchLimit) -> Option<Self> {
        let [low, high] = solid.bounds();
        // a flat or tiny solid still gets a grid
        let border = BORDER * (high - low).norm() + 1e-6;
        let edges = (high - low).map(|edge| edge + 2.0 * border);
        let step = (edges.product() / MOST_POINTS).cbrt();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most a few hundred
        let size = [0, 1, 2].map(|i| (edges[i] / step).ceil() as usize + 1);
        let origin = low - Vector::repeat(border);
        let mut grid = Self { origin, step, size, values: vec![0.0; size.iter().product()] };
        let mut row_start = None;
        for row in 0..size[1] * size[2] {
            if limit.is_over() {
                return None;
            }
            let first = grid.point(row * size[0]);
            let mut known = match row_start {
                Some(known) => (first, solid.signed_distance_near(&first, known)),
                None => (first, solid.signed_distance(&first)),
            };
            row_start = Some(known);
            for x in 0..size[0] {
                let p = grid.point(row * size[0] + x);
                known = (p, solid.signed_distance_near(&p, known));
                grid.values[row * size[0] + x] = known.1;
            }
        }
        Some(grid)
    }

    /// A grid without values, for a search that has no time to find them.
    pub fn empty() -> Self {
        Self { origin: Point::origin(), step: 1.0, size: [2; 3], values: vec![0.0; 8] }
    }

    /// Position (m) of a grid point.
    #[allow(clippy::cast_precision_loss)] // indices are small
    pub fn point(&self, index: usize) -> Point {
        let [x, y, z] = self.cell(index);
        self.origin + Vector::new(x as f64, y as f64, z as f64) * self.step
    }

    /// Indices of a grid point along the axes.
    pub fn cell(&self, index: usize) -> [usize; 3] {
        let [width, height, _] = self.size;
        [index % width, index / width % height, index / (width * height)]
    }

    /// Approximate signed distance (m) of any point, by trilinear interpolation. Beyond the grid, the distance from the grid is added.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn value(&self, p: &Point) -> f64 {
        let (mut base, mut part, mut beyond) = ([0; 3], [0.0; 3], 0.0);
        for i in 0..3 {
            let at = (p[i] - self.origin[i]) / self.step;
            let inside = at.greater(0.0).lesser((self.size[i] - 1) as f64);
            beyond += (at - inside) * (at - inside);
            base[i] = (inside as usize).min(self.size[i] - 2);
            part[i] = inside - base[i] as f64;
        }
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        let first = base[0] + base[1] * strides[1] + base[2] * strides[2];
        let along_x = |at: usize| self.values[at] + part[0] * (self.values[at + 1] - self.values[at]);
        let along_y = |at: usize| {
            let (near, far) = (along_x(at), along_x(at + strides[1]));
            near + part[1] * (far - near)
        };
        let (near, far) = (along_y(first), along_y(first + strides[2]));
        let value = near + part[2] * (far - near);
        if beyond > 0.0 { value + beyond.sqrt() * self.step } else { value }
    }
}
