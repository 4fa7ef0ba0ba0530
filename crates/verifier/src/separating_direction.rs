//! Searches for a direction along which two convex elements are apart. This code need not be correct: [`gap`] evaluates its result.

use clearance_geometry::Triangle;
use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};

use super::element::{Element, gap};

/// Maximum number of search steps; round elements need about twenty.
const MOST_STEPS: usize = 200;

/// A unit direction, in the frame of `a`, along which the elements are `target` (m) apart or more, if one is found.
pub(super) fn find(a: &Element, b: &Element, pose_ab: &MatrixPose, target: f64) -> Option<Vector> {
    if let (Element::Triangle(ta), Element::Triangle(tb)) = (a, b) {
        let tb = tb.transformed(&Pose::from(pose_ab));
        return of_triangles(ta, &tb).find(|n| gap(a, b, pose_ab, n) >= target);
    }
    // the gap along n, and the point of b − a farthest against n, the balls left out
    let look = |n: &Vector| {
        let n_b = pose_ab.rotation.tr_mul(n);
        (gap(a, b, pose_ab, n), pose_ab * b.extreme(&-n_b) - a.extreme(n))
    };
    let start = pose_ab.translation.try_normalize(0.0).unwrap_or(Vector::x());
    steps(look, start, a.ball() + b.ball(), target, MOST_STEPS).filter(|n| gap(a, b, pose_ab, n) >= target)
}

/// Directions between two triangles, the likeliest first: between nearest points, which are rough where these all but touch; then
/// every one that can separate triangles.
fn of_triangles(a: &Triangle, b: &Triangle) -> impl Iterator<Item = Vector> + use<> {
    let [p, q] = a.nearest_points(b);
    let edges = |t: &Triangle| t.edges().map(|[from, to]| to - from);
    let (ea, eb) = (edges(a), edges(b));
    let all = move || {
        let faces = [ea[0].cross(&ea[1]), eb[0].cross(&eb[1])];
        let crossed = ea.into_iter().flat_map(move |e| eb.into_iter().map(move |f| e.cross(&f)));
        faces.into_iter().chain(crossed).flat_map(|n| [n, -n])
    };
    let first = std::iter::once(q - p);
    first.chain(std::iter::once(()).flat_map(move |()| all())).filter_map(|n| n.try_normalize(0.0))
}

/// The method of Gilbert, Johnson & Keerthi 1988: towards the point of b − a nearest to the origin, in the hull of at most four
/// points of it at a time. `look` gives the gap along a direction and the point of b − a farthest against it, which may be deeper
/// inside by `balls`. `None` when a and b are found to be nearer than the target, or after too many steps.
pub(super) fn steps(
    look: impl Fn(&Vector) -> (f64, Vector),
    start: Vector,
    balls: f64,
    target: f64,
    most_steps: usize,
) -> Option<Vector> {
    let (gap, mut nearest) = look(&start);
    if gap >= target {
        return Some(start);
    }
    let mut hull = [Point::from(nearest); 4];
    for _ in 0..most_steps {
        let n = nearest.try_normalize(0.0)?;
        let (gap, farthest) = look(&n);
        if gap >= target {
            return Some(n);
        }
        if nearest.norm() - balls < target {
            return None;
        }
        hull[3] = Point::from(farthest);
        (nearest, hull) = nearest_of(&hull);
    }
    None
}

/// The point of a tetrahedron that does not hold the origin which is nearest to it, and first the face that it lies on.
fn nearest_of(hull: &[Point; 4]) -> (Vector, [Point; 4]) {
    let faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]].map(|face| face.map(|i| hull[i]));
    let found = faces.map(|[a, b, c]| Triangle { a, b, c }.nearest_point(&Point::origin()).coords);
    let nearer = |i: &usize, j: &usize| found[*i].norm_squared().total_cmp(&found[*j].norm_squared());
    let best = (0..4).min_by(nearer).unwrap_or(0);
    let [a, b, c] = faces[best];
    (found[best], [a, b, c, a])
}
