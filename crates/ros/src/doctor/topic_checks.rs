//! Evaluates the received topics.

use clearance_checker::{CollisionChecker, solid_mesh_remarks};
use clearance_monitor::{Evaluation, Monitor, MonitorSettings, Revision, Status, Time};
use clearance_robot::quoted_list;
use clearance_robot::{MeshFiles, RobotModel, RobotText};
use clearance_scene::World;
use clearance_scene::{MeshModel, Settings};
use std::sync::Arc;
use std::time::Duration;

use crate::doctor::finding::{Finding, good, note, wrong};
use crate::doctor::received_topics::ReceivedTopics;
use crate::environment::Environment;
use crate::messages::joint_state::joint_state_input;
use crate::parameters::parameter_set::Parameters;

/// The robot model from the description topics.
pub fn robot_model(
    received: &ReceivedTopics,
    mesh_files: &MeshFiles,
    environment: Environment,
    findings: &mut Vec<Finding>,
) -> Option<RobotModel> {
    let about = "robot_description";
    let Some(urdf) = &received.description else {
        let domain = environment.domain;
        findings.push(wrong(
            about,
            format!(
                "nobody published it (latched) in domain {domain}: start robot_state_publisher, give --urdf FILE, or look at the namespace \
                 (--ros-args -r __ns:=/NAME) and ROS_DOMAIN_ID"
            ),
        ));
        return None;
    };
    let text = RobotText {
        urdf,
        urdf_name: Some(about),
        srdf: received.semantic.as_deref(),
        srdf_name: Some("robot_description_semantic"),
    };
    match RobotModel::from_text(&text, mesh_files) {
        Ok(robot) => Some(robot),
        Err(error) => {
            findings.push(wrong(about, error.to_string()));
            None
        }
    }
}

pub fn check_robot(robot: &RobotModel) -> Vec<Finding> {
    let (links, positions) = (robot.links().len(), robot.position_names().len());
    let mut findings =
        vec![good("robot", format!("'{}': {links} links, {positions} positions", robot.name()))];
    findings.extend(robot.warnings().iter().map(|warning| note("robot", warning.to_string())));
    match robot.srdf() {
        None => findings.push(note("robot", "there is no SRDF: only pairs of adjacent bodies are left out")),
        Some(srdf) if srdf.robot_name != robot.name() && srdf.disabled_pairs.is_empty() => {
            findings.push(wrong(
                "robot",
                format!(
                    "the SRDF is of '{}' and leaves out no pair of '{}': is it the right file?",
                    srdf.robot_name,
                    robot.name()
                ),
            ));
        }
        Some(_) => {}
    }
    findings
}

/// Findings about meshes that are not valid solids.
pub fn check_meshes(robot: &RobotModel, mesh_model: MeshModel) -> Vec<Finding> {
    if mesh_model == MeshModel::Surface {
        return Vec::new();
    }
    let remarks = solid_mesh_remarks(robot, &World::default());
    remarks.iter().map(|remark| note("solid meshes", remark.to_string())).collect()
}

/// Whether the node runs, and whether it is the only one with its name.
pub fn check_node(received: &ReceivedTopics, name: &str) -> Finding {
    match received.nodes_of_same_name {
        0 => note(
            "node",
            format!("no node is named {name} yet: start it, or look for it in another namespace"),
        ),
        1 => good("node", format!("{name} is there")),
        count => wrong(
            "node",
            format!(
                "{count} nodes are named {name}: they publish on the same topics and answer the same requests; give each a \
                 namespace (--ros-args -r __ns:=/NAME) or name (-r __node:=NAME)"
            ),
        ),
    }
}

/// Whether the selected clock is available.
pub fn check_clock(received: &ReceivedTopics, environment: Environment) -> Finding {
    match received.simulated_time {
        Some(time) => good("clock", format!("simulated time is published; the last: {:.3} s", seconds(time))),
        None => wrong(
            "clock",
            format!(
                "use_sim_time is set, and nobody published /clock in domain {}: is the simulator running, or the bag played with --clock?",
                environment.domain
            ),
        ),
    }
}

