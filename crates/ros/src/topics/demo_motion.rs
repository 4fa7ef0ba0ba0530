//! Slow motions for demonstrations, published on `joint_states` like the output of a robot driver.

use std::f64::consts::TAU;
use std::sync::PoisonError;
use std::time::Duration;

use clearance_robot::{ConfigurationError, RobotModel};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;
use ros2_interfaces_jazzy_serde::std_msgs::msg::Header;
use serde::Deserialize;
use smol::Timer;

use crate::clock::RosClock;
use crate::dds::publisher::Publisher;
use crate::messages::time_and_geometry::stamp_message;
use crate::scene::active_scene::CurrentRobot;
use crate::threading::mailbox::Sender;

/// Time between two joint states.
const PERIOD: Duration = Duration::from_millis(10);

/// Kind of motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A trajectory that is repeated.
    Trajectory(Trajectory),
    /// All joints of the loaded robot swing within their limits.
    Sweep,
}

/// Piecewise linear path in joint space, read from the text of a `trajectory_msgs/JointTrajectory`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Trajectory {
    joint_names: Vec<String>,
    points: Vec<Point>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct Point {
    positions: Vec<f64>,
    time_from_start: Span,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct Span {
    sec: u32,
    nanosec: u32,
}

impl Span {
    fn seconds(&self) -> f64 {
        f64::from(self.sec) + 1e-9 * f64::from(self.nanosec)
    }
}

impl Trajectory {
    /// Reads YAML or JSON.
    pub fn from_yaml(text: &str) -> Result<Self, String> {
        let trajectory: Self =
            serde_saphyr::from_str(text).map_err(|error| clearance_files::yaml::in_words(&error))?;
        let width = trajectory.joint_names.len();
        if let Some(point) = trajectory.points.iter().position(|p| p.positions.len() != width) {
            return Err(format!("point {point} has not one position for each of {width} joints"));
        }
        let time = |point: &Point| point.time_from_start.seconds();
        if !trajectory.points.is_sorted_by(|a, b| time(a) < time(b)) {
            return Err("the points are not in the order of their times".to_owned());
        }
        if trajectory.points.is_empty() {
            return Err("there are no points".to_owned());
        }
        Ok(trajectory)
    }

    /// Positions at `time` (s). The trajectory starts again after its last point.
    fn sample(&self, time: f64) -> Vec<f64> {
        let at = |index: usize| self.points[index].time_from_start.seconds();
        let last = self.points.len() - 1;
        let time = if at(last) > 0.0 { time % at(last) } else { 0.0 };
        let next = (0..=last).find(|&index| at(index) > time).unwrap_or(last);
        let (from, to) = (&self.points[next.saturating_sub(1)], &self.points[next]);
        let span = to.time_from_start.seconds() - from.time_from_start.seconds();
        let part = if span > 0.0 { (time - from.time_from_start.seconds()) / span } else { 0.0 };
        let blend = |(a, b): (&f64, &f64)| a + part * (b - a);
        from.positions.iter().zip(&to.positions).map(blend).collect()
    }
}

impl Motion {
    /// Joint state at `time` (s); `None` while there is no robot to move.
    fn joint_state(&self, robot: &CurrentRobot, time: f64) -> Result<Option<Named>, ConfigurationError> {
        let robot = robot.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match (self, robot) {
            (Self::Trajectory(trajectory), robot) => {
                let named = (trajectory.joint_names.clone(), trajectory.sample(time));
                robot.map_or(Ok(named.clone()), |robot| with_leaders(&robot, named)).map(Some)
            }
            (Self::Sweep, robot) => {
                Ok(robot.map(|robot| (robot.position_names().to_vec(), sweep(&robot, time))))
            }
        }
    }
}

/// Joint names and their positions.
type Named = (Vec<String>, Vec<f64>);

/// Adds the leader joints of the named mimic joints. Names of joints that the robot does not have are kept: the monitor
/// reports them.
fn with_leaders(robot: &RobotModel, (mut names, mut positions): Named) -> Result<Named, ConfigurationError> {
    let Ok(named) = robot.named_joints(names.iter().map(String::as_str)) else {
        return Ok((names, positions));
    };
    let q = match named.configuration(&robot.default_configuration(), &positions) {
        Err(error @ ConfigurationError::Mimic(_)) => return Err(error),
        Err(_) => return Ok((names, positions)),
        Ok(q) => q,
    };
    let decided = robot.position_names().iter().zip(q.positions()).enumerate();
    let leaders: Vec<_> = decided
        .filter(|(position, (name, _))| named.decides(*position) && !names.contains(name))
        .map(|(_, (name, q))| (name.clone(), *q))
        .collect();
    for (name, position) in leaders {
        names.push(name);
        positions.push(position);
    }
    Ok((names, positions))
}

/// Positions at `time` (s) where each joint swings about the middle of its limits, with a different period per joint.
fn sweep(robot: &RobotModel, time: f64) -> Vec<f64> {
    /// Amplitude (rad, m) of a joint without limits.
    const FREE_SWING: f64 = 0.5;
    /// Amplitude as a fraction of the distance from the middle to a limit.
    const PART: f64 = 0.8;
    const SHORTEST_PERIOD: f64 = 20.0;
    let mut positions = robot.default_configuration().positions().to_vec();
    let joints = robot.joint_ids().filter_map(|id| Some((id, robot.first_position(id)?)));
    for (number, (id, index)) in joints.enumerate() {
        let joint = robot.joint(id);
        if joint.kind.position_suffixes().len() != 1 {
            continue;
        }
        let (middle, swing) = match joint.limits {
            Some(l) if l.lower.is_finite() && l.upper.is_finite() => {
                (0.5 * (l.lower + l.upper), 0.5 * PART * (l.upper - l.lower))
            }
            _ => (positions[index], FREE_SWING),
        };
        #[expect(clippy::cast_precision_loss, reason = "robots have fewer than 2^52 joints")]
        let period = SHORTEST_PERIOD * (1.0 + 0.13 * number as f64);
        positions[index] = middle + swing * (TAU * time / period).sin();
    }
    positions
}

/// Publishes a motion without end. The node's own monitor also receives it through a queue of one message: on a
/// loopback interface without multicast, which is the usual case, a process does not receive its own messages.
pub async fn play(
    motion: &Motion,
    robot: &CurrentRobot,
    clock: &RosClock,
    joint_states: &Publisher<JointState>,
    monitor: &Sender<JointState>,
) {
    let mut ticks = Timer::interval(PERIOD);
    let start = clock.steady();
    let mut last_error = None;
    loop {
        futures_lite::StreamExt::next(&mut ticks).await;
        let time = clock.steady().saturating_sub(start).as_secs_f64();
        let state = motion.joint_state(robot, time);
        if let Err(error) = &state
            && last_error.replace(error.to_string()).is_none()
        {
            log::error!("the demo motion is not published where it contradicts itself: {error}");
        }
        let (Ok(Some((name, position))), Some(now)) = (state, clock.now()) else {
            continue;
        };
        let message = JointState {
            header: Header { stamp: stamp_message(now), frame_id: String::new() },
            name,
            position,
            velocity: Vec::new(),
            effort: Vec::new(),
        };
        // skipped if the monitor has not taken the last message yet
        let _ = monitor.send(message.clone());
        joint_states.publish(message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_robot::MeshFiles;

    const TEXT: &str = "joint_names: [a, b]\npoints:\n\
        - {positions: [0, 1], time_from_start: {sec: 0, nanosec: 0}}\n\
        - {positions: [2, 1], time_from_start: {sec: 1, nanosec: 500000000}}\n\
        - {positions: [0, 1], time_from_start: {sec: 3, nanosec: 0}}\n";

    #[test]
    fn a_trajectory_is_straight_between_points_and_starts_again() {
        let trajectory = Trajectory::from_yaml(TEXT).unwrap();
        assert_eq!(trajectory.sample(0.0), [0.0, 1.0]);
        assert_eq!(trajectory.sample(0.75), [1.0, 1.0]);
        assert_eq!(trajectory.sample(1.5), [2.0, 1.0]);
        assert_eq!(trajectory.sample(3.75), [1.0, 1.0]);
    }

    #[test]
    fn a_mimic_joint_alone_moves_its_leader() {
        let joint = |name: &str, mimic: &str| {
            format!(
                "<link name='of_{name}'/><joint name='{name}' type='continuous'><parent link='base'/><child link='of_{name}'/>\
                 <axis xyz='0 0 1'/>{mimic}</joint>"
            )
        };
        let joints = [joint("drive", ""), joint("j", "<mimic joint='drive' multiplier='2'/>")].concat();
        let urdf = format!("<robot name='r'><link name='base'/>{joints}</robot>");
        let robot = RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap();
        let with_leaders = |names: &[&str], positions: &[f64]| {
            let names = names.iter().map(|name| (*name).to_owned()).collect();
            with_leaders(&robot, (names, positions.to_vec()))
        };
        let (names, positions) = with_leaders(&["j"], &[1.0]).unwrap();
        assert_eq!((names.join(" ").as_str(), positions), ("j drive", vec![1.0, 0.5]));
        assert!(with_leaders(&["drive", "j"], &[1.0, 1.0]).is_err());
        let of_another = with_leaders(&["arm"], &[1.0]).unwrap();
        assert_eq!(of_another, (vec!["arm".to_owned()], vec![1.0]));
    }

    #[test]
    fn broken_trajectories_are_rejected() {
        for bad in [
            "joint_names: [a]\npoints: []\n",
            "joint_names: [a]\npoints: [{positions: [], time_from_start: {sec: 0, nanosec: 0}}]\n",
            "points: 3",
        ] {
            assert!(Trajectory::from_yaml(bad).is_err(), "{bad}");
        }
    }
}
