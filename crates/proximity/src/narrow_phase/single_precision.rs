//! Rounding of tests in f32: errors of coordinates, thresholds and directions.

use clearance_geometry::constants::{CONTACT_DISTANCE, TRIANGLE_SHARE};
use clearance_geometry::math::Vector;

use crate::bounding_volume::Relative;

/// The direction of a vector, of length at most one; zeros for a vector without length.
#[inline]
pub(crate) fn shortened(v: [f32; 3]) -> [f32; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let scale = if length > 1e-15 { (1.0 - 8.0 * f32::EPSILON) / length } else { 0.0 };
    v.map(|c| c * scale)
}

/// A unit vector in f32, of length at most one.
#[allow(clippy::cast_possible_truncation)] // rounding is meant
#[inline]
pub(crate) fn shortened_to_f32(n: &Vector) -> [f32; 3] {
    let n = n * (1.0 - f64::from(8.0 * f32::EPSILON));
    [n.x as f32, n.y as f32, n.z as f32]
}

/// An f32 above `x`, or equal to it if `x` is infinite.
#[allow(clippy::cast_possible_truncation)] // rounded up right after
#[inline]
pub(crate) fn f32_above(x: f64) -> f32 {
    (x as f32).next_up()
}

/// Error (m) of f32 coordinates of triangles, plus the contact distance.
#[allow(clippy::cast_possible_truncation)] // rounded up
#[inline]
pub(crate) fn triangle_slack(relative: &Relative) -> f32 {
    TRIANGLE_SHARE * relative.slack + (CONTACT_DISTANCE as f32).next_up()
}

/// A threshold for elements with balls of a given radius (m) around them; rounded up.
#[inline]
pub(crate) fn widened(threshold: f32, radius: f64) -> f32 {
    if radius == 0.0 || threshold == f32::NEG_INFINITY {
        return threshold;
    }
    f32_above(f64::from(threshold) + radius)
}
