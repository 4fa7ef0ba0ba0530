//! Checks of `clearance doctor` on received topics: robot, meshes, node, clock, joint states and stamps.

use clearance_checker::{CollisionChecker, solid_mesh_remarks};
use clearance_monitor::{Evaluation, Monitor, MonitorSettings, Reason, Revision, SourceId, Status, Time};
use clearance_robot::quoted_list;
use clearance_robot::{MeshFiles, RobotModel, RobotText};
use clearance_scene::World;
use clearance_scene::{MeshModel, Settings};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use crate::doctor::finding::{Finding, good, note, wrong};
use crate::doctor::received_topics::ReceivedTopics;
use crate::environment::Environment;
use crate::messages::joint_state::joint_state_input;
use crate::messages::time_and_geometry::time_of;
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
                "no message (latched) was received in domain {domain}: start robot_state_publisher, give --urdf FILE, or look at the namespace \
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
                "use_sim_time is set, and no message was received on /clock in domain {}: is the simulator running, or the bag played with --clock?",
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
                "no message was received in {seconds} s in domain {domain}: is the driver running, under this name and namespace \
                 (--ros-args -r joint_states:=NAME)?"
            ),
        )];
    };
    let rate = f64::from(received.joint_state_count) / duration.as_secs_f64();
    let mut findings = vec![good(about, format!("{rate:.0} a second, of {}", quoted_list(&first.name)))];
    let stamp_findings = check_joint_state_stamps(received, parameters.stale_after);
    let are_stamps_wrong = !stamp_findings.is_empty();
    findings.extend(stamp_findings);
    let Some(robot) = robot else {
        findings.push(note(about, "they are compared with no robot: there is none"));
        return findings;
    };
    findings.extend(check_transform_stamps(&robot, received, parameters));
    match evaluate(robot, mesh_model, received, parameters) {
        Err(error) => findings.push(wrong("robot", error)),
        Ok(evaluation) => {
            findings.extend(match &evaluation.status {
                Status::Free => Some(good(about, "the robot is free of itself")),
                Status::Colliding => Some(note(
                    about,
                    "links of the robot touch each other at this state: if they always do, an SRDF is missing",
                )),
                Status::Unknown(Reason::Stale { .. } | Reason::FutureStamp { .. }) if are_stamps_wrong => None,
                Status::Unknown(reason) => Some(wrong(about, reason.to_string())),
            });
            findings.extend(evaluation.warnings.iter().map(|warning| note(about, warning.clone())));
        }
    }
    findings
}

/// Findings about publishers of joint states whose stamps are all more than `stale_after` (s) from the clock.
fn check_joint_state_stamps(received: &ReceivedTopics, stale_after: f64) -> Vec<Finding> {
    let mut ages: BTreeMap<SourceId, f64> = BTreeMap::new();
    for (message, publisher, received_at) in &received.joint_states {
        // a message without a stamp has the time of its reception
        let stamp = Some(time_of(&message.header.stamp)).filter(|stamp| *stamp != Time::ZERO);
        if let Some((ros, stamp)) = received_at.ros.zip(stamp) {
            note_age(ages.entry(*publisher).or_insert(f64::INFINITY), ros.seconds_since(stamp));
        }
    }
    let deviating = ages.into_values().filter(|age| age.abs() > stale_after);
    let fault = |age: f64| {
        wrong("joint_states", format!("header.stamp {}", deviation(age, "stale_after", stale_after)))
    };
    deviating.map(fault).collect()
}

/// Findings about transforms of `transform_joints` whose stamps are all more than `transform_ttl` from the clock.
fn check_transform_stamps(
    robot: &RobotModel,
    received: &ReceivedTopics,
    parameters: &Parameters,
) -> Vec<Finding> {
    let mut frames = BTreeSet::new();
    for name in &parameters.transform_joints {
        let Some(joint) = robot.joint_by_name(name).map(|id| robot.joint(id)) else { continue };
        let [parent, child] = [joint.parent, joint.child].map(|link| robot.link(link).name.as_str());
        if let Some(path) = received.transforms.path(parent, child) {
            frames.extend(path.stamped_links().map(|(frame, _)| frame));
        }
    }
    let ttl = parameters.transform_ttl;
    let ages = frames.into_iter().filter_map(|frame| Some((frame, *received.transform_ages.get(frame)?)));
    let fault = |(frame, age): (&str, f64)| {
        wrong("tf", format!("the stamp of frame '{frame}' {}", deviation(age, "transform_ttl", ttl)))
    };
    ages.filter(|(_, age)| age.abs() > ttl).map(fault).collect()
}

