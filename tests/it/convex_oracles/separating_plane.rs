//! Test oracle: separating plane with the widest gap between two point sets, by a linear program in four variables.
//!
//! Maximise the gap t under `n · (b - a) >= t` for all points a and b, with every coordinate of n between -1 and 1. The optimum is the
//! distance in the sum norm: |x| + |y| + |z| is at most n · (x, y, z) for the best such n. The distance in space is at most as long, and
//! at least 1/√3 of it.

use clearance::geometry::math::{Point, Vector};

use super::linear_program::{HalfSpace, maximise};
use crate::random::Random;

/// Number of orders in which the constraints are tried; rounding may leave no solution in one of them.
const MOST_ORDERS: usize = 5;

/// The widest gap between two point sets.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// Distance (m) in the sum norm; zero if no plane separates the sets strictly.
    pub sum_norm: f64,
    /// Distance (m) of two parallel planes that have the sets on either side. Computed from the points: not larger than
    /// the distance of the sets, even if the program were solved wrongly.
    pub between_planes: f64,
}

/// The planes with the widest gap between the convex hulls of two point sets.
pub fn widest_gap(a: &[Point], b: &[Point], random: &mut Random) -> Gap {
    let largest =
        a.iter().flat_map(|p| b.iter().map(move |q| (q - p).amax())).fold(f64::MIN_POSITIVE, f64::max);
    let mut constraints = vec![];
    for p in a {
        for q in b {
            let along = (q - p) / largest;
            constraints.push(HalfSpace { normal: vec![-along.x, -along.y, -along.z, 1.0], bound: 0.0 });
        }
    }
    let solved = (0..MOST_ORDERS)
        .find_map(|_| maximise(&[0.0, 0.0, 0.0, 1.0], &[1.0, 1.0, 1.0, 4.0], constraints.clone(), random))
        .expect("no gap is always a solution");
    let normal = Vector::new(solved[0], solved[1], solved[2]);
    let gap = gap_along(a, b, &normal);
    let sum_norm = (solved[3] * largest).max(0.0);
    assert!((gap - solved[3] * largest).abs() <= 1e-11 * largest, "{gap} {solved:?} {largest}");
    Gap { sum_norm, between_planes: gap.max(0.0) / normal.norm().max(f64::MIN_POSITIVE) }
}

/// How far (in units of the direction's length) the second set begins behind the end of the first.
pub fn gap_along(a: &[Point], b: &[Point], direction: &Vector) -> f64 {
    let end = a.iter().map(|p| direction.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max);
    let start = b.iter().map(|q| direction.dot(&q.coords)).fold(f64::INFINITY, f64::min);
    start - end
}

#[cfg(test)]
mod tests {
    use super::super::Polytope;
    use super::*;
    use clearance::geometry::math::Pose;

    fn moved(points: &[Point], by: Vector) -> Vec<Point> {
        points.iter().map(|p| p + by).collect()
    }

    #[test]
    fn two_cubes_are_apart_by_a_known_distance() {
        let mut random = Random::new(1);
        let cube = Polytope::cuboid([0.5; 3]).vertices;
        for (by, truth) in [
            (Vector::new(1.5, 0.0, 0.0), 0.5),
            (Vector::new(1.5, 1.25, 0.0), 0.75),
            (Vector::new(-1.5, 1.25, 2.0), 1.75),
            (Vector::new(1.0, 0.3, 0.2), 0.0),  // faces touch
            (Vector::new(1.0, 1.0, 0.0), 0.0),  // edges touch
            (Vector::new(1.0, -1.0, 1.0), 0.0), // corners touch
            (Vector::new(0.9, 0.2, 0.1), 0.0),
            (Vector::zeros(), 0.0),
        ] {
            let found = widest_gap(&cube, &moved(&cube, by), &mut random);
            assert!((found.sum_norm - truth).abs() < 1e-13, "{by:?} {found:?}");
            assert!(found.between_planes <= truth && found.between_planes >= truth / 3.0_f64.sqrt() - 1e-13);
        }
    }

    #[test]
    fn points_and_segments_are_sets_too() {
        let mut random = Random::new(2);
        let line = [Point::new(-1.0, 0.0, 0.0), Point::new(1.0, 0.0, 0.0)];
        let crossing = [Point::new(0.0, -1.0, 0.0), Point::new(0.0, 1.0, 0.0)];
        assert_eq!(widest_gap(&line, &crossing, &mut random).sum_norm, 0.0);
        let above = moved(&crossing, Vector::new(0.0, 0.0, 0.25));
        let found = widest_gap(&line, &above, &mut random);
        assert!((found.sum_norm - 0.25).abs() < 1e-15 && (found.between_planes - 0.25).abs() < 1e-15);
        assert!((widest_gap(&line, &[Point::new(3.0, 0.0, 0.5)], &mut random).sum_norm - 2.5).abs() < 1e-14);
    }

    #[test]
    fn a_turned_set_is_separated_by_a_turned_plane() {
        let mut random = Random::new(3);
        let cube = Polytope::cuboid([0.5; 3]);
        for _ in 0..50 {
            let pose = Pose::from_parts(nalgebra::one(), random.rotation());
            // no other point of the second cube is as near as its face
            let place = |p: &Vec<Point>, by: f64| -> Vec<Point> {
                p.iter().map(|v| pose * (v + Vector::new(0.0, 0.0, by))).collect()
            };
            let apart = widest_gap(&place(&cube.vertices, 0.0), &place(&cube.vertices, 1.001), &mut random);
            assert!(
                apart.sum_norm > 0.001 && apart.between_planes > 0.0 && apart.between_planes < 0.001 + 1e-13
            );
            let overlap = widest_gap(&place(&cube.vertices, 0.0), &place(&cube.vertices, 0.999), &mut random);
            assert!(overlap.sum_norm < 1e-13, "{overlap:?}");
        }
    }
}
