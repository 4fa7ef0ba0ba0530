//! Ball in a link frame: the element of sphere covers, with a point test.

use clearance_geometry::math::Point;

/// Allowance (m) for the rounding of distances and coordinates in proofs: many times the rounding of f64 for coordinates up to 1000 m.
pub const ROUNDING: f64 = 1e-9;

/// A ball in the link frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre (m).
    pub centre: Point,
    /// Radius (m).
    pub radius: f64,
}

impl Ball {
    /// Distance (m) by which a point is inside of the ball, negative outside.
    #[inline]
    pub fn slack(&self, p: &Point) -> f64 {
        self.radius - (p - self.centre).norm()
    }

    /// True if a point is inside by at least `margin` (m).
    #[inline]
    pub fn contains(&self, p: &Point, margin: f64) -> bool {
        let radius = self.radius - margin;
        radius >= 0.0 && (p - self.centre).norm_squared() <= radius * radius
    }
}
