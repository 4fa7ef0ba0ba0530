//! Extreme point pairs in the overlap of two facing support sets of convex cores.

use clearance_geometry::math::{Point, Vector};
use clearance_geometry::{PointPair, Triangle, nearest_on_segment, nearest_on_segments, nearest_pair};

use super::support_set::SupportSet;

/// Support sets of two cores along a normal, with at least two points each, and the gap between their planes.
pub(crate) struct FacingSets<'s> {
    a: &'s SupportSet,
    b: &'s SupportSet,
    /// From the first set to the second, times the gap (m); it points back where the cores overlap.
    gap: Vector,
    /// Points above one another may be this far (m) from each other along the planes.
    resolution: f64,
}

impl<'s> FacingSets<'s> {
    /// Sets of points of two cores; `gap` (m) is from the plane of the first set to that of the second.
    pub fn new([a, b]: [&'s mut SupportSet; 2], gap: Vector, resolution: f64) -> Self {
        a.bound_sides();
        b.bound_sides();
        Self { a, b, gap, resolution }
    }

    /// Passes the extreme points of the overlap: corners of either polygon above the other one, and where edges cross. Ends early when
    /// `visit` returns false.
    pub fn each_extreme_pair(&self, mut visit: impl FnMut(PointPair) -> bool) {
        for p in self.a.points() {
            let above = p + self.gap;
            let q = point_within(self.b, self.resolution, &above);
            if q.is_some_and(|q| !visit([*p, q])) {
                return;
            }
        }
        for q in self.b.points() {
            let below = q - self.gap;
            let p = point_within(self.a, self.resolution, &below);
            if p.is_some_and(|p| !visit([p, *q])) {
                return;
            }
        }
        for e in edges(self.a.points()) {
            if self.b.is_beyond(self.resolution, &e.map(|p| p + self.gap)) {
                continue;
            }
            for f in edges(self.b.points()) {
                let [p, below] = nearest_on_segments(&e, &f.map(|q| q - self.gap));
                let are_one = nalgebra::distance(&p, &below) <= self.resolution;
                if are_one && !visit([p, below + self.gap]) {
                    return;
                }
            }
        }
    }
}

/// The point of a set that is nearest to `x`, unless it is farther away than `distance` (m).
fn point_within(set: &SupportSet, distance: f64, x: &Point) -> Option<Point> {
    if set.is_beyond(distance, std::slice::from_ref(x)) {
        return None;
    }
    Some(nearest_on_polygon(set.points(), x)).filter(|p| nalgebra::distance(p, x) <= distance)
}

/// The edges of a polygon; the only one of a segment.
pub(super) fn edges(polygon: &[Point]) -> impl Iterator<Item = [Point; 2]> {
    let count = if polygon.len() == 2 { 1 } else { polygon.len() };
    (0..count).map(|i| [polygon[i], polygon[(i + 1) % polygon.len()]])
}

/// The point of a convex polygon, or a segment, that is nearest to `x`.
fn nearest_on_polygon(polygon: &[Point], x: &Point) -> Point {
    match polygon {
        [p] => *p,
        [p, q] => nearest_on_segment(x, &[*p, *q]),
        [first, rest @ ..] => {
            let fan = rest.windows(2).map(|edge| Triangle { a: *first, b: edge[0], c: edge[1] });
            nearest_pair(fan.map(|t| [t.nearest_point(x), *x]))[0]
        }
        [] => *x,
    }
}
