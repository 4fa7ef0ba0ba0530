//! Search for faces of a mesh that intersect each other.

use std::cell::Cell;
use std::time::Instant;

use clearance_geometry::math::Point;
use clearance_geometry::{Triangle, WeldedMesh};

use crate::triangle_tree::TriangleTree;

/// Number of pairs after which counting ends.
const MOST_COUNTED: usize = 10_000;

/// Number of pairs of nodes or faces after which the search ends: many times those of a mesh of a million faces that has no such pair.
const MOST_TESTS: usize = 200_000_000;

/// Number of pairs of nodes between two looks at the clock.
const TESTS_PER_CLOCK: usize = 65_536;

/// Pairs of crossing faces.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Crossings {
    pub count: usize,
    /// A common point of the first pair (m).
    pub point: Option<Point>,
    /// True if counting ended early.
    pub is_limited: bool,
}

/// Work of one search.
#[derive(Debug, Default)]
struct Budget {
    tests: Cell<usize>,
    deadline: Option<Instant>,
    /// True from the last test on.
    is_spent: Cell<bool>,
}

impl Budget {
    /// Counts one test; false if it was the last one.
    fn spend(&self) -> bool {
        let tests = self.tests.get() + 1;
        self.tests.set(tests);
        let is_late = tests.is_multiple_of(TESTS_PER_CLOCK)
            && self.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        self.is_spent.set(self.is_spent.get() || is_late || tests >= MOST_TESTS);
        !self.is_spent.get()
    }
}

/// Finds pairs of faces of which an edge of one passes through the other, at its inside or at the inside of an edge. The signs are exact
/// (Shewchuk 1997), so faces that only share an edge or a vertex are never counted. Faces that overlap in one plane are not counted either.
pub(crate) fn find(welded: &WeldedMesh, faces: &[usize], deadline: Option<Instant>) -> Crossings {
    let tree = TriangleTree::new(faces.iter().map(|&face| welded.triangle(face)).collect());
    let mut crossings = Crossings::default();
    let budget = Budget { deadline, ..Budget::default() };
    let is_complete = tree.overlapping_pairs(
        || budget.spend(),
        |s, t| {
            let [first, second] = [s, t].map(|i| &tree.triangles()[i as usize]);
            if let Some(point) = crossing(first, second) {
                crossings.count += 1;
                crossings.point.get_or_insert(point);
                crossings.is_limited = crossings.count >= MOST_COUNTED;
            }
            !crossings.is_limited && budget.spend()
        },
    );
    crossings.is_limited |= !is_complete || budget.is_spent.get();
    crossings
}

fn crossing(first: &Triangle, second: &Triangle) -> Option<Point> {
    let heights = second.corners().map(|p| orientation(first, &p));
    if is_one_sided(&heights) {
        return None;
    }
    let others = first.corners().map(|p| orientation(second, &p));
    if is_one_sided(&others) {
        return None;
    }
    pierced(first, second, heights).or_else(|| pierced(second, first, others))
}

/// True if no two of these signs are opposite.
fn is_one_sided(signs: &[f64; 3]) -> bool {
    signs.iter().all(|s| *s >= 0.0) || signs.iter().all(|s| *s <= 0.0)
}

/// The point where an edge of `by`, whose corners have these heights over `face`, passes through `face`, but not through a corner: where
/// edges of neighbouring faces are split at different points, corners lie on edges.
fn pierced(face: &Triangle, by: &Triangle, heights: [f64; 3]) -> Option<Point> {
    by.edges().into_iter().enumerate().find_map(|(i, [p, q])| {
        let (from, to) = (heights[i], heights[(i + 1) % 3]);
        if !((from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0)) {
            return None;
        }
        let sides = face.edges().map(|[a, b]| orientation(&Triangle { a: p, b: q, c: a }, &b));
        let is_at_corner = sides.iter().filter(|s| **s == 0.0).count() > 1;
        let is_inside = !is_at_corner && is_one_sided(&sides);
        is_inside.then(|| p + (q - p) * (from / (from - to)))
    })
}

/// Positive, negative or zero as `p` lies below, above or on the plane of the triangle; the sign is exact.
fn orientation(Triangle { a, b, c }: &Triangle, p: &Point) -> f64 {
    let coordinates = |p: &Point| robust::Coord3D { x: p.x, y: p.y, z: p.z };
    robust::orient3d(coordinates(a), coordinates(b), coordinates(c), coordinates(p))
}
