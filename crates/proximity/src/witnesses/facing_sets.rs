//! Extreme point pairs in the overlap of two facing support sets of convex cores.

use clearance_geometry::math::{Point, Vector};
use clearance_geometry::{PointPair, Triangle, nearest_on_segment, nearest_on_segments, nearest_pair};

/// Support sets of two cores along a normal, with at least two points each, and the gap between their planes.
pub(crate) struct FacingSets<'s> {
    pub a: &'s [Point],
    pub b: &'s [Point],
    /// From the first set to the second, times the gap (m); it points back where the cores overlap.
    pub gap: Vector,
    /// Points above one another may be this far (m) from each other along the planes.
    pub resolution: f64,
}

impl FacingSets<'_> {
    /// Passes the extreme points of the overlap: corners of either polygon above the other one, and where edges cross. Ends early when
    /// `visit` returns false.
    pub fn each_extreme_pair(&self, mut visit: impl FnMut(PointPair) -> bool) {
        for p in self.a {
            let above = p + self.gap;
            let q = nearest_on_polygon(self.b, &above);
            if self.are_one(&above, &q) && !visit([*p, q]) {
                return;
            }
        }
        for q in self.b {
            let below = q - self.gap;
            let p = nearest_on_polygon(self.a, &below);
            if self.are_one(&below, &p) && !visit([p, *q]) {
                return;
            }
        }
        for e in edges(self.a) {
            for f in edges(self.b) {
                let [p, below] = nearest_on_segments(&e, &f.map(|q| q - self.gap));
                if self.are_one(&p, &below) && !visit([p, below + self.gap]) {
                    return;
                }
            }
        }
    }

    fn are_one(&self, p: &Point, q: &Point) -> bool {
        nalgebra::distance(p, q) <= self.resolution
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
