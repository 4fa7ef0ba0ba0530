//! Joint: type, axis, limits and mimic rule, and its motion at given positions.

use clearance_geometry::math::{Extremes, Pose, Rotation, RotationMatrix, UnitVector, Vector};

use super::{JointId, LinkId};

/// A joint between two links.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name in the URDF.
    pub name: String,
    /// Type and axis.
    pub kind: JointKind,
    /// The link that the joint frame is fixed to.
    pub parent: LinkId,
    /// The link that the joint moves.
    pub child: LinkId,
    /// Pose of the joint frame in the parent link at position zero.
    pub pose_pj: Pose,
    /// `None` for joints that are neither revolute nor prismatic, and for those without position limits (URDF 1.2).
    pub limits: Option<Limits>,
    /// Set if the joint's position follows another joint.
    pub mimic: Option<Mimic>,
    /// Passive in the SRDF: not driven, but its position is still read.
    pub passive: bool,
}

/// Motion of a joint; axes are unit vectors in the joint frame.
#[derive(Clone, Debug, PartialEq)]
pub enum JointKind {
    /// No motion.
    Fixed,
    /// Rotation (rad) about the axis, with limits.
    Revolute(UnitVector),
    /// Rotation (rad) about the axis, without limits.
    Continuous(UnitVector),
    /// Translation (m) along the axis.
    Prismatic(UnitVector),
    /// Positions `trans_x trans_y trans_z rot_x rot_y rot_z rot_w`, as `MoveIt` names them.
    Floating,
    /// Positions `x y theta` in the plane whose normal is the axis, as `MoveIt` names them.
    Planar(UnitVector),
}

/// Limits of a revolute or prismatic joint: position, velocity, acceleration (the last two are infinite where not
/// given). Joints of other types have none; a `<limit>` of theirs is not read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Minimum position (rad, m).
    pub lower: f64,
    /// Maximum position (rad, m).
    pub upper: f64,
    /// Maximum velocity (rad/s, m/s).
    pub velocity: f64,
    /// Maximum acceleration (rad/s², m/s²).
    pub acceleration: f64,
}

/// `position = multiplier * position of joint + offset`, resolved to a joint that itself mimics none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mimic {
    /// The joint that is mimicked (the leader).
    pub joint: JointId,
    /// Factor of the leader's position.
    pub multiplier: f64,
    /// Offset (rad, m), added after multiplication.
    pub offset: f64,
}

impl JointKind {
    /// The suffixes of the joint's position names; a joint with one position uses its own name.
    #[must_use]
    pub fn position_suffixes(&self) -> &'static [&'static str] {
        match self {
            Self::Fixed => &[],
            Self::Revolute(_) | Self::Continuous(_) | Self::Prismatic(_) => &[""],
            Self::Planar(_) => &["/x", "/y", "/theta"],
            Self::Floating => &["/trans_x", "/trans_y", "/trans_z", "/rot_x", "/rot_y", "/rot_z", "/rot_w"],
        }
    }

    /// Whether its only position is an angle.
    #[must_use]
    pub fn turns(&self) -> bool {
        matches!(self, Self::Revolute(_) | Self::Continuous(_))
    }

    /// Which of its positions is an angle without limits: a full turn of it changes no pose.
    #[must_use]
    pub fn unlimited_angle(&self) -> Option<usize> {
        match self {
            Self::Continuous(_) => Some(0),
            Self::Planar(_) => Some(2),
            _ => None,
        }
    }

    /// Number of degrees of freedom; a floating joint's seven positions have six.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> usize {
        match self {
            Self::Floating => 6,
            other => other.position_suffixes().len(),
        }
    }

    /// The positions of a planar or floating joint whose child link is at `pose_jc` in the joint frame, and the deviation (m, rad) of the
    /// resulting pose from `pose_jc`: a planar joint does not leave its plane. `None` for other joint types.
    #[must_use]
    pub fn positions_at(&self, pose_jc: &Pose) -> Option<(Vec<f64>, f64)> {
        let (shift, turn) = (pose_jc.translation.vector, pose_jc.rotation);
        match self {
            Self::Floating => {
                let [i, j, k, w] = turn.quaternion().coords.into();
                Some((vec![shift.x, shift.y, shift.z, i, j, k, w], 0.0))
            }
            Self::Planar(axis) => {
                let (u, v) = plane_basis(axis);
                let half = turn.imag().dot(axis).atan2(turn.w);
                // half the angle, and half the angle minus a full turn, are the same rotation
                let theta = 2.0 * (half - std::f64::consts::PI * (half / std::f64::consts::PI).round());
                let tilt = turn.angle_to(&Rotation::from_axis_angle(axis, theta));
                let off = shift.dot(axis).abs();
                Some((vec![shift.dot(&u), shift.dot(&v), theta], off.greater(tilt)))
            }
            _ => None,
        }
    }

    /// Pose of the child link in the joint frame; `positions` has one number for each position suffix.
    #[must_use]
    pub fn motion(&self, positions: &[f64]) -> Pose {
        match self {
            Self::Fixed => Pose::identity(),
            Self::Revolute(axis) | Self::Continuous(axis) => Pose::from_parts(
                nalgebra::Translation3::identity(),
                Rotation::from_axis_angle(axis, positions[0]),
            ),
            Self::Prismatic(axis) => {
                let shift = axis.into_inner() * positions[0];
                Pose::translation(shift.x, shift.y, shift.z)
            }
            Self::Planar(axis) => {
                let (u, v) = plane_basis(axis);
                let shift = u * positions[0] + v * positions[1];
                Pose::from_parts(shift.into(), Rotation::from_axis_angle(axis, positions[2]))
            }
            Self::Floating => {
                let [x, y, z, w] = [positions[3], positions[4], positions[5], positions[6]];
                Pose::from_parts(
                    nalgebra::Translation3::new(positions[0], positions[1], positions[2]),
                    Rotation::from_quaternion(nalgebra::Quaternion::new(w, x, y, z)),
                )
            }
        }
    }
}

/// The axes of a planar joint as columns: two in the plane, and its normal.
pub(super) fn plane_axes(normal: &UnitVector) -> RotationMatrix {
    let (u, v) = plane_basis(normal);
    RotationMatrix::from_columns(&[u, v, normal.into_inner()])
}

/// Two unit vectors that span the plane normal to `axis`; x and y themselves when the axis is z.
fn plane_basis(axis: &UnitVector) -> (Vector, Vector) {
    let turn = Rotation::rotation_between_axis(&Vector::z_axis(), axis)
        .unwrap_or_else(|| Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI));
    (turn * Vector::x(), turn * Vector::y())
}
