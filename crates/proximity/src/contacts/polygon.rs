//! Convex polygons in a plane: convex hull, overlap and area, also of degenerate ones (points and segments).

use clearance_geometry::math::Extremes;

/// Coordinates (m) in the plane.
pub(super) type Flat = nalgebra::Point2<f64>;

/// Sine below which two segments count as parallel.
const PARALLEL: f64 = 1e-3;

/// Distance from the line through its neighbours below which a corner is left out, relative to the size of the polygon.
const STRAIGHT: f64 = 1e-9;

/// Corners of the convex hull, counter-clockwise (the monotone chain of Andrew 1979, *Another efficient algorithm for convex hulls in two
/// dimensions*). Two corners of points on a line, one of equal points.
pub(super) fn convex_hull(mut points: Vec<Flat>) -> Vec<Flat> {
    points.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    let size = size_of_points(&points);
    let lower = chain(points.iter(), size);
    let upper = chain(points.iter().rev(), size);
    // the ends of both chains are the same
    let inner = upper.get(1..upper.len().saturating_sub(1)).unwrap_or(&[]);
    let mut corners: Vec<Flat> = lower.iter().chain(inner).copied().collect();
    if corners.len() == 2 && nalgebra::distance(&corners[0], &corners[1]) <= STRAIGHT * size {
        corners.pop();
    }
    corners
}

/// Half of a hull: from the first to the last point, turning left at each corner.
fn chain<'p>(points: impl Iterator<Item = &'p Flat>, size: f64) -> Vec<Flat> {
    let mut corners: Vec<Flat> = Vec::new();
    for p in points {
        while let [.., a, b] = corners[..]
            && (side([a, b], p) <= STRAIGHT * size * nalgebra::distance(&a, p))
        {
            corners.pop();
        }
        if corners.last() != Some(p) {
            corners.push(*p);
        }
    }
    corners
}

/// Largest coordinate difference (m).
fn size_of_points(points: &[Flat]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    points.iter().map(|p| (p - first).amax()).fold(0.0, f64::greater)
}

/// Twice the area of the triangle of a segment and a point: positive to the left of the segment.
fn side([a, b]: [Flat; 2], p: &Flat) -> f64 {
    (b - a).perp(&(p - a))
}

/// Corners of what two convex polygons have in common; corners are counter-clockwise. A segment or point and a point have the second point
/// in common, and parallel segments the part of the first that is beside the second, since these are exact only up to rounding.
pub(super) fn overlap(ours: &[Flat], theirs: &[Flat]) -> Vec<Flat> {
    match (ours, theirs) {
        ([], _) | (_, []) => Vec::new(),
        ([p], other) | (other, [p]) if holds(other, p) => vec![*p],
        ([_], _) | (_, [_]) => Vec::new(),
        ([a, b], [c, d]) => common_of_segments([*a, *b], [*c, *d]),
        (_, [_, _]) => clipped(theirs, ours),
        _ => clipped(ours, theirs),
    }
}

/// Whether a polygon holds a point, up to rounding; points and segments hold every point.
fn holds(polygon: &[Flat], p: &Flat) -> bool {
    let slack = STRAIGHT * size_of_points(polygon);
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    polygon.len() < 3
        || edges.into_iter().all(|(a, b)| side([*a, *b], p) >= -slack * nalgebra::distance(a, b))
}

fn common_of_segments([a, b]: [Flat; 2], [c, d]: [Flat; 2]) -> Vec<Flat> {
    let (along, other) = (b - a, d - c);
    let sine = along.perp(&other);
    if sine.abs() <= PARALLEL * along.norm() * other.norm() {
        let share = |p: Flat| along.dot(&(p - a)) / along.norm_squared();
        let (from, to) = (share(c).lesser(share(d)).greater(0.0), share(c).greater(share(d)).lesser(1.0));
        return if from <= to { vec![a + along * from, a + along * to] } else { Vec::new() };
    }
    let (t, u) = ((c - a).perp(&other) / sine, (c - a).perp(&along) / sine);
    let is_common = [t, u].iter().all(|share| (0.0..=1.0).contains(share));
    if is_common { vec![a + along * t] } else { Vec::new() }
}

/// The part of a polygon or segment inside another polygon (Sutherland & Hodgman 1974, *Reentrant polygon clipping*).
fn clipped(subject: &[Flat], window: &[Flat]) -> Vec<Flat> {
    let mut kept = subject.to_vec();
    for (a, b) in window.iter().zip(window.iter().cycle().skip(1)) {
        let before = std::mem::take(&mut kept);
        let height = |p: &Flat| side([*a, *b], p);
        for (i, p) in before.iter().enumerate() {
            let next = &before[(i + 1) % before.len()];
            let [from, to] = [height(p), height(next)];
            if from >= 0.0 {
                kept.push(*p);
            }
            if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                kept.push(p + (next - p) * (from / (from - to)));
            }
        }
    }
    kept.dedup();
    kept
}

