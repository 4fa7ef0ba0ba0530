//! Points of two bodies that are near each other: wherever the bodies move, they are at most as far apart as these points.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Point;
use clearance_proximity::Separation;

use super::posed_pair::PosedPair;

/// Rounding error (relative to the coordinates used) allowed for points that are kept.
const POINT_ROUNDING: f64 = 1e-13;

/// A point of each body, in the frame of that body.
#[derive(Clone, Copy, Debug)]
pub struct NearPoints([Point; 2]);

impl NearPoints {
    /// The witness points of a pair.
    pub fn of(pair: &PosedPair, found: &Separation) -> Self {
        let [on_a, on_b] = found.witness_points;
        Self([on_a, &pair.pose_ab.inverse() * on_b])
    }

    /// The points at the poses of a pair.
    pub fn at(&self, pair: &PosedPair) -> Separation {
        let [on_a, on_b] = self.0;
        let on_b = &pair.pose_ab * on_b;
        Separation { distance: nalgebra::distance(&on_a, &on_b), witness_points: [on_a, on_b] }
    }
}

/// Search limit (m) that the bodies' distance hardly exceeds, from points at the distance `near`. Points reported next
/// to contact may lie slightly off their bodies, so a search within this limit may find nothing.
pub fn hardly_less_than(near: &Separation) -> f64 {
    let reach: f64 = near.witness_points.iter().map(|point| point.coords.abs().sum()).sum();
    near.distance + POINT_ROUNDING * reach + CONTACT_DISTANCE
}
