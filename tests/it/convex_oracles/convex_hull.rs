//! Test helper: convex hull of few points by enumeration of planes through three points, O(n⁴).
//! A plane is a face if no point is beyond it.

use clearance::geometry::math::{Point, Vector};

/// Distance from a plane up to which a point is in it, relative to the extent of the points.
const FLAT_TOLERANCE: f64 = 1e-10;

/// The faces of the hull, each as its corners counter-clockwise seen from outside; `None` if all points are in a plane.
pub fn faces(points: &[Point]) -> Option<Vec<Vec<usize>>> {
    let distinct = distinct(points);
    let tolerance = FLAT_TOLERANCE * extent(points);
    let mut found: Vec<Vec<usize>> = vec![];
    for (i, j, k) in triples(&distinct) {
        let Some(normal) = normal_of([i, j, k].map(|v| points[v])) else { continue };
        let heights: Vec<f64> = distinct.iter().map(|v| normal.dot(&(points[*v] - points[i]))).collect();
        let in_plane: Vec<usize> = distinct
            .iter()
            .zip(&heights)
            .filter(|(_, height)| height.abs() <= tolerance)
            .map(|(v, _)| *v)
            .collect();
        if in_plane.len() == distinct.len() {
            return None;
        }
        let side = if heights.iter().all(|height| *height <= tolerance) {
            normal
        } else if heights.iter().all(|height| *height >= -tolerance) {
            -normal
        } else {
            continue;
        };
        let corners = outline(points, &in_plane, &side, tolerance);
        let is_known = |known: &Vec<usize>| corners.iter().all(|corner| known.contains(corner));
        if !found.iter().any(is_known) {
            found.push(corners);
        }
    }
    (found.len() >= 4).then_some(found)
}

fn triples(of: &[usize]) -> impl Iterator<Item = (usize, usize, usize)> {
    let n = of.len();
    (0..n).flat_map(move |i| (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| (of[i], of[j], of[k]))))
}

/// Numbers of the points without repetitions.
fn distinct(points: &[Point]) -> Vec<usize> {
    let tolerance = FLAT_TOLERANCE * extent(points);
    let is_new = |i: &usize| points[..*i].iter().all(|p| nalgebra::distance(p, &points[*i]) > tolerance);
    (0..points.len()).filter(is_new).collect()
}

fn extent(points: &[Point]) -> f64 {
    points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max)
}

/// Unit normal of three points; `None` if they are nearly on a line.
fn normal_of([p, q, r]: [Point; 3]) -> Option<Vector> {
    let normal = (q - p).cross(&(r - p));
    let is_flat = normal.norm() <= 1e-7 * (q - p).norm() * (r - p).norm();
    (!is_flat).then(|| normal.normalize())
}

/// Corners of the convex outline of points in a plane, counter-clockwise about `normal`; points within edges are left out.
fn outline(points: &[Point], in_plane: &[usize], normal: &Vector, tolerance: f64) -> Vec<usize> {
    let is_left = |from: usize, to: usize, other: usize| {
        let along = (points[to] - points[from]).normalize();
        normal.cross(&along).dot(&(points[other] - points[from]))
    };
    // the point farthest along some direction of the plane is a corner
    let axis = normal.cross(&Vector::ith(normal.iamin(), 1.0)).normalize();
    let across = normal.cross(&axis);
    let place = |v: &usize| (axis.dot(&points[*v].coords), across.dot(&points[*v].coords));
    let first = *in_plane
        .iter()
        .max_by(|p, q| {
            let ((px, py), (qx, qy)) = (place(p), place(q));
            // of points equally far the last one: both ends of an edge are corners, its inside is not
            if (px - qx).abs() > tolerance { px.total_cmp(&qx) } else { py.total_cmp(&qy) }
        })
        .expect("a face has points");
    let mut corners = vec![first];
    loop {
        let from = *corners.last().expect("not empty");
        let mut next = usize::MAX;
        for candidate in in_plane.iter().copied().filter(|v| *v != from) {
            let farther = |v: usize| (points[v] - points[from]).norm();
            let is_better = next == usize::MAX || {
                let left = is_left(from, next, candidate);
                left < -tolerance || left <= tolerance && farther(candidate) > farther(next)
            };
            if is_better {
                next = candidate;
            }
        }
        if next == first {
            return corners;
        }
        assert!(corners.len() < in_plane.len(), "the outline closes");
        corners.push(next);
    }
}

#[test]
fn points_within_faces_and_edges_of_a_cube_are_no_corners() {
    let mut grid = vec![];
    for i in 0..27 {
        grid.push(Point::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)));
    }
    let found = faces(&grid).unwrap();
    assert_eq!(found.len(), 6);
    assert!(found.iter().all(|face| face.len() == 4), "{found:?}");
}

#[test]
fn flat_points_have_no_hull() {
    let flat: Vec<Point> = (0..9).map(|i| Point::new(f64::from(i % 3), f64::from(i / 3), 1.0)).collect();
    assert!(faces(&flat).is_none());
}
