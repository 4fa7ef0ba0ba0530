//! Planes: infinite surfaces of zero thickness.

use crate::constants::LARGEST_COORDINATE;
use crate::math::{Extremes, MatrixPose, Point, Pose, UnitVector, Vector};

/// All points p with `normal · p = offset` (m). It has two sides and no inside: an object wholly on either side does not touch it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Direction across the plane, of length one.
    pub normal: UnitVector,
    /// Signed distance (m) of the plane from the origin, along the normal.
    pub offset: f64,
}

/// Invalid coefficients of a plane.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlaneError {
    /// A coefficient is not finite.
    #[error("plane coefficients {0:?} are not all finite")]
    NotFinite([f64; 4]),
    /// The normal has no length.
    #[error("the first three plane coefficients {0:?} are all zero: give the plane's normal")]
    NoNormal([f64; 4]),
    /// The plane is farther from the origin than [`LARGEST_COORDINATE`].
    #[error("plane coefficients {0:?} put the plane more than {LARGEST_COORDINATE} m away")]
    TooFar([f64; 4]),
}

impl Plane {
    /// The plane `ax + by + cz + d = 0`, as `shape_msgs/Plane` has it; (a, b, c) may be of any length.
    pub fn from_coefficients(coefficients: [f64; 4]) -> Result<Self, PlaneError> {
        let [a, b, c, d] = coefficients;
        if !coefficients.iter().all(|x| x.is_finite()) {
            return Err(PlaneError::NotFinite(coefficients));
        }
        // squares of very large or very small numbers overflow or underflow
        let scale = a.abs().greater(b.abs()).greater(c.abs());
        let normal = Vector::new(a / scale, b / scale, c / scale);
        let Some(normal) = UnitVector::try_new(normal, 0.5) else {
            return Err(PlaneError::NoNormal(coefficients));
        };
        let offset = -d / scale / Vector::new(a / scale, b / scale, c / scale).norm();
        let near = offset.abs() <= LARGEST_COORDINATE;
        (near.then_some(Self { normal, offset })).ok_or(PlaneError::TooFar(coefficients))
    }

    /// Signed distance (m) of a point from the plane, positive on the side of the normal.
    #[must_use]
    pub fn height(&self, p: &Point) -> f64 {
        self.normal.dot(&p.coords) - self.offset
    }

    /// The point of the plane nearest to the origin.
    #[must_use]
    pub fn foot(&self) -> Point {
        Point::from(self.normal.into_inner() * self.offset)
    }

    /// Transforms a plane from a frame placed at `pose` to the parent frame.
    #[must_use]
    pub fn transformed(&self, pose: &Pose) -> Self {
        let normal = pose.rotation * self.normal;
        Self { normal, offset: self.offset + normal.dot(&pose.translation.vector) }
    }

    /// As [`Self::transformed`], for a rotation as a matrix.
    #[must_use]
    #[inline]
    pub fn placed(&self, pose: &MatrixPose) -> Self {
        let normal = pose.rotation * self.normal.into_inner();
        Self {
            offset: self.offset + normal.dot(&pose.translation),
            normal: UnitVector::new_unchecked(normal),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::pose_from_xyz_rpy;

    #[test]
    fn coefficients_of_any_length_make_one_plane() {
        for scale in [1e-300, 1.0, 1e300] {
            let plane = Plane::from_coefficients([0.0, 3.0 * scale, 4.0 * scale, -10.0 * scale]).unwrap();
            assert!((plane.normal.into_inner() - Vector::new(0.0, 0.6, 0.8)).norm() < 1e-15);
            assert!((plane.offset - 2.0).abs() < 1e-15);
            assert!(plane.height(&plane.foot()).abs() < 1e-15);
        }
    }

    #[test]
    fn points_keep_their_height_when_all_moves() {
        let plane = Plane::from_coefficients([1.0, -2.0, 0.5, 0.3]).unwrap();
        let pose = pose_from_xyz_rpy([0.3, -2.0, 1.0], [0.3, 1.0, -2.0]);
        let p = Point::new(0.2, 0.7, -1.1);
        assert!((plane.transformed(&pose).height(&(pose * p)) - plane.height(&p)).abs() < 1e-15);
    }

    #[test]
    fn faults_are_named() {
        let made = Plane::from_coefficients;
        assert!(matches!(made([0.0, 0.0, 0.0, 1.0]), Err(PlaneError::NoNormal(_))));
        assert!(matches!(made([f64::NAN, 0.0, 1.0, 1.0]), Err(PlaneError::NotFinite(_))));
        assert!(matches!(made([0.0, 0.0, 1.0, f64::INFINITY]), Err(PlaneError::NotFinite(_))));
        assert!(matches!(made([0.0, 0.0, 1e-9, 1.0]), Err(PlaneError::TooFar(_))));
    }
}
