//! Start state of a trajectory message, and its comparison with the first point.

use std::f64::consts::TAU;

use clearance_robot::{Configuration, ConfigurationError, JointKind, RobotModel};

use super::ContinuousDirection;

/// Tolerance (rad, m) between the start and the first point; allows for rounding in files and messages.
pub const START_TOLERANCE: f64 = 1e-6;

/// A start state that a message contains in addition to the points of its trajectory.
///
/// The motion from it to the first point is not checked, so the two must be equal.
#[derive(Clone, Debug)]
pub(super) struct TrajectoryStart {
    configuration: Configuration,
    /// By position: true if the message contains it.
    given: Vec<bool>,
}

/// Error: the start differs from the first point.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "trajectory_start has '{name}' at {start}, but the first point has it at {first}, and nothing between the two would be checked: \
     make the start the first point, or leave trajectory_start out"
)]
pub struct StartMismatch {
    /// Name of the position.
    pub name: String,
    /// Position (rad, m) of the start.
    pub start: f64,
    /// Position (rad, m) of the first point.
    pub first: f64,
}

impl TrajectoryStart {
    /// Positions by name; other positions are as in `rest`.
    pub fn new(
        robot: &RobotModel,
        rest: &Configuration,
        names: &[String],
        positions: &[f64],
    ) -> Result<Self, ConfigurationError> {
        let named = robot.named_joints(names.iter().map(String::as_str))?;
        let given = (0..rest.positions().len()).map(|position| named.decides(position)).collect();
        Ok(Self { configuration: named.configuration(rest, positions)?, given })
    }

    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// # Errors
    /// The first position in which `first` differs.
    pub fn check(
        &self,
        robot: &RobotModel,
        first: &Configuration,
        direction: ContinuousDirection,
    ) -> Result<(), StartMismatch> {
        let (starts, firsts) = (self.configuration.positions(), first.positions());
        for joint in robot.joint_ids() {
            let Some(index) = robot.first_position(joint) else { continue };
            let kind = &robot.joint(joint).kind;
            let positions = index..index + kind.position_suffixes().len();
            // a quaternion and its negative are the same rotation
            let dot: f64 = starts[positions.clone()]
                .iter()
                .zip(&firsts[positions.clone()])
                .skip(3)
                .map(|(a, b)| a * b)
                .sum();
            let sign = if *kind == JointKind::Floating && dot < 0.0 { -1.0 } else { 1.0 };
            // on the shortest path full turns do not matter, unless they change the pose of a mimic joint
            let angle = kind.unlimited_angle().filter(|_| {
                direction == ContinuousDirection::Shortest && robot.moved_by_whole_turns(joint).is_none()
            });
            for (at, i) in positions.zip(0..) {
                let first = if i < 3 { firsts[at] } else { sign * firsts[at] };
                let off = first - starts[at];
                let off = if angle == Some(i) { off - TAU * (off / TAU).round() } else { off };
                if self.given[at] && off.abs() > START_TOLERANCE {
                    let name = robot.position_names()[at].clone();
                    return Err(StartMismatch { name, start: starts[at], first: firsts[at] });
                }
            }
        }
        Ok(())
    }
}
