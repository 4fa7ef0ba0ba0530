//! Faces of a mesh that pass through each other.

use clearance_geometry::Triangle;
use clearance_geometry::math::Point;

use crate::triangle_tree::TriangleTree;
use crate::welded_mesh::WeldedMesh;

/// Number of pairs after which counting ends.
const MOST_COUNTED: usize = 10_000;

/// Pairs of crossing faces.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Crossings {
    pub count: usize,
    /// A common point of the first pair (m).
    pub point: Option<Point>,
    /// True if counting ended early.
    pub is_limited: bool,
}

/// Finds pairs of faces of which an edge of one passes through the inside of the other. The signs are exact (Shewchuk 1997), so faces that
/// only share an edge or a vertex are never counted. Faces that overlap in one plane, or cross at an edge exactly, are not counted either.
pub(crate) fn find(welded: &WeldedMesh, faces: &[usize]) -> Crossings {
    let tree = TriangleTree::new(faces.iter().map(|&face| welded.triangle(face)).collect());
    let mut crossings = Crossings::default();
    tree.overlapping_pairs(|s, t| {
        let [first, second] = [s, t].map(|i| &tree.triangles()[i as usize]);
        if let Some(point) = crossing(first, second) {
            crossings.count += 1;
            crossings.point.get_or_insert(point);
            crossings.is_limited = crossings.count >= MOST_COUNTED;
        }
        !crossings.is_limited
    });
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

/// True if no edge between corners with these heights passes from one side to the other.
fn is_one_sided(heights: &[f64; 3]) -> bool {
    heights.iter().all(|h| *h >= 0.0) || heights.iter().all(|h| *h <= 0.0)
}

/// The point where an edge of `by`, whose corners have these heights over `face`, passes through the inside of `face`.
fn pierced(face: &Triangle, by: &Triangle, heights: [f64; 3]) -> Option<Point> {
    by.edges().into_iter().enumerate().find_map(|(i, [p, q])| {
        let (from, to) = (heights[i], heights[(i + 1) % 3]);
        if !((from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0)) {
            return None;
        }
        let sides = face.edges().map(|[a, b]| orientation(&Triangle { a: p, b: q, c: a }, &b));
        let is_inside = sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0);
        is_inside.then(|| p + (q - p) * (from / (from - to)))
    })
}

/// Positive, negative or zero as `p` lies below, above or on the plane of the triangle; the sign is exact.
fn orientation(Triangle { a, b, c }: &Triangle, p: &Point) -> f64 {
    let coordinates = |p: &Point| robust::Coord3D { x: p.x, y: p.y, z: p.z };
    robust::orient3d(coordinates(a), coordinates(b), coordinates(c), coordinates(p))
}
