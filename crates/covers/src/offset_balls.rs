//! Largest balls within an offset solid: a ball has an excess of at most e if it lies in the solid enlarged by e.
//!
//! Distances from the outside of the enlarged solid are found by a Euclidean distance transform (Felzenszwalb and Huttenlocher 2012,
//! *Distance transforms of sampled functions*).

use clearance_geometry::math::{Extremes, Vector};

use crate::ball::Ball;
use crate::distance_grid::DistanceGrid;

/// A ball is left out if that of a neighbour is larger by this part of the distance between the centres: then, it adds little.
const DOMINATED: f64 = 0.8;

/// Balls around grid points, as large as possible within the solid enlarged by `excess` (m), at most about `most`. Balls that lie almost within
/// others are left out: the rest is near the medial axis of the enlarged solid. Radii are approximate.
pub fn largest_balls(grid: &DistanceGrid, excess: f64, most: usize) -> Vec<Ball> {
    let radii = radii(grid, excess);
    let mut kept: Vec<usize> =
        (0..radii.len()).filter(|&i| radii[i] > 0.0 && is_peak(grid, &radii, i)).collect();
    if kept.len() > most {
        let mut random = fastrand::Rng::with_seed(7);
        random.shuffle(&mut kept);
        kept.truncate(most);
        kept.sort_unstable();
    }
    kept.into_iter().map(|i| Ball { centre: grid.point(i), radius: radii[i] }).collect()
}

/// True if no neighbour's ball nearly contains the ball.
fn is_peak(grid: &DistanceGrid, radii: &[f64], index: usize) -> bool {
    let [x, y, z] = grid.cell(index);
    let near = |at: usize, size: usize| at.saturating_sub(1)..=(at + 1).min(size - 1);
    for k in near(z, grid.size[2]) {
        for j in near(y, grid.size[1]) {
            for i in near(x, grid.size[0]) {
                let steps = i.abs_diff(x) + j.abs_diff(y) + k.abs_diff(z);
                let distance = [0.0, 1.0, 1.414, 1.732][steps] * grid.step;
                let other = i + grid.size[0] * (j + grid.size[1] * k);
                if steps > 0 && radii[other] >= radii[index] + DOMINATED * distance {
                    return false;
                }
            }
        }
    }
    true
}

/// By grid point: the approximate radius (m) of the largest ball in the enlarged solid; negative outside.
fn radii(grid: &DistanceGrid, excess: f64) -> Vec<f64> {
    let simple = |value: f64| excess - value;
    let Some(nearest) = nearest_outside(grid, excess) else {
        return grid.values.iter().map(|value| simple(*value)).collect();
    };
    let radius = |(index, value): (usize, &f64)| {
        let outside = nearest[index];
        let gap = (grid.point(outside) - grid.point(index)).norm() - (grid.values[outside] - excess);
        // the corners of grid cells may be farther than the surface
        if *value >= excess { simple(*value) } else { simple(*value).greater(gap - 0.5 * grid.step) }
    };
    grid.values.iter().enumerate().map(radius).collect()
}

/// By grid point: the nearest grid point with a distance of at least `excess` from the solid; `None` if the border of the grid is nearer to
/// the solid than that.
fn nearest_outside(grid: &DistanceGrid, excess: f64) -> Option<Vec<usize>> {
    let last = [0, 1, 2].map(|i| grid.size[i] - 1);
    let on_border = |i: usize| grid.cell(i).iter().zip(last).any(|(at, last)| *at == 0 || *at == last);
    if (0..grid.values.len()).any(|i| on_border(i) && grid.values[i] < excess) {
        return None;
    }
    let is_outside = |i: usize| grid.values[i] >= excess;
    let mut nearest: Vec<Option<usize>> =
        (0..grid.values.len()).map(|i| is_outside(i).then_some(i)).collect();
    let strides = [1, grid.size[0], grid.size[0] * grid.size[1]];
    let mut line = Line::default();
    for (axis, stride) in strides.into_iter().enumerate() {
        for start in (0..grid.values.len()).filter(|i| grid.cell(*i)[axis] == 0) {
            line.transform(grid, &mut nearest, [axis, start, stride]);
        }
    }
    nearest.into_iter().collect()
}

/// One line of the transform along an axis: lower envelope of parabolas.
#[derive(Default)]
struct Line {
    /// Places along the line of the parabolas in the envelope, and where each begins to be the lowest.
    places: Vec<usize>,
    begins: Vec<f64>,
    sources: Vec<Option<usize>>,
}

impl Line {
    #[allow(clippy::cast_precision_loss)] // indices are small
    fn transform(
        &mut self,
        grid: &DistanceGrid,
        nearest: &mut [Option<usize>],
        [axis, start, stride]: [usize; 3],
    ) {
        let length = grid.size[axis];
        self.sources.clear();
        self.sources.extend((0..length).map(|i| nearest[start + i * stride]));
        self.places.clear();
        self.begins.clear();
        for (place, source) in self.sources.iter().enumerate() {
            let Some(source) = *source else { continue };
            let height = |source: usize, place: usize| {
                let at = grid.cell(start + place * stride).map(|i| i as f64);
                (Vector::from(grid.cell(source).map(|i| i as f64)) - Vector::from(at)).norm_squared()
            };
            let own = height(source, place) + (place * place) as f64;
            let mut begin = f64::NEG_INFINITY;
            while let Some(&last) = self.places.last() {
                let of_last = self.sources[last].map_or(0.0, |s| height(s, last)) + (last * last) as f64;
                begin = (own - of_last) / (2.0 * (place - last) as f64);
                if self.begins.last().is_some_and(|b| begin <= *b) {
                    self.places.pop();
                    self.begins.pop();
                    begin = f64::NEG_INFINITY;
                } else {
                    break;
                }
            }
            self.places.push(place);
            self.begins.push(begin);
        }
        let mut current = 0;
        for i in 0..length {
            while current + 1 < self.begins.len() && self.begins[current + 1] <= i as f64 {
                current += 1;
            }
            nearest[start + i * stride] = self.places.get(current).and_then(|place| self.sources[*place]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link_solid::LinkSolid;
    use crate::primitive_mesh::inscribed_mesh;
    use crate::search_limit::SearchLimit;
    use clearance_geometry::Primitive;

    #[test]
    fn the_transform_finds_the_nearest_outside_point() {
        let (mesh, _) = inscribed_mesh(&Primitive::cuboid([0.1, 0.2, 0.3]).unwrap()).unwrap();
        let solid = LinkSolid::of_meshes(vec![mesh]).unwrap();
        let mut grid = DistanceGrid::new(&solid, &SearchLimit::default()).unwrap();
        // fewer points, random outside
        (grid.size, grid.step) = ([7, 6, 5], 1.0);
        let mut random = fastrand::Rng::with_seed(3);
        grid.values = (0..210).map(|_| f64::from(u8::from(random.u8(..5) == 0))).collect();
        let on_border = |grid: &DistanceGrid, i| {
            let [x, y, z] = grid.cell(i);
            x % 6 == 0 || y % 5 == 0 || z % 4 == 0
        };
        for i in 0..210 {
            if on_border(&grid, i) {
                grid.values[i] = 1.0;
            }
        }
        let found = nearest_outside(&grid, 0.5).unwrap();
        for (i, found) in found.iter().enumerate() {
            let distance = |j: usize| (grid.point(i) - grid.point(j)).norm();
            let outside = (0..210).filter(|j| grid.values[*j] >= 0.5);
            let least = outside.map(distance).fold(f64::INFINITY, f64::min);
            assert!((distance(*found) - least).abs() < 1e-9, "{i}");
        }
    }
}
