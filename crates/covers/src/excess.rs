//! Proven bounds on the excess of a shape over a solid: the largest distance of the shape's points from the solid.

use clearance_geometry::math::{Extremes, Point, Vector};

use crate::ball::{Ball, ROUNDING};
use crate::branch_and_bound::{Accuracy, CellValue, DistanceBounds, maximise};
use crate::link_solid::LinkSolid;
use crate::search_limit::SearchLimit;

/// A convex shape whose excess is bounded.
pub trait ConvexShape {
    /// Smallest and largest corner (m) of a box around the shape.
    fn bounds(&self) -> [Point; 2];
    /// The point of the shape nearest to a point.
    fn nearest_point(&self, p: &Point) -> Point;
}

impl ConvexShape for Ball {
    fn bounds(&self) -> [Point; 2] {
        let reach = Vector::repeat(self.radius);
        [self.centre - reach, self.centre + reach]
    }

    fn nearest_point(&self, p: &Point) -> Point {
        let way = p - self.centre;
        let distance = way.norm();
        if distance <= self.radius { *p } else { self.centre + way * (self.radius / distance) }
    }
}

/// Bounds on the excess of a ball. A ball of radius r around a point at depth e reaches at most r − e out.
pub fn ball_excess(
    solid: &LinkSolid,
    ball: &Ball,
    accuracy: &Accuracy,
    limit: &SearchLimit,
) -> DistanceBounds {
    let simple = (ball.radius + solid.signed_distance(&ball.centre) + ROUNDING).greater(0.0);
    excess(solid, ball, (accuracy, limit), simple)
}

/// Bounds on the excess of a convex shape that is known to be at most `known` (m).
pub fn excess(
    solid: &LinkSolid,
    shape: &impl ConvexShape,
    until: (&Accuracy, &SearchLimit),
    known: f64,
) -> DistanceBounds {
    maximise(shape.bounds(), known, until, |centre, reach, around| {
        let inner = shape.nearest_point(centre);
        // the projection on a convex shape brings points not farther apart: the shape's points in the cell are within `reach` of `inner`
        if (inner - centre).norm() > reach + ROUNDING {
            return None;
        }
        let signed = match around {
            Some(around) => solid.signed_distance_near(&inner, around),
            None => solid.signed_distance(&inner),
        };
        let upper = signed + reach + ROUNDING;
        Some(CellValue { upper, sample: Some((inner, signed.greater(0.0))), known: (inner, signed) })
    })
}
