//! Nearest points of curved cores, as exact as rounding allows. A search by support points ends when the distance is exact; the points
//! may then be off sideways by the square root of its error.

use clearance_geometry::PointPair;
use clearance_geometry::math::{MatrixPose, Point, Vector};

use crate::elements::CoreShape;

/// Number of steps; without tangential surfaces, a few suffice.
const MOST_STEPS: usize = 40;

/// Length of a step, relative to the coordinates, below which points are exact.
const ROUNDING: f64 = 1e-15;

/// Two cores in one frame that are apart.
pub(super) struct PlacedCores<'c> {
    pub cores: [&'c CoreShape; 2],
    pub poses: [&'c MatrixPose; 2],
}

impl PlacedCores<'_> {
    /// True if the nearest points come from a search by support points.
    #[inline]
    pub fn are_searched(&self) -> bool {
        use CoreShape::{Point, Segment, Triangle};
        let is_simple = |core: &CoreShape| matches!(core, Point | Segment(_) | Triangle(_));
        let [a, b] = self.cores;
        let is_direct = matches!((a, b), (Point, _) | (_, Point)) || (is_simple(a) && is_simple(b));
        !is_direct
    }

    /// Exact nearest points, from approximate ones.
    ///
    /// Alternating projections converge to nearest points of convex sets (Cheney & Goldstein 1959). Each point is the projection of a
    /// combination of the last two, such that the last two steps would cancel (Anderson 1965, with one previous step).
    pub fn nearest_points(&self, near: PointPair) -> PointPair {
        let mut best = near;
        let (mut q, mut last): (Point, Option<(Point, Vector)>) = (near[1], None);
        for _ in 0..MOST_STEPS {
            let p = self.projection(0, &q);
            let moved = self.projection(1, &p);
            let step = moved - q;
            if nalgebra::distance_squared(&p, &moved) <= nalgebra::distance_squared(&best[0], &best[1]) {
                best = [p, moved];
            }
            if step.amax() <= ROUNDING * (1.0 + q.coords.amax()) {
                break;
            }
            let next =
                last.map_or(moved, |(before, step_before)| cancelling(&moved, &step, &before, &step_before));
            last = Some((moved, step));
            q = next;
        }
        best
    }

    fn projection(&self, side: usize, p: &Point) -> Point {
        let MatrixPose { rotation, translation } = self.poses[side];
        let local = Point::from(rotation.tr_mul(&(p.coords - translation)));
        self.poses[side] * self.cores[side].nearest_point(&local)
    }
}

/// The combination of the last two points whose steps cancel, if it exists.
fn cancelling(moved: &Point, step: &Vector, before: &Point, step_before: &Vector) -> Point {
    let change = step - step_before;
    let squared = change.norm_squared();
    let share = step.dot(&change) / squared;
    if share.is_finite() { moved - (moved - before) * share } else { *moved }
}
