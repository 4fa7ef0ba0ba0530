//! Triangulation of polygons.

use clearance_geometry::math::{Extremes, Point, Vector};

/// Maximum number of comparisons of an ear with a corner in one file, which take a second or two: ear clipping takes quadratic time, and
/// cubic time in the worst case.
const MOST_COMPARISONS: usize = 2_000_000_000;

/// Triangulates the polygons of one file, with a limit on their total time.
#[derive(Debug)]
pub(super) struct Triangulator {
    comparisons_left: usize,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self { comparisons_left: MOST_COMPARISONS }
    }
}

impl Triangulator {
    /// The triangles of a polygon, as indices into `corners`: a fan if the polygon is convex, otherwise ear clipping (Meisters 1975), so
    /// that no triangle leaves the polygon. `n` corners give `n - 2` triangles. Triangles without area are kept, too, since corners that
    /// are collinear after projection need not be collinear in space.
    ///
    /// A polygon that is not flat is projected along Newell's normal. A polygon that crosses itself has no triangulation; if no ear is
    /// left, the rest becomes a fan.
    ///
    /// # Errors
    /// If there are fewer than three corners, or the polygons of the file take too long.
    pub fn triangulate(&mut self, corners: &[Point]) -> Result<Vec<[usize; 3]>, &'static str> {
        match corners.len() {
            0..3 => Err("a polygon has fewer than three corners"),
            3 => Ok(vec![[0, 1, 2]]),
            count => {
                let flat = projected(corners);
                if is_convex(&flat) {
                    let order: Vec<usize> = (0..count).collect();
                    Ok(fan(&order).collect())
                } else {
                    self.clip_ears(&flat)
                }
            }
        }
    }

    fn clip_ears(&mut self, flat: &[[f64; 2]]) -> Result<Vec<[usize; 3]>, &'static str> {
        let mut order: Vec<usize> = (0..flat.len()).collect();
        let mut places = flat.to_vec();
        let mut triangles = Vec::with_capacity(order.len() - 2);
        let mut start = 0;
        while order.len() > 3 {
            let n = order.len();
            // continue from the last ear, so that ears are cut all round and not as slivers at one corner
            let mut ear = None;
            for i in (0..n).map(|i| (start + i) % n) {
                if self.is_ear(&places, i)? {
                    ear = Some(i);
                    break;
                }
            }
            let Some(ear) = ear else { break };
            triangles.push([order[(ear + n - 1) % n], order[ear], order[(ear + 1) % n]]);
            order.remove(ear);
            places.remove(ear);
            start = ear + 1;
        }
        triangles.extend(fan(&order));
        Ok(triangles)
    }

    /// True if corner `i` of the remaining polygon can be cut off: it is convex, and no other corner is in its triangle.
    fn is_ear(&mut self, places: &[[f64; 2]], i: usize) -> Result<bool, &'static str> {
        let n = places.len();
        let [a, b, c] = [places[(i + n - 1) % n], places[i], places[(i + 1) % n]];
        let turns_on = turn(a, b, c) >= 0.0;
        let compared = if turns_on { n } else { 1 };
        self.comparisons_left = (self.comparisons_left.checked_sub(compared))
            .ok_or("polygons that are not convex have too many corners to be triangulated; save the mesh as triangles")?;
        if !turns_on {
            return Ok(false);
        }
        let low = [0, 1].map(|k| a[k].lesser(b[k]).lesser(c[k]));
        let high = [0, 1].map(|k| a[k].greater(b[k]).greater(c[k]));
        let is_near = |p: &[f64; 2]| p[0] >= low[0] && p[0] <= high[0] && p[1] >= low[1] && p[1] <= high[1];
        let is_inside = |p: [f64; 2]| {
            p != a && p != b && p != c && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
        };
        Ok(!places.iter().any(|p| is_near(p) && is_inside(*p)))
    }
}

fn fan(order: &[usize]) -> impl Iterator<Item = [usize; 3]> {
    order.windows(2).skip(1).map(|pair| [order[0], pair[0], pair[1]])
}

/// The corners projected to the plane of the two coordinate axes farthest from Newell's normal, in counter-clockwise order.
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

/// True if a fan around the first corner covers the polygon once: no triangle of the fan and no corner is reversed.
fn is_convex(flat: &[[f64; 2]]) -> bool {
    let n = flat.len();
    (1..n - 1).all(|i| turn(flat[0], flat[i], flat[i + 1]) >= 0.0)
        && (0..n).all(|i| turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn triangulate(corners: &[Point]) -> Result<Vec<[usize; 3]>, &'static str> {
        Triangulator::default().triangulate(corners)
    }

    /// A star with this number of rays.
    fn star(rays: u32) -> Vec<Point> {
        let corner = |i: u32| {
            let (sin, cos) = (f64::from(i) / f64::from(rays) * std::f64::consts::PI).sin_cos();
            let radius = if i.is_multiple_of(2) { 1.0 } else { 0.9 };
            Point::new(radius * cos, radius * sin, 0.0)
        };
        (0..2 * rays).map(corner).collect()
    }

    #[test]
    fn a_polygon_of_many_corners_keeps_its_area() {
        let corners = star(2500);
        let triangles = triangulate(&corners).unwrap();
        assert_eq!(triangles.len(), 4998);
        let expected: f64 = 5000.0 * 0.5 * 0.9 * (std::f64::consts::PI / 2500.0).sin();
        assert!((area(&corners, &triangles) - expected).abs() < 1e-9);
    }

    /// The limit applies to all polygons together, and convex ones cost nothing.
    #[test]
    fn the_polygons_of_a_file_share_one_bound() {
        let mut few = Triangulator { comparisons_left: 2000 };
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
        let read = (0..1000).take_while(|_| few.triangulate(&l_shape()).is_ok()).count();
        assert!((10..500).contains(&read), "{read}");
        assert!(few.triangulate(&l_shape()).unwrap_err().contains("save the mesh as triangles"));
        assert!((0..1000).all(|_| few.triangulate(&square).is_ok()));
    }

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