/// Area (m²) of a polygon with counter-clockwise corners.
pub(super) fn area(corners: &[Flat]) -> f64 {
    let Some(first) = corners.first() else { return 0.0 };
    corners.windows(2).map(|edge| 0.5 * side([*first, edge[0]], &edge[1])).sum::<f64>().greater(0.0)
}

/// The mean of the corners.
#[allow(clippy::cast_precision_loss)] // few corners
pub(super) fn middle(corners: &[Flat]) -> Flat {
    Flat::from(corners.iter().map(|p| p.coords).sum::<nalgebra::Vector2<f64>>() / corners.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::testing::Random;

    fn flat([x, y]: [f64; 2]) -> Flat {
        Flat::new(x, y)
    }

    fn random_hull(random: &mut Random, count: usize) -> Vec<Flat> {
        let [x, y] = [random.within(0.5), random.within(0.5)];
        convex_hull((0..count).map(|_| flat([x + random.within(1.0), y + random.within(1.0)])).collect())
    }

    fn is_inside(polygon: &[Flat], p: &Flat, slack: f64) -> bool {
        (0..polygon.len()).all(|i| side([polygon[i], polygon[(i + 1) % polygon.len()]], p) >= -slack)
    }

    #[test]
    fn a_hull_holds_its_points_and_is_convex() {
        let mut random = Random::new(1);
        for count in 3..40 {
            let points: Vec<Flat> =
                (0..count).map(|_| flat([random.within(1.0), random.within(1.0)])).collect();
            let hull = convex_hull(points.clone());
            assert!(
                points.iter().all(|p| is_inside(&hull, p, 1e-8)) && area(&hull) > 0.0,
                "{points:?} {hull:?}"
            );
            assert!(hull.iter().all(|corner| points.contains(corner)));
        }
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.0], [1.0, 0.5], [0.5, 0.5]];
        assert_eq!(convex_hull(square.map(flat).to_vec()), [0, 1, 2, 3].map(|i| flat(square[i])));
        assert_eq!(convex_hull(vec![flat([1.0, 2.0]); 3]), [flat([1.0, 2.0])]);
        let line = [[0.0, 0.0], [3.0, 3.0], [1.0, 1.0]].map(flat);
        assert_eq!(convex_hull(line.to_vec()), [line[0], line[1]]);
        assert_eq!(convex_hull(Vec::new()), []);
    }

    #[test]
    fn an_overlap_is_in_both_and_as_large_as_samples_show() {
        let mut random = Random::new(2);
        for _ in 0..200 {
            let [a, b] = [random_hull(&mut random, 7), random_hull(&mut random, 5)];
            let common = overlap(&a, &b);
            assert!(common.iter().all(|p| is_inside(&a, p, 1e-12) && is_inside(&b, p, 1e-12)), "{a:?} {b:?}");
            let count = 4000;
            let samples = (0..count).map(|_| flat([random.within(2.0), random.within(2.0)]));
            let inside = samples.filter(|p| is_inside(&a, p, 0.0) && is_inside(&b, p, 0.0)).count();
            #[allow(clippy::cast_precision_loss)] // small numbers
            let sampled = 16.0 * inside as f64 / f64::from(count);
            assert!((area(&common) - sampled).abs() < 0.25, "{} {sampled}", area(&common));
        }
    }

    #[test]
    fn segments_and_points_overlap() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(flat);
        let across = [[-1.0, 1.0], [3.0, 1.0]].map(flat);
        for common in [overlap(&square, &across), overlap(&across, &square)] {
            assert_eq!(convex_hull(common), [flat([0.0, 1.0]), flat([2.0, 1.0])]);
        }
        let beside = [[1.0, 1.0], [5.0, 1.0]].map(flat);
        assert_eq!(overlap(&across, &beside), [flat([1.0, 1.0]), flat([3.0, 1.0])]);
        let crossing = [[1.0, 0.0], [1.0, 4.0]].map(flat);
        assert_eq!(overlap(&across, &crossing), [flat([1.0, 1.0])]);
        assert_eq!(overlap(&across, &[[9.0, 0.0], [9.0, 4.0]].map(flat)), []);
        assert_eq!(overlap(&square, &[flat([1.0, 1.0])]), [flat([1.0, 1.0])]);
        assert_eq!(overlap(&[flat([3.0, 1.0])], &square), []);
    }
}
