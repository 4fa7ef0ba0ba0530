//! Constructors of a trajectory from a YAML or JSON text of a ROS message.

use clearance_robot::{Configuration, RobotModel};

use super::trajectory_document::TrajectoryDocument;
use super::{ContinuousDirection, MotionSegment, Trajectory, TrajectoryTextError};

impl Trajectory {
    /// Reads a `trajectory_msgs/JointTrajectory`, also within a `moveit_msgs/RobotTrajectory` or `DisplayTrajectory`; joints that it does
    /// not name keep their positions of `rest`.
    pub fn from_yaml(
        robot: &RobotModel,
        text: &str,
        rest: &Configuration,
    ) -> Result<Self, TrajectoryTextError> {
        Ok(Self::from_yaml_with_direction(robot, text, rest, ContinuousDirection::AsGiven)?.0)
    }

    /// As above, with the given direction of continuous joints between points, and with remarks on the text.
    pub fn from_yaml_with_direction(
        robot: &RobotModel,
        text: &str,
        rest: &Configuration,
        direction: ContinuousDirection,
    ) -> Result<(Self, Vec<String>), TrajectoryTextError> {
        let TrajectoryDocument { joint_names, points, rest, start, mut remarks } =
            TrajectoryDocument::read(text, robot, rest)?;
        let trajectory = Self::from_points_with_direction(robot, &joint_names, &points, &rest, direction)?;
        match (start, trajectory.segments().first().map(MotionSegment::ends)) {
            (Some(start), Some([first, _])) => start.check(robot, &first, direction)?,
            _ => remarks.extend(trajectory.late_start_note()),
        }
        Ok((trajectory, remarks))
    }
}
