//! Sample points on the surface and inside of a solid, to guide the search for a cover; the proof follows in
//! `containment`.

use std::collections::HashSet;

use clearance_geometry::Triangle;
use clearance_geometry::math::{Extremes, Point, Vector};

use crate::distance_grid::DistanceGrid;
use crate::link_solid::LinkSolid;

/// Aimed number of points on the surface, and inside.
const ON_SURFACE: f64 = 1400.0;
const INSIDE: usize = 700;

/// Points (m) on the surface of a solid with their spacing (m).
pub fn surface_points(solid: &LinkSolid) -> (Vec<Point>, f64) {
    let area: f64 = solid.triangles().map(|t| 0.5 * (t.b - t.a).cross(&(t.c - t.a)).norm()).sum();
    let spacing = (area / ON_SURFACE).sqrt() + 1e-3 * solid.extent() + 1e-12;
    // corners first: covers are tight there
    let corners = solid.triangles().flat_map(Triangle::corners);
    let between = solid.triangles().flat_map(|triangle| lattice(triangle, spacing));
    (thinned(corners.chain(between), spacing), spacing)
}

/// The first point (m) in each cell of a grid of this step (m).
pub fn thinned(points: impl Iterator<Item = Point>, step: f64) -> Vec<Point> {
    let mut taken = HashSet::new();
    #[allow(clippy::cast_possible_truncation)] // saturates beyond 2^63 cells
    let cell = |p: &Point| [0, 1, 2].map(|i| (p[i] / step).floor() as i64);
    points.filter(|p| taken.insert(cell(p))).collect()
}

/// Points on a triangle, at most about `spacing` apart; its corners are not among them. A narrow triangle has points on its edges alone, so
/// that the number of all points is bounded by the area.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a few hundred steps
fn lattice(triangle: &Triangle, spacing: f64) -> Vec<Point> {
    let Triangle { a, b, c } = *triangle;
    let steps_of = |length: f64| (length / spacing).ceil().clamp(1.0, 200.0) as u32;
    let longest = triangle.edges().iter().map(|[p, q]| (q - p).norm()).fold(0.0, Extremes::greater);
    if (b - a).cross(&(c - a)).norm() < spacing * longest {
        let on_edge = |[p, q]: [Point; 2]| {
            let steps = steps_of((q - p).norm());
            (1..steps).map(move |i| p + (q - p) * (f64::from(i) / f64::from(steps)))
        };
        return triangle.edges().into_iter().flat_map(on_edge).collect();
    }
    let steps = steps_of(longest);
    let mut points = vec![];
    for i in 0..=steps {
        for j in 0..=steps - i {
            if i != steps && j != steps && i + j != 0 {
                let (u, v) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
                points.push(a + (b - a) * u + (c - a) * v);
            }
        }
    }
    points
}

/// Points (m) inside a solid, deeper than `depth` (m).
pub fn inner_points(grid: &DistanceGrid, depth: f64) -> Vec<Point> {
    let inside: Vec<usize> = (0..grid.values.len()).filter(|i| grid.values[*i] < -depth).collect();
    let stride = inside.len() / INSIDE + 1;
    inside.into_iter().step_by(stride).map(|i| grid.point(i)).collect()
}

/// Directions spread evenly over the sphere (Fibonacci lattice).
pub fn directions(count: u32) -> Vec<Vector> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let direction = |i: u32| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (radius, angle) = ((1.0 - z * z).sqrt(), golden * f64::from(i));
        Vector::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    (0..count).map(direction).collect()
}
