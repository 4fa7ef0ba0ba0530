//! Conversion of poses from Python (4×4 matrices, positions, or positions with quaternions) and back.

use clearance::geometry::constants::LARGEST_COORDINATE;
use clearance::geometry::math::{Pose, Rotation, pose_from_xyz_quaternion};
use nalgebra::{Matrix3, Rotation3, Translation3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::arrays::{Numbers, wrong_shape};

/// Largest deviation of a rotation matrix from an orthogonal one, and of a quaternion's length from 1.
const SLACK: f64 = 1e-3;

/// Forms of a pose, for errors.
const FORMS: &str =
    "must be (4, 4), a homogeneous matrix; or (3,), a position; or be a tuple (position, quaternion x y z w)";

/// Reads a pose; none is the identity.
pub fn read(pose: Option<&Bound<'_, PyAny>>) -> PyResult<Pose> {
    match pose {
        None => Ok(Pose::identity()),
        Some(pose) => read_given(pose),
    }
}

fn read_given(pose: &Bound<'_, PyAny>) -> PyResult<Pose> {
    if (pose.is_instance_of::<PyTuple>() || pose.is_instance_of::<PyList>()) && pose.len()? == 2 {
        let position = Numbers::new(&pose.get_item(0)?, "the position of pose")?;
        let quaternion = Numbers::new(&pose.get_item(1)?, "the quaternion of pose")?;
        let position = position.fixed("the position of pose", "must be (3,)")?;
        return from_quaternion(
            position,
            quaternion.fixed("the quaternion of pose", "must be (4,): x y z w")?,
        );
    }
    let numbers = Numbers::new(pose, "pose")?;
    match *numbers.shape() {
        [3] => from_quaternion(numbers.fixed("pose", FORMS)?, [0.0, 0.0, 0.0, 1.0]),
        [4, 4] => from_matrix(numbers.values()),
        _ => Err(wrong_shape("pose", numbers.shape(), FORMS)),
    }
}

fn from_quaternion(position: [f64; 3], quaternion: [f64; 4]) -> PyResult<Pose> {
    let length = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
    if !length.is_finite() {
        return Err(PyValueError::new_err(format!(
            "the quaternion (x y z w) {quaternion:?} of pose must be finite"
        )));
    }
    if (length - 1.0).abs() > SLACK {
        return Err(PyValueError::new_err(format!(
            "the quaternion (x y z w) {quaternion:?} of pose has length {length}, but it must be 1"
        )));
    }
    pose_from_xyz_quaternion(position, quaternion).ok_or_else(|| bad_position(position))
}

fn bad_position(position: [f64; 3]) -> PyErr {
    PyValueError::new_err(format!(
        "the position {position:?} of pose must be finite and at most {LARGEST_COORDINATE:e} m away"
    ))
}

fn from_matrix(m: &[f64]) -> PyResult<Pose> {
    let rotation = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
    let last_row = &m[12..16];
    if last_row != [0.0, 0.0, 0.0, 1.0] {
        return Err(PyValueError::new_err(format!(
            "the last row of the matrix pose is {last_row:?}, but it must be [0, 0, 0, 1]"
        )));
    }
    let off = (rotation * rotation.transpose() - Matrix3::identity()).amax();
    // NaN is not orthogonal either
    if !(off <= SLACK && rotation.determinant() > 0.0) {
        return Err(PyValueError::new_err(
            "the upper left 3×3 of the matrix pose is no rotation: its rows must be orthogonal, of length 1 and right-handed",
        ));
    }
    let position = [m[3], m[7], m[11]];
    if !position.iter().all(|c| c.abs() <= LARGEST_COORDINATE) {
        return Err(bad_position(position));
    }
    Ok(Pose::from_parts(Translation3::from(position), nearest_rotation(rotation)))
}

/// The rotation that is nearest to a matrix, of unit length: single precision and rounded numbers give none exactly.
fn nearest_rotation(matrix: Matrix3<f64>) -> Rotation {
    let parts = matrix.svd(true, true);
    let orthogonal = parts.u.zip(parts.v_t).map_or(matrix, |(u, v_t)| u * v_t);
    let turn = Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(orthogonal));
    Rotation::new_normalize(turn.into_inner())
}

/// The homogeneous matrix of a pose, row by row.
pub fn matrix(pose: &Pose) -> [f64; 16] {
    let m = pose.to_homogeneous();
    std::array::from_fn(|i| m[(i / 4, i % 4)])
}

/// Position and quaternion (x y z w), from which [`from_exact`] makes the same pose, bit by bit.
pub fn exact(pose: &Pose) -> [f64; 7] {
    let (t, q) = (pose.translation.vector, pose.rotation.coords);
    [t.x, t.y, t.z, q.x, q.y, q.z, q.w]
}

/// Rounding error allowed in the length of a quaternion or normal that was of length 1.
pub const EXACT_SLACK: f64 = 1e-9;

/// The pose that [`exact`] was made of; other numbers are rejected.
pub fn from_exact(numbers: [f64; 7]) -> PyResult<Pose> {
    let [x, y, z, i, j, k, w] = numbers;
    let quaternion = nalgebra::Quaternion::new(w, i, j, k);
    let is_near = [x, y, z].iter().all(|c| c.abs() <= LARGEST_COORDINATE);
    // NaN is no rotation either
    if !(is_near && (quaternion.norm() - 1.0).abs() <= EXACT_SLACK) {
        return Err(PyValueError::new_err(format!("{numbers:?} is no pose x y z, quaternion x y z w")));
    }
    Ok(Pose::from_parts(Translation3::new(x, y, z), Rotation::new_unchecked(quaternion)))
}
