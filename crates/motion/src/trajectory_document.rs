//! Trajectory files: recognises the ROS message type, and extracts the joint trajectory.

use clearance_files::yaml;
use clearance_robot::{Configuration, RobotModel, quoted};
use clearance_scene::{MultiDofJoint, NamedState, RobotStateText};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::TrajectoryPoint;
use super::trajectory_start::TrajectoryStart;
use super::trajectory_text_error::TrajectoryTextError;

/// A `trajectory_msgs/JointTrajectory`, with the positions of joints that it does not name.
pub(super) struct TrajectoryDocument {
    pub joint_names: Vec<String>,
    pub points: Vec<TrajectoryPoint>,
    pub rest: Configuration,
    pub start: Option<TrajectoryStart>,
    /// Remarks on parts of the text that do not affect the motion.
    pub remarks: Vec<String>,
}

/// The fields of the three messages.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileText {
    // trajectory_msgs/JointTrajectory
    #[serde(rename = "header")]
    _header: Option<IgnoredAny>,
    joint_names: Option<Vec<String>>,
    points: Option<Vec<PointText>>,
    // moveit_msgs/RobotTrajectory
    joint_trajectory: Option<JointTrajectoryText>,
    multi_dof_joint_trajectory: Option<MultiDofTrajectoryText>,
    // moveit_msgs/DisplayTrajectory
    model_id: Option<String>,
    trajectory: Option<GivenTrajectory>,
    trajectory_start: Option<RobotStateText>,
    // goals of control_msgs/FollowJointTrajectory and moveit_msgs/ExecuteTrajectory
    multi_dof_trajectory: Option<MultiDofTrajectoryText>,
    #[serde(default)]
    path_tolerance: Vec<IgnoredAny>,
    #[serde(default)]
    component_path_tolerance: Vec<IgnoredAny>,
    #[serde(rename = "goal_tolerance")]
    _goal_tolerance: Option<IgnoredAny>,
    #[serde(rename = "component_goal_tolerance")]
    _component_goal_tolerance: Option<IgnoredAny>,
    #[serde(rename = "goal_time_tolerance")]
    _goal_time_tolerance: Option<IgnoredAny>,
    #[serde(rename = "controller_names")]
    _controller_names: Option<IgnoredAny>,
    // an action's goal of ROS 1
    #[serde(rename = "goal_id")]
    _goal_id: Option<IgnoredAny>,
    goal: Option<Box<FileText>>,
}

/// `trajectory`: those of a `DisplayTrajectory`, or that of a goal.
enum GivenTrajectory {
    List(Vec<RobotTrajectoryText>),
    One(Box<GoalTrajectoryText>),
}

/// A `JointTrajectory` or a `RobotTrajectory`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GoalTrajectoryText {
    #[serde(rename = "header")]
    _header: Option<IgnoredAny>,
    joint_names: Option<Vec<String>>,
    points: Option<Vec<PointText>>,
    joint_trajectory: Option<JointTrajectoryText>,
    multi_dof_joint_trajectory: Option<MultiDofTrajectoryText>,
}

impl<'de> Deserialize<'de> for GivenTrajectory {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrList)
    }
}

struct OneOrList;

impl<'de> Visitor<'de> for OneOrList {
    type Value = GivenTrajectory;

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("a trajectory or a list of trajectories")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(list)).map(GivenTrajectory::List)
    }

    fn visit_map<A: MapAccess<'de>>(self, one: A) -> Result<Self::Value, A::Error> {
        let one = GoalTrajectoryText::deserialize(MapAccessDeserializer::new(one))?;
        Ok(GivenTrajectory::One(Box::new(one)))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointTrajectoryText {
    #[serde(rename = "header")]
    _header: Option<IgnoredAny>,
    joint_names: Vec<String>,
    points: Vec<PointText>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotTrajectoryText {
    joint_trajectory: JointTrajectoryText,
    multi_dof_joint_trajectory: Option<MultiDofTrajectoryText>,
}

#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct MultiDofTrajectoryText {
    #[serde(rename = "header")]
    _header: Option<IgnoredAny>,
    joint_names: Vec<String>,
    points: Vec<IgnoredAny>,
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
    time_from_start: DurationText,
}

