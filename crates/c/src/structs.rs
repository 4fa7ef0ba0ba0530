//! C structs that several functions share: states, edges, poses, pairs and named values.

use std::ffi::c_char;
use std::ptr;

use clearance::geometry::constants::LARGEST_COORDINATE;
use clearance::geometry::math::{Point, Pose, pose_from_xyz_quaternion};

use crate::arguments::Arguments;
use crate::status::{Failure, Outcome};

/// A state: `n` joint positions (rad, m), in the order of `clearance_checker_joint_name`, or for functions of a robot in that of
/// `clearance_robot_joint_name`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_state {
    /// The positions.
    pub positions: *const f64,
    /// Number of positions.
    pub n: usize,
}

/// Many states: `count` rows of `n` joint positions each (rad, m), row by row.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_states {
    /// count x n positions.
    pub positions: *const f64,
    /// Number of states.
    pub count: usize,
    /// Number of positions of a state.
    pub n: usize,
}

/// Straight motions in joint space: the k-th is from row k of `from` to row k of `to`.
///
/// Continuous joints move through all positions in between, also by more than half a turn.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_edges {
    /// count x n positions (rad, m).
    pub from: *const f64,
    /// count x n positions (rad, m).
    pub to: *const f64,
    /// Number of motions.
    pub count: usize,
    /// Number of positions of a state.
    pub n: usize,
}

/// A straight motion in joint space between two states of `n` positions (rad, m).
///
/// Continuous joints move through all positions in between, also by more than half a turn.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_edge {
    /// n positions at the start.
    pub from: *const f64,
    /// n positions at the end.
    pub to: *const f64,
    /// Number of positions.
    pub n: usize,
}

/// A value by name: a position (rad, m), a padding (m), a factor.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_named_value {
    /// The name.
    pub name: *const c_char,
    /// The value.
    pub value: f64,
}

/// Names of two bodies: links, attached objects or obstacles. In results, both are null if there is no pair.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_pair {
    /// A link or an attached object.
    pub a: *const c_char,
    /// A link, an attached object or an obstacle.
    pub b: *const c_char,
}

impl clearance_pair {
    /// No pair.
    pub const NONE: Self = Self { a: ptr::null(), b: ptr::null() };
}

/// A pose. Where a pointer to a pose is null, the pose is the identity.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct clearance_pose {
    /// x, y, z (m).
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

/// Largest deviation of a quaternion's length from 1.
const SLACK: f64 = 1e-3;

impl clearance_pose {
    /// The pose as C has it.
    pub fn new(pose: &Pose) -> Self {
        let (t, q) = (pose.translation.vector, pose.rotation.coords);
        Self { position: [t.x, t.y, t.z], orientation: [q.x, q.y, q.z, q.w] }
    }

    /// Validates a pose of the caller; null is the identity.
    pub fn read(arguments: Arguments<'_>, pose: *const Self, name: &str) -> Outcome<Pose> {
        let Some(given) = arguments.object_or_none(pose, name)? else { return Ok(Pose::identity()) };
        let Self { position, orientation } = given;
        let length = orientation.iter().map(|c| c * c).sum::<f64>().sqrt();
        // NaN is no length of 1 either
        let is_unit = (length - 1.0).abs() <= SLACK;
        if !is_unit {
            return Err(Failure::rejected(format!(
                "the orientation (x y z w) {orientation:?} of {name} has length {length}, but it must be 1"
            )));
        }
        pose_from_xyz_quaternion(*position, *orientation).ok_or_else(|| {
            Failure::rejected(format!(
                "the position {position:?} of {name} must be finite and at most {LARGEST_COORDINATE:e} m away"
            ))
        })
    }
}

/// Coordinates of a point.
pub fn xyz(point: &Point) -> [f64; 3] {
    [point.x, point.y, point.z]
}

/// Values of the caller by name.
pub fn named_values(
    arguments: Arguments<'_>,
    values: *const clearance_named_value,
    count: usize,
    what: &str,
) -> Outcome<Vec<(String, f64)>> {
    let values = arguments.array(values, count, what)?.iter().enumerate();
    let named = values.map(|(i, named)| {
        Ok((arguments.text(named.name, &format!("{what}[{i}].name"))?.to_owned(), named.value))
    });
    named.collect()
}

/// Texts of the caller.
pub fn texts(
    arguments: Arguments<'_>,
    list: *const *const c_char,
    count: usize,
    what: &str,
) -> Outcome<Vec<String>> {
    let list = arguments.array(list, count, what)?.iter().enumerate();
    list.map(|(i, &text)| Ok(arguments.text(text, &format!("{what}[{i}]"))?.to_owned())).collect()
}
