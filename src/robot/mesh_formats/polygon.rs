//! Polygons to triangles.

use crate::math::{Point, Vector};

/// Most corners of a polygon that is not convex: ear clipping takes quadratic time, and cubic time at worst.
const MOST_CONCAVE_CORNERS: usize = 2_000;

/// The corners as triangles, by their place in `corners`: a fan when the polygon is convex, ear clipping when it is not
/// (Meisters 1975), so that no triangle leaves the polygon. `n` corners give `n - 2` triangles.
///
/// A polygon that is not flat is judged by its projection along Newell's normal; one that crosses itself has no
/// triangulation, and what remains of it when no ear is left becomes a fan.
///
/// # Errors
/// When there are fewer than three corners, or far too many.
pub(super) fn triangulate(corners: &[Point]) -> Result<Vec<[usize; 3]>, &'static str> {
    match corners.len() {
        0..3 => Err("a polygon has fewer than three corners"),
        3 => Ok(vec![[0, 1, 2]]),
        count => {
            let flat = projected(corners);
            let order: Vec<usize> = (0..count).collect();
            if is_convex(&flat) {
                Ok(fan(&order).collect())
            } else if count > MOST_CONCAVE_CORNERS {
                Err("a polygon that is not convex has more than 2000 corners")
            } else {
                Ok(clip_ears(&flat, order))
            }
        }
    }
}

fn fan(order: &[usize]) -> impl Iterator<Item = [usize; 3]> {
    order.windows(2).skip(1).map(|pair| [order[0], pair[0], pair[1]])
}

/// The corners in the plane of the two axes that Newell's normal is farthest from, so turned that they go round
/// counter-clockwise.
fn projected(corners: &[Point]) -> Vec<[f64; 2]> {
    let normal: Vector = corners
        .iter()
        .zip(corners.iter().cycle().skip(1))
        .map(|(p, q)| (p - corners[0]).cross(&(q - corners[0])))
        .sum();
    let axis = normal.iamax();
    let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        std::mem::swap(&mut u, &mut v);
    }
    corners.iter().map(|p| [p[u], p[v]]).collect()
}

/// Twice the signed area of a triangle.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether a fan around the first corner covers the polygon once: no fan triangle and no corner turns back.
fn is_convex(flat: &[[f64; 2]]) -> bool {
    let n = flat.len();
    (1..n - 1).all(|i| turn(flat[0], flat[i], flat[i + 1]) >= 0.0)
        && (0..n).all(|i| turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0)
}

fn clip_ears(flat: &[[f64; 2]], mut order: Vec<usize>) -> Vec<[usize; 3]> {
    let mut triangles = Vec::with_capacity(order.len() - 2);
    let mut start = 0;
    while order.len() > 3 {
        let n = order.len();
        // search on from the last ear, so that ears are cut all round and not as slivers at one corner
        let Some(ear) = (0..n).map(|i| (start + i) % n).find(|&i| is_ear(flat, &order, i)) else {
            break;
        };
        triangles.push([order[(ear + n - 1) % n], order[ear], order[(ear + 1) % n]]);
        order.remove(ear);
        start = ear + 1;
    }
    triangles.extend(fan(&order));
    triangles
}

fn is_ear(flat: &[[f64; 2]], order: &[usize], i: usize) -> bool {
    let n = order.len();
    let [a, b, c] = [order[(i + n - 1) % n], order[i], order[(i + 1) % n]].map(|k| flat[k]);
    let inside = |p: [f64; 2]| {
        p != a && p != b && p != c && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
    };
    turn(a, b, c) >= 0.0 && !order.iter().any(|&k| inside(flat[k]))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn area(corners: &[Point], triangles: &[[usize; 3]]) -> f64 {
        let size = |&[a, b, c]: &[usize; 3]| {
            (corners[b] - corners[a]).cross(&(corners[c] - corners[a])).norm() / 2.0
        };
        triangles.iter().map(size).sum()
    }

    /// An L of area 3 whose notch a fan from corner 0 would fill.
    fn l_shape() -> Vec<Point> {
        [[2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0], [0.0, 0.0]]
            .map(|[x, y]| Point::new(0.5, x, y))
            .to_vec()
    }

    #[test]
    fn a_concave_polygon_keeps_its_area_whichever_corner_is_first() {
        for reversed in [false, true] {
            let mut corners = l_shape();
            if reversed {
                corners.reverse();
            }
            for _ in 0..corners.len() {
                corners.rotate_left(1);
                let triangles = triangulate(&corners).unwrap();
                assert_eq!(triangles.len(), 4);
                assert!((area(&corners, &triangles) - 3.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_winding_is_kept() {
        let corners = l_shape();
        for [a, b, c] in triangulate(&corners).unwrap() {
            assert!((corners[b] - corners[a]).cross(&(corners[c] - corners[a])).x >= 0.0);
        }
    }

    #[test]
    fn a_circle_is_a_fan() {
        let corners: Vec<Point> = (0..1000)
            .map(|i| (f64::from(i) / 1000.0 * std::f64::consts::TAU).sin_cos())
            .map(|(s, c)| Point::new(c, s, 0.0))
            .collect();
        assert_eq!(triangulate(&corners).unwrap().len(), 998);
    }

    proptest! {
        #[test]
        fn any_corners_give_n_minus_two_triangles(
            points in prop::collection::vec(prop::array::uniform3(-2i8..3), 3..12)
        ) {
            let corners: Vec<Point> = points.iter().map(|p| Point::from(p.map(f64::from))).collect();
            prop_assert_eq!(triangulate(&corners).unwrap().len(), corners.len() - 2);
        }
    }
}