/// A time: seconds, `builtin_interfaces/Duration`, or the `duration` of ROS 1.
#[derive(Clone, Copy, Deserialize)]
#[serde(
    untagged,
    expecting = "a time must be a number of seconds, or have sec and nanosec (ROS 2) or secs and nsecs (ROS 1)"
)]
enum DurationText {
    Seconds(f64),
    Ros2(Ros2Duration),
    Ros1(Ros1Duration),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ros2Duration {
    #[serde(default)]
    sec: i32,
    #[serde(default)]
    nanosec: u32,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ros1Duration {
    #[serde(default)]
    secs: i32,
    #[serde(default)]
    nsecs: i32,
}

impl Default for DurationText {
    fn default() -> Self {
        Self::Seconds(0.0)
    }
}

impl DurationText {
    fn seconds(self) -> f64 {
        match self {
            Self::Seconds(seconds) => seconds,
            Self::Ros2(Ros2Duration { sec, nanosec }) => TrajectoryPoint::seconds(sec, nanosec.into()),
            Self::Ros1(Ros1Duration { secs, nsecs }) => TrajectoryPoint::seconds(secs, nsecs.into()),
        }
    }
}

impl TrajectoryDocument {
    /// Reads a `trajectory_msgs/JointTrajectory`, a `moveit_msgs/RobotTrajectory` or a `moveit_msgs/DisplayTrajectory` with one
    /// trajectory. The start of the latter gives the positions of joints that the trajectory does not name; other joints keep their
    /// positions of `rest`.
    pub fn read(text: &str, robot: &RobotModel, rest: &Configuration) -> Result<Self, TrajectoryTextError> {
        let (text, mut remarks) = yaml::without_remarks_of_echo(text);
        let file = yaml::from_text(&text).and_then(inner).map_err(TrajectoryTextError::Text)?;
        if !(file.path_tolerance.is_empty() && file.component_path_tolerance.is_empty()) {
            let remark = "path_tolerance is not read: --tube sets how far the robot may be off its path";
            remarks.push(remark.to_owned());
        }
        remarks.extend(other_robot(file.model_id.as_deref().unwrap_or_default(), robot));
        let start = start(file.trajectory_start, robot, rest).map_err(TrajectoryTextError::Text)?;
        let rest = start.as_ref().map_or(rest, TrajectoryStart::configuration).clone();
        let JointTrajectoryText { joint_names, points, .. } =
            only_trajectory(FileText { trajectory_start: None, ..file }, robot)
                .map_err(TrajectoryTextError::Text)?;
        let points = points.into_iter().map(|p| TrajectoryPoint {
            positions: p.positions,
            velocities: p.velocities,
            accelerations: p.accelerations,
            time_from_start: p.time_from_start.seconds(),
        });
        Ok(Self { joint_names, points: points.collect(), rest, start, remarks })
    }
}

/// A remark on a trajectory of another robot.
fn other_robot(model_id: &str, robot: &RobotModel) -> Option<String> {
    let is_other = !model_id.is_empty() && model_id != robot.name();
    is_other.then(|| {
        let [of, own] = [model_id, robot.name()].map(quoted);
        format!("model_id: the trajectory is of {of}, the robot is {own}")
    })
}

/// The start given in `trajectory_start`, if it names any joint.
fn start(
    text: Option<RobotStateText>,
    robot: &RobotModel,
    rest: &Configuration,
) -> Result<Option<TrajectoryStart>, String> {
    let Some(text) = text else { return Ok(None) };
    let fault = |why: String| format!("trajectory_start: {why}");
    let NamedState { names, positions } = NamedState::of_robot(text, robot).map_err(fault)?;
    if names.is_empty() {
        return Ok(None);
    }
    let start = TrajectoryStart::new(robot, rest, &names, &positions);
    start.map(Some).map_err(|error| fault(error.to_string()))
}

/// The goal inside an action's message, or the file itself.
fn inner(file: FileText) -> Result<FileText, String> {
    let FileText { joint_names, points, joint_trajectory, trajectory, trajectory_start, goal, .. } = &file;
    let FileText {
        multi_dof_joint_trajectory,
        multi_dof_trajectory,
        path_tolerance,
        component_path_tolerance,
        ..
    } = &file;
    let holds_more = joint_names.is_some()
        || points.is_some()
        || joint_trajectory.is_some()
        || trajectory.is_some()
        || trajectory_start.is_some()
        || multi_dof_joint_trajectory.is_some()
        || multi_dof_trajectory.is_some()
        || !path_tolerance.is_empty()
        || !component_path_tolerance.is_empty();
    match (goal, holds_more) {
        (None, _) => Ok(file),
        (Some(_), true) => {
            Err("goal excludes joint_names, points, joint_trajectory, trajectory, trajectory_start and other parts of a motion".to_owned())
        }
        (Some(goal), false) if goal.goal.is_some() => Err("goal holds another goal".to_owned()),
        (Some(_), false) => file.goal.map(|goal| *goal).ok_or_else(|| "goal is missing".to_owned()),
    }
}

fn only_trajectory(file: FileText, robot: &RobotModel) -> Result<JointTrajectoryText, String> {
    let is_plain = file.joint_names.is_some() || file.points.is_some();
    let is_of_robot = file.joint_trajectory.is_some() || file.multi_dof_joint_trajectory.is_some();
    match (is_plain, is_of_robot, file.trajectory) {
        (true, false, None) => {
            reject_multi_dof("multi_dof_trajectory", file.multi_dof_trajectory, robot)?;
            plain(file.joint_names, file.points)
        }
        (false, true, None) => {
            reject_multi_dof("multi_dof_trajectory", file.multi_dof_trajectory, robot)?;
            of_robot(file.joint_trajectory, file.multi_dof_joint_trajectory, robot)
        }
        (false, false, Some(GivenTrajectory::One(goal))) => {
            reject_multi_dof("multi_dof_trajectory", file.multi_dof_trajectory, robot)?;
            of_goal(*goal, robot).map_err(|why| format!("trajectory: {why}"))
        }
        (false, false, Some(GivenTrajectory::List(_))) if file.multi_dof_trajectory.is_some() => {
            Err("a list of trajectories and multi_dof_trajectory exclude each other".to_owned())
        }
        (false, false, Some(GivenTrajectory::List(mut all))) => match (all.pop(), all.len()) {
            (Some(only), 0) => of_robot(Some(only.joint_trajectory), only.multi_dof_joint_trajectory, robot),
            (None, _) => Err("trajectory is empty".to_owned()),
            (Some(_), others) => {
                let count = others + 1;
                Err(format!(
                    "trajectory has {count} trajectories, but only one is read: give each in a file of its own"
                ))
            }
        },
        (false, false, None) => {
            Err("it has no joint_names and points, joint_trajectory, or trajectory".to_owned())
        }
        _ => Err("joint_names and points, joint_trajectory, and trajectory exclude each other".to_owned()),
    }
}

fn of_goal(goal: GoalTrajectoryText, robot: &RobotModel) -> Result<JointTrajectoryText, String> {
    let is_plain = goal.joint_names.is_some() || goal.points.is_some();
    let is_of_robot = goal.joint_trajectory.is_some() || goal.multi_dof_joint_trajectory.is_some();
    match (is_plain, is_of_robot) {
        (true, false) => plain(goal.joint_names, goal.points),
        (false, true) => of_robot(goal.joint_trajectory, goal.multi_dof_joint_trajectory, robot),
        (false, false) => Err("it has no joint_names and points, or joint_trajectory".to_owned()),
        (true, true) => Err("joint_names and points, and joint_trajectory exclude each other".to_owned()),
    }
}

fn plain(
    joint_names: Option<Vec<String>>,
    points: Option<Vec<PointText>>,
) -> Result<JointTrajectoryText, String> {
    Ok(JointTrajectoryText {
        _header: None,
        joint_names: joint_names.ok_or("joint_names is missing")?,
        points: points.ok_or("points is missing")?,
    })
}

fn of_robot(
    joints: Option<JointTrajectoryText>,
    multi_dof: Option<MultiDofTrajectoryText>,
    robot: &RobotModel,
) -> Result<JointTrajectoryText, String> {
    let joints = joints.ok_or("joint_trajectory is missing")?;
    reject_multi_dof("multi_dof_joint_trajectory", multi_dof, robot)?;
    Ok(joints)
}

fn reject_multi_dof(
    field: &str,
    multi_dof: Option<MultiDofTrajectoryText>,
    robot: &RobotModel,
) -> Result<(), String> {
    let MultiDofTrajectoryText { joint_names, points, .. } = multi_dof.unwrap_or_default();
    if joint_names.is_empty() && points.is_empty() {
        return Ok(());
    }
    let is_virtual = |name: &&String| MultiDofJoint::find(robot, name).is_only_virtual();
    if let Some(name) = joint_names.iter().find(is_virtual) {
        return Err(format!(
            "{field} is not read: virtual joint '{name}' can not be moved here, leave it out; where the robot stands among obstacles, \
             the robot_state of a planning scene says (--world)"
        ));
    }
    let names = joint_names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
    Err(format!(
        "{field} ({names}) is not read: name the positions of these joints in joint_trajectory, \
         such as JOINT/x, JOINT/y and JOINT/theta"
    ))
}

#[cfg(test)]
mod tests;
