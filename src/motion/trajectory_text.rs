//! Reads trajectories: the YAML or JSON of ROS's messages.

use super::trajectory_document::TrajectoryDocument;
use super::{ContinuousDirection, Trajectory, TrajectoryError};
use crate::robot::{Configuration, RobotModel};

/// Why a text is no trajectory.
#[derive(Debug, thiserror::Error)]
pub enum TrajectoryTextError {
    /// The reader says where.
    #[error("{0}")]
    Text(String),
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

impl Trajectory {
    /// Reads a `trajectory_msgs/JointTrajectory`, also within a `moveit_msgs/RobotTrajectory` or `DisplayTrajectory`; joints that it
    /// does not name stay as in `rest`.
    pub fn from_yaml(
        robot: &RobotModel,
        text: &str,
        rest: &Configuration,
    ) -> Result<Self, TrajectoryTextError> {
        Self::from_yaml_going(robot, text, rest, ContinuousDirection::AsGiven)
    }

    /// The same where continuous joints go from point to point as `direction` says.
    pub fn from_yaml_going(
        robot: &RobotModel,
        text: &str,
        rest: &Configuration,
        direction: ContinuousDirection,
    ) -> Result<Self, TrajectoryTextError> {
        let TrajectoryDocument { joint_names, points, rest } = TrajectoryDocument::read(text, robot, rest)?;
        Ok(Self::from_points_going(robot, &joint_names, &points, &rest, direction)?)
    }
}
