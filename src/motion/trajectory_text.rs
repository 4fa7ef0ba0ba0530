//! Trajectories as they stand in files: the YAML or JSON of a `trajectory_msgs/JointTrajectory`.

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::{ContinuousDirection, Trajectory, TrajectoryError, TrajectoryPoint};
use crate::robot::{Configuration, RobotModel};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TrajectoryText {
    #[serde(rename = "header")]
    _header: Option<IgnoredAny>,
    joint_names: Vec<String>,
    points: Vec<PointText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointText {
    positions: Vec<f64>,
    #[serde(default)]
    velocities: Vec<f64>,
    #[serde(default)]
    accelerations: Vec<f64>,
    #[serde(rename = "effort")]
    _effort: Option<IgnoredAny>,
    #[serde(default)]
    time_from_start: SpanText,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpanText {
    sec: u32,
    nanosec: u32,
}

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
    /// Reads a `trajectory_msgs/JointTrajectory`; joints that it does not name stay as in `rest`.
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
        let text: TrajectoryText =
            serde_saphyr::from_str(text).map_err(|error| TrajectoryTextError::Text(error.to_string()))?;
        let points: Vec<TrajectoryPoint> = (text.points.into_iter())
            .map(|p| TrajectoryPoint {
                positions: p.positions,
                velocities: p.velocities,
                accelerations: p.accelerations,
                time_from_start: f64::from(p.time_from_start.sec)
                    + 1e-9 * f64::from(p.time_from_start.nanosec),
            })
            .collect();
        Ok(Self::from_points_going(robot, &text.joint_names, &points, rest, direction)?)
    }
}