/// Keeps the age (s) that is nearest to zero: that of the message that waited least.
pub fn note_age(least: &mut f64, age: f64) {
    if age.abs() < least.abs() {
        *least = age;
    }
}

/// Text about an age (s) beyond the limit of a parameter.
fn deviation(age: f64, parameter: &str, limit: f64) -> String {
    let side = if age > 0.0 { "past" } else { "future" };
    format!(
        "lies {:.3} s in the {side}, more than {parameter} ({limit} s): synchronise the clocks of the machines, or set \
         use_sim_time where its publisher does",
        age.abs()
    )
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
    // the messages waited while other topics were received, so their age does not count; see `check_joint_state_stamps`
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
    use crate::messages::time_and_geometry::stamp_message;
    use clearance_geometry::math::Pose;
    use clearance_monitor::Now;
    use clearance_scene::Transform;
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

    #[test]
    fn stamps_of_another_clock_are_wrong_for_each_publisher() {
        let received_at = RosClock::new(false).read();
        let stamped = |publisher: u8, age: i64| {
            let mut state = JointState::default();
            let nanoseconds = received_at.ros.unwrap().nanoseconds() - age * 1_000_000;
            state.header.stamp = stamp_message(Time::from_nanoseconds(nanoseconds));
            (state, SourceId([publisher; 16]), received_at)
        };
        let check = |joint_states: Vec<(JointState, SourceId, Now)>| {
            let received = ReceivedTopics { joint_states, ..ReceivedTopics::default() };
            check_joint_state_stamps(&received, 0.5)
        };
        let unstamped = (JointState::default(), SourceId([4; 16]), received_at);
        // ages in milliseconds; a message may have waited
        assert_eq!(check(vec![stamped(1, 10), stamped(1, 900), stamped(2, -100), unstamped]), []);
        let findings = check(vec![stamped(1, 3200), stamped(1, 3000), stamped(2, 10), stamped(3, -100_000)]);
        let texts: Vec<&str> = findings.iter().map(|finding| finding.text.as_str()).collect();
        assert_eq!(texts.len(), 2, "{texts:?}");
        assert!(texts[0].starts_with("header.stamp lies 3.000 s in the past, more than stale_after (0.5 s)"));
        assert!(texts[1].contains("100.000 s in the future") && texts[1].contains("use_sim_time"));
    }

    #[test]
    fn transforms_of_joints_with_stamps_of_another_clock_are_wrong() {
        let urdf = "<robot name='cart'><link name='room'/><link name='cart'/>
            <joint name='drive' type='planar'><parent link='room'/><child link='cart'/><axis xyz='0 0 1'/></joint></robot>";
        let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
        let now = Time::from_nanoseconds(1_000_000_000);
        let mut received = ReceivedTopics::default();
        let transform = Transform { parent: "room".to_owned(), pose_pf: Pose::identity(), stamp: Some(now) };
        received.transforms.insert_received("cart", transform, Some(now));
        let parameters = Parameters { transform_joints: vec!["drive".to_owned()], ..Parameters::default() };
        let mut check = |age: f64| {
            received.transform_ages = BTreeMap::from([("cart".to_owned(), age), ("other".to_owned(), 9.0)]);
            check_transform_stamps(&robot, &received, &parameters)
        };
        assert_eq!(check(0.1), []);
        let findings = check(-3.0);
        assert!(findings.len() == 1 && findings[0].about == "tf", "{findings:?}");
        assert!(findings[0].text.starts_with("the stamp of frame 'cart' lies 3.000 s in the future"));
    }
}