#[expect(clippy::cast_precision_loss, reason = "it is told to a person")]
fn seconds(time: Time) -> f64 {
    1e-9 * time.nanoseconds() as f64
}

/// Input of the check of joint states.
pub struct JointStateCheck<'r> {
    pub received: &'r ReceivedTopics,
    pub robot: Option<RobotModel>,
    pub mesh_model: MeshModel,
    pub parameters: &'r Parameters,
    pub environment: Environment,
    /// Time during which joint states were received.
    pub duration: Duration,
}

/// Whether the joint states match this robot: evaluates them with the monitor.
pub fn check_joint_states(input: JointStateCheck<'_>) -> Vec<Finding> {
    let JointStateCheck { received, robot, mesh_model, parameters, environment, duration } = input;
    let about = "joint_states";
    let Some((first, ..)) = received.joint_states.first() else {
        let (domain, seconds) = (environment.domain, duration.as_secs_f64());
        return vec![wrong(
            about,
            format!(
                "nobody published one in {seconds} s in domain {domain}: is the driver running, under this name and namespace \
                 (--ros-args -r joint_states:=NAME)?"
            ),
        )];
    };
    let rate = f64::from(received.joint_state_count) / duration.as_secs_f64();
    let mut findings = vec![good(about, format!("{rate:.0} a second, of {}", quoted_list(&first.name)))];
    let Some(robot) = robot else {
        findings.push(note(about, "they are compared with no robot: there is none"));
        return findings;
    };
    match evaluate(robot, mesh_model, received, parameters) {
        Err(error) => findings.push(wrong("robot", error)),
        Ok(evaluation) => {
            findings.push(match &evaluation.status {
                Status::Free => good(about, "the robot is free of itself"),
                Status::Colliding => note(
                    about,
                    "links of the robot touch each other at this state: if they always do, an SRDF is missing",
                ),
                Status::Unknown(reason) => wrong(about, reason.to_string()),
            });
            findings.extend(evaluation.warnings.iter().map(|warning| note(about, warning.clone())));
        }
    }
    findings
}

/// Result of the monitor for the transforms, and for joint states processed one after the other.
fn evaluate(
    robot: RobotModel,
    mesh_model: MeshModel,
    received: &ReceivedTopics,
    parameters: &Parameters,
) -> Result<Evaluation, String> {
    let settings = Settings { mesh_model, ..Settings::default() };
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), settings);
    let checker = checker.map_err(|error| error.to_string())?;
    // the messages waited while other topics were received, so their age does not count
    let settings = MonitorSettings {
        stale_after: 3600.0,
        transform_ttl: 3600.0,
        joint_prefix: parameters.joint_prefix.clone(),
        transform_joints: parameters.transform_joints.clone(),
        ..MonitorSettings::default()
    };
    let mut monitor = Monitor::new(settings, || Duration::ZERO);
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 0)));
    monitor.note_transforms(&received.transforms);
    let mut evaluation = None;
    for (message, publisher, received_at) in &received.joint_states {
        evaluation =
            Some(monitor.on_joint_state(joint_state_input(message.clone(), *publisher), *received_at));
    }
    evaluation.ok_or_else(|| "no joint state came".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::RosClock;
    use clearance_monitor::SourceId;
    use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;

    #[test]
    fn names_of_joints_are_listed_briefly() {
        let name = (0..100_000).map(|number| format!("joint{number}")).collect();
        let state = JointState { name, ..JointState::default() };
        let received_at = RosClock::new(false).read();
        let joint_states = vec![(state, SourceId([1; 16]), received_at)];
        let received = ReceivedTopics { joint_states, joint_state_count: 1, ..ReceivedTopics::default() };
        let environment = Environment::read(|_| None).unwrap();
        let findings = check_joint_states(JointStateCheck {
            received: &received,
            robot: None,
            mesh_model: MeshModel::Surface,
            parameters: &Parameters::default(),
            environment,
            duration: Duration::from_secs(1),
        });
        assert!(findings[0].text.contains("'joint0'") && findings[0].text.len() < 1000, "{findings:?}");
    }
}
