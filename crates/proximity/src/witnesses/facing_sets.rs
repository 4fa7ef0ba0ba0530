//! Extreme point pairs in the overlap of two facing support sets of convex cores.

use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_geometry::{PointPair, Triangle, nearest_on_segment, nearest_on_segments, nearest_pair};

use super::support_set::SupportSet;

/// Support sets of two cores along a normal, with at least two points each, and the gap between their planes.
pub(crate) struct FacingSets<'s> {
    a: FlatSet<'s>,
    b: FlatSet<'s>,
    /// From the first set to the second, times the gap (m); it points back where the cores overlap.
    gap: Vector,
    /// Points above one another may be this far (m) from each other along the planes.
    resolution: f64,
}

/// A polygon or a segment.
struct FlatSet<'s> {
    points: &'s [Point],
    sides: Vec<Side>,
}

/// A half-space along an edge that contains the polygon.
struct Side {
    /// Unit vector in the plane of the polygon, away from it.
    outward: Vector,
    /// Largest height (m) of a point of the polygon along that vector.
    height: f64,
}

impl<'s> FacingSets<'s> {
    /// Sets of points of two cores; `gap` (m) is from the plane of the first set to that of the second.
    pub fn new([a, b]: [&'s SupportSet; 2], gap: Vector, resolution: f64) -> Self {
        let [a, b] = [a, b].map(|set| FlatSet::new(set.points()));
        Self { a, b, gap, resolution }
    }

    /// Passes the extreme points of the overlap: corners of either polygon above the other one, and where edges cross. Ends early when
    /// `visit` returns false.
    pub fn each_extreme_pair(&self, mut visit: impl FnMut(PointPair) -> bool) {
        for p in self.a.points {
            let above = p + self.gap;
            let q = self.b.point_within(self.resolution, &above);
            if q.is_some_and(|q| !visit([*p, q])) {
                return;
            }
        }
        for q in self.b.points {
            let below = q - self.gap;
            let p = self.a.point_within(self.resolution, &below);
            if p.is_some_and(|p| !visit([p, *q])) {
                return;
            }
        }
        for e in edges(self.a.points) {
            if self.b.is_beyond(self.resolution, &e.map(|p| p + self.gap)) {
                continue;
            }
            for f in edges(self.b.points) {
                let [p, below] = nearest_on_segments(&e, &f.map(|q| q - self.gap));
                let are_one = nalgebra::distance(&p, &below) <= self.resolution;
                if are_one && !visit([p, below + self.gap]) {
                    return;
                }
            }
        }
    }
}

impl<'s> FlatSet<'s> {
    fn new(points: &'s [Point]) -> Self {
        let from = points.first().copied().unwrap_or_else(Point::origin);
        let area: Vector = points.windows(2).map(|edge| (edge[0] - from).cross(&(edge[1] - from))).sum();
        let side = |[p, q]: [Point; 2]| {
            let outward = (q - p).cross(&area).try_normalize(0.0)?;
            let heights = points.iter().map(|p| p.coords.dot(&outward));
            Some(Side { outward, height: heights.fold(f64::NEG_INFINITY, f64::greater) })
        };
        Self { points, sides: edges(points).filter_map(side).collect() }
    }

    /// The point nearest to `x`, unless it is farther away than `distance` (m).
    fn point_within(&self, distance: f64, x: &Point) -> Option<Point> {
        if self.is_beyond(distance, std::slice::from_ref(x)) {
            return None;
        }
        Some(nearest_on_polygon(self.points, x)).filter(|p| nalgebra::distance(p, x) <= distance)
    }

    /// True if the plane of a side separates the polygon by more than `distance` (m) from all these points. False does not
    /// say that it is nearer.
    fn is_beyond(&self, distance: f64, points: &[Point]) -> bool {
        let is_outside = |side: &Side, x: &Point| x.coords.dot(&side.outward) > side.height + distance;
        self.sides.iter().any(|side| points.iter().all(|x| is_outside(side, x)))
    }
}

/// The edges of a polygon; the only one of a segment.
fn edges(polygon: &[Point]) -> impl Iterator<Item = [Point; 2]> {
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
