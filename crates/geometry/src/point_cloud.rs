//! Point clouds, as measured by depth cameras and laser scanners.

use crate::constants::LARGEST_COORDINATE;
use crate::math::{Extremes, Point};

/// Points in the cloud's frame (m), each a solid ball. Never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct PointCloud {
    points: Vec<[f32; 3]>,
    radius: f64,
}

/// Reason why a list of points is not a valid cloud.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PointCloudError {
    /// There are no points.
    #[error("the cloud has no points")]
    NoPoints,
    /// A coordinate is not finite or larger than [`LARGEST_COORDINATE`].
    #[error("point {point} has a coordinate that is not finite or larger than {LARGEST_COORDINATE} m")]
    BadPoint {
        /// Index of the point.
        point: usize,
    },
    /// The radius is negative, not finite, or larger than [`LARGEST_COORDINATE`].
    #[error("the radius of points is {0}, but must be a number of metres from 0 to {LARGEST_COORDINATE:e}")]
    BadRadius(f64),
    /// There are more points than 31 bits can number.
    #[error("the cloud has {0} points, more than 31 bits can number")]
    TooManyPoints(usize),
}

impl PointCloud {
    /// A cloud of balls with one `radius` (m).
    pub fn new(points: Vec<[f32; 3]>, radius: f64) -> Result<Self, PointCloudError> {
        if points.is_empty() {
            return Err(PointCloudError::NoPoints);
        }
        if !(0.0..=LARGEST_COORDINATE).contains(&radius) {
            return Err(PointCloudError::BadRadius(radius));
        }
        if points.len() >> 31 != 0 {
            return Err(PointCloudError::TooManyPoints(points.len()));
        }
        match points.iter().position(|p| !is_near(p)) {
            Some(point) => Err(PointCloudError::BadPoint { point }),
            None => Ok(Self { points, radius }),
        }
    }

    /// Centres of the balls (m).
    #[must_use]
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points
    }

    /// Smallest and largest corner of the box around all balls.
    #[must_use]
    pub fn bounds(&self) -> (Point, Point) {
        let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for p in &self.points {
            for i in 0..3 {
                lo[i] = lo[i].lesser(p[i]);
                hi[i] = hi[i].greater(p[i]);
            }
        }
        let corner = |p: [f32; 3], radius: f64| Point::from(p.map(|c| f64::from(c) + radius));
        (corner(lo, -self.radius), corner(hi, self.radius))
    }

    /// Radius of every point's ball (m).
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

/// Whether all coordinates are usable.
pub(super) fn is_near(p: &[f32; 3]) -> bool {
    p.iter().all(|c| f64::from(c.abs()) <= LARGEST_COORDINATE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_named() {
        let made = PointCloud::new;
        assert_eq!(made(vec![], 0.1), Err(PointCloudError::NoPoints));
        assert_eq!(made(vec![[0.0; 3]], -0.1), Err(PointCloudError::BadRadius(-0.1)));
        assert!(matches!(made(vec![[0.0; 3]], f64::NAN), Err(PointCloudError::BadRadius(_))));
        let bad = vec![[0.0; 3], [0.0, f32::NAN, 0.0]];
        assert_eq!(made(bad, 0.0), Err(PointCloudError::BadPoint { point: 1 }));
        assert_eq!(made(vec![[0.0, 0.0, 1e9]], 0.0), Err(PointCloudError::BadPoint { point: 0 }));
    }
}
