//! Types of points, vectors and poses, with constructors, and the notation for frames.
//!
//! A pose of frame B in frame A is `pose_ab`; a point with coordinates in A is `point_a`; inner letters cancel:
//! `point_a = pose_ab * point_b`, `pose_ac = pose_ab * pose_bc`. The world is `w`, the robot's root `r`, an obstacle `o`.

mod extremes;

pub use extremes::Extremes;

use std::f64::consts::TAU;

use crate::constants::LARGEST_COORDINATE;

/// A position, in metres.
pub type Point = nalgebra::Point3<f64>;
/// A displacement or direction.
pub type Vector = nalgebra::Vector3<f64>;
/// A direction of length one.
pub type UnitVector = nalgebra::Unit<Vector>;
/// A rotation.
pub type Rotation = nalgebra::UnitQuaternion<f64>;
/// A rotation as a matrix: its columns are the axes of the rotated frame.
pub type RotationMatrix = nalgebra::Matrix3<f64>;
/// The pose of one frame in another.
pub type Pose = nalgebra::Isometry3<f64>;

/// Eigenvalues and eigenvectors (columns, of length one) of a symmetric matrix, in no particular order.
///
/// The method of nalgebra is generic, and long: called here, it is compiled once.
#[must_use]
pub fn symmetric_eigen(matrix: &nalgebra::Matrix3<f64>) -> nalgebra::SymmetricEigen<f64, nalgebra::U3> {
    matrix.symmetric_eigen()
}

/// The equivalent angle (rad) between minus half a turn and half a turn.
#[must_use]
pub fn without_whole_turns(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// Pose from a position and a quaternion in the order (x, y, z, w), normalised here.
///
/// `None` when a number is not finite, the position lies beyond [`LARGEST_COORDINATE`], or the quaternion has no length.
#[must_use]
pub fn pose_from_xyz_quaternion(xyz: [f64; 3], quaternion_xyzw: [f64; 4]) -> Option<Pose> {
    let [x, y, z, w] = quaternion_xyzw;
    let quaternion = nalgebra::Quaternion::new(w, x, y, z);
    let length = quaternion.norm();
    let near = xyz.iter().all(|c| c.abs() <= LARGEST_COORDINATE);
    (near && length > 1e-9 && length.is_finite())
        .then(|| Pose::from_parts(nalgebra::Translation3::from(xyz), Rotation::from_quaternion(quaternion)))
}

/// Pose from a position and fixed-axis roll, pitch, yaw as URDF defines them: `Rz(yaw) * Ry(pitch) * Rx(roll)`.
#[must_use]
pub fn pose_from_xyz_rpy(xyz: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Pose {
    Pose::from_parts(nalgebra::Translation3::from(xyz), Rotation::from_euler_angles(roll, pitch, yaw))
}

/// A pose with its rotation as a matrix: [`Pose`] is used in interfaces, this type in computations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatrixPose {
    /// Axes of the frame as columns, in the parent frame.
    pub rotation: RotationMatrix,
    /// Origin of the frame in the parent frame (m).
    pub translation: Vector,
}

impl MatrixPose {
    /// The pose of a frame in itself.
    #[must_use]
    pub fn identity() -> Self {
        Self { rotation: RotationMatrix::identity(), translation: Vector::zeros() }
    }

    /// `pose_ac` of `pose_ab` and `pose_bc`.
    #[inline]
    #[must_use]
    pub fn compose(&self, next: &Self) -> Self {
        Self { rotation: self.rotation * next.rotation, translation: self.point(&next.translation) }
    }

    /// `pose_ab` of `pose_wa` and `pose_wb`.
    #[inline]
    #[must_use]
    pub fn relative(&self, other: &Self) -> Self {
        let rotation = self.rotation.tr_mul(&other.rotation);
        Self { rotation, translation: self.rotation.tr_mul(&(other.translation - self.translation)) }
    }

    /// `pose_ba` of `pose_ab`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    #[inline]
    fn point(&self, coordinates: &Vector) -> Vector {
        self.rotation * coordinates + self.translation
    }
}

impl std::ops::Mul<Point> for &MatrixPose {
    type Output = Point;

    #[inline]
    fn mul(self, point: Point) -> Point {
        Point::from(self.point(&point.coords))
    }
}

impl From<&MatrixPose> for MatrixPose {
    fn from(pose: &MatrixPose) -> Self {
        *pose
    }
}

impl From<&Pose> for MatrixPose {
    fn from(pose: &Pose) -> Self {
        Self { rotation: *pose.rotation.to_rotation_matrix().matrix(), translation: pose.translation.vector }
    }
}

impl From<&MatrixPose> for Pose {
    fn from(pose: &MatrixPose) -> Self {
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(pose.rotation);
        Self::from_parts(pose.translation.into(), Rotation::from_rotation_matrix(&rotation))
    }
}
