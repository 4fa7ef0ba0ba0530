//! Result of a distance computation: the distance and the witness points.

use clearance_geometry::PointPair;
use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Point, Vector};

/// Distance (m) of two elements or bodies, and their nearest points. If they touch, the distance is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Distance (m); 0 if they touch.
    pub distance: f64,
    /// In the frame of the first body, first on it.
    pub witness_points: PointPair,
}

impl Separation {
    /// Unit vector from the first witness point to the second; zero if they coincide.
    #[inline]
    pub(crate) fn direction(&self) -> Vector {
        let [p, q] = self.witness_points;
        (q - p).try_normalize(0.0).unwrap_or_else(Vector::zeros)
    }

    #[inline]
    pub(crate) fn touching_at(point: Point) -> Self {
        Self { distance: 0.0, witness_points: [point, point] }
    }

    #[inline]
    pub(crate) fn of(witness_points: PointPair) -> Self {
        let distance = nalgebra::distance(&witness_points[0], &witness_points[1]);
        Self { distance: if distance <= CONTACT_DISTANCE { 0.0 } else { distance }, witness_points }
    }
}
