//! `clearance doctor`: what keeps the node from working here, found by listening for a while.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::sync::Arc;
use std::time::{Duration, Instant};

use futures_lite::future;
use log::Level;
use ros2_interfaces_jazzy_serde::rosgraph_msgs::msg::Clock;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::JointState;
use ros2_interfaces_jazzy_serde::std_msgs::msg::String as StringMessage;
use ros2_interfaces_jazzy_serde::tf2_msgs::msg::TFMessage;
use serde::Serialize;
use smol::Timer;

use super::arguments::RosArguments;
use super::clock::RosClock;
use super::environment::{Environment, EnvironmentError, Reach};
use super::logging;
use super::messages::{joint_state_input, time_of};
use super::middleware::{MessageKind, Middleware, Quality, Subscription};
use super::names::Names;
use super::parameter_files;
use super::parameters::Parameters;
use super::run::{NODE_NAME, NodeError};
use super::scene::note_transforms;
use crate::checker::{CollisionChecker, Settings};
use crate::monitor::scene::TransformTree;
use crate::monitor::{
    Judgement, Monitor, MonitorSettings, Now, Revision, SourceId, Status, Time, quoted_list,
};
use crate::robot::{MeshFiles, RobotModel, RobotText};
use crate::world::World;

/// One thing that was looked at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    pub verdict: Verdict,
    /// What was looked at, such as `joint_states`.
    pub about: String,
    pub text: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    Good,
    /// Worth knowing.
    Note,
    /// The node can not work like this, or not with these peers.
    Wrong,
}

impl Verdict {
    fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Note => "note",
            Self::Wrong => "wrong",
        }
    }
}

/// What is to be examined.
#[derive(Debug)]
pub struct Patient {
    pub arguments: RosArguments,
    /// Without a robot it is awaited on `robot_description`.
    pub robot: Option<RobotModel>,
    pub mesh_files: MeshFiles,
    /// How long topics are listened to.
    pub patience: Duration,
}

/// Everything that came in that time.
#[derive(Default)]
struct Heard {
    description: Option<String>,
    semantic: Option<String>,
    /// The first ones, and when they came.
    joint_states: Vec<(JointState, SourceId, Now)>,
    /// How many came.
    joint_state_count: u32,
    transforms: TransformTree,
    /// What simulated time there is, if it was asked for.
    simulated_time: Option<Time>,
    /// What the middleware complained about.
    complaints: Vec<String>,
}

/// Looks at everything.
pub fn examine(patient: Patient) -> Result<Vec<Finding>, NodeError> {
    let mut findings = Vec::new();
    let variable = |name: &str| std::env::var(name).ok();
    let environment = match network(variable, &mut findings) {
        Ok(environment) => environment,
        Err(error) => {
            findings.push(wrong("environment", error.to_string()));
            return Ok(findings);
        }
    };
    findings.push(multicast(environment.reach));
    let names = Names::new(NODE_NAME, &patient.arguments.remaps)?;
    let (parameters, _) =
        parameter_files::initial(Parameters::default(), &patient.arguments.parameters, &names)
            .map_err(|fault| NodeError::Input(fault.to_string()))?;
    let robot_is_wanted = patient.robot.is_none();
    let heard = listen(environment, &names, (robot_is_wanted, parameters.use_sim_time), patient.patience)?;
    if parameters.use_sim_time {
        findings.push(about_clock(&heard, environment));
    }
    findings.extend(heard.complaints.iter().map(|text| wrong("peers", text.clone())));
    let robot = match patient.robot {
        Some(robot) => Some(robot),
        None => described(&heard, &patient.mesh_files, environment, &mut findings),
    };
    let robot = robot.map(|robot| robot.with_prefixes(&parameters.joint_prefix, &parameters.link_prefix));
    if let Some(robot) = &robot {
        findings.extend(about_robot(robot));
    }
    findings.extend(about_joint_states(&heard, robot, &parameters, (environment, patient.patience)));
    Ok(bounded(findings))
}

/// The same, of which no peer can make more than a person reads, or anything that a terminal obeys.
fn bounded(findings: Vec<Finding>) -> Vec<Finding> {
    const MOST: usize = 20;
    const LONGEST: usize = 1000;
    let readable = |text: &str| {
        let mut readable: String = text
            .chars()
            .map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c })
            .take(LONGEST)
            .collect();
        if text.chars().nth(LONGEST).is_some() {
            readable.push('…');
        }
        readable
    };
    let mut counts: BTreeMap<(String, &str), usize> = BTreeMap::new();
    let mut told = Vec::new();
    for Finding { verdict, about, text } in findings {
        let count = counts.entry((about.clone(), verdict.word())).or_default();
        *count += 1;
        if *count <= MOST {
            told.push(Finding { verdict, about, text: readable(&text) });
        }
    }
    for ((about, word), count) in counts {
        if count > MOST {
            told.push(note(&about, format!("{} more of the kind '{word}' are not listed", count - MOST)));
        }
    }
    told
}

fn good(about: &str, text: impl Into<String>) -> Finding {
    Finding { verdict: Verdict::Good, about: about.to_owned(), text: text.into() }
}

fn note(about: &str, text: impl Into<String>) -> Finding {
    Finding { verdict: Verdict::Note, about: about.to_owned(), text: text.into() }
}

fn wrong(about: &str, text: impl Into<String>) -> Finding {
    Finding { verdict: Verdict::Wrong, about: about.to_owned(), text: text.into() }
}

/// What the variables say about the network.
fn network(
    variable: impl Fn(&str) -> Option<String>,
    findings: &mut Vec<Finding>,
) -> Result<Environment, EnvironmentError> {
    let environment = Environment::read(&variable)?;
    let Environment { domain, reach } = environment;
    findings.push(good(
        "environment",
        match reach {
            Reach::Subnet => format!("domain {domain}, all of the network"),
            Reach::Localhost => format!("domain {domain}, this machine only"),
        },
    ));
    let set = |name| variable(name).filter(|value| !value.is_empty());
    match set("RMW_IMPLEMENTATION").as_deref() {
        Some("rmw_zenoh_cpp") => findings.push(wrong(
            "environment",
            "RMW_IMPLEMENTATION is rmw_zenoh_cpp: its nodes do not speak DDS, and this one speaks nothing else; use rmw_fastrtps_cpp \
             or rmw_cyclonedds_cpp",
        )),
        Some(other) => findings.push(good("environment", format!("RMW_IMPLEMENTATION is {other}"))),
        None => {}
    }
    for name in ["ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER"] {
        if let Some(value) = set(name) {
            findings.push(wrong(
                "environment",
                format!("{name} is '{value}', which this node does not heed: peers are found by multicast"),
            ));
        }
    }
    Ok(environment)
}

/// Whether what is said to a group is heard, which is how nodes meet.
fn multicast(reach: Reach) -> Finding {
    let interface = match reach {
        Reach::Localhost => Ipv4Addr::LOCALHOST,
        Reach::Subnet => Ipv4Addr::UNSPECIFIED,
    };
    let about = "multicast";
    match heard_by_group(interface) {
        Ok(true) => good(about, "what is sent to a group comes back"),
        Ok(false) => wrong(
            about,
            "what is sent to a group does not come back: a firewall, or an interface without multicast (ip link set lo multicast on)",
        ),
        Err(error) => wrong(about, format!("{error}: is there a route (ip route add 224.0.0.0/4 dev lo)?")),
    }
}

fn heard_by_group(interface: Ipv4Addr) -> std::io::Result<bool> {
    const GROUP: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);
    const WORD: &[u8] = b"clearance doctor";
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    socket.join_multicast_v4(&GROUP, &interface)?;
    socket.set_multicast_loop_v4(true)?;
    socket.set_read_timeout(Some(Duration::from_secs(1)))?;
    let port = socket.local_addr()?.port();
    socket.send_to(WORD, SocketAddrV4::new(GROUP, port))?;
    let mut heard = [0; 64];
    let deadline = Instant::now() + Duration::from_secs(1);
    while Instant::now() < deadline {
        match socket.recv_from(&mut heard) {
            Ok((length, _)) if &heard[..length] == WORD => return Ok(true),
            Ok(_) => {}
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => return Ok(false),
            Err(error) => return Err(error),
        }
    }
    Ok(false)
}

/// Hears what there is to hear, for a while.
fn listen(
    environment: Environment,
    names: &Names,
    (describe, use_sim_time): (bool, bool),
    patience: Duration,
) -> Result<Heard, NodeError> {
    /// Joint states, and names and numbers in all of them, that are kept for the monitor.
    const MOST: usize = 10_000;
    const MOST_NUMBERS: usize = 1_000_000;
    const MOST_COMPLAINTS: usize = 100;
    let lines = logging::listen();
    let middleware = Middleware::join(environment, names.namespace(), &format!("{NODE_NAME}_doctor"))?;
    let text = MessageKind("std_msgs", "String");
    let states = middleware.subscription::<JointState>(
        &names.resolve("joint_states")?,
        MessageKind("sensor_msgs", "JointState"),
        Quality::BestEffort,
    )?;
    let [descriptions, semantics] = ["robot_description", "robot_description_semantic"].map(|name| {
        let name = names.resolve(name)?;
        Ok::<_, NodeError>(middleware.subscription::<StringMessage>(&name, text, Quality::Latched)?)
    });
    let (descriptions, semantics) = (descriptions?, semantics?);
    let kind = MessageKind("tf2_msgs", "TFMessage");
    let [moving, fixed] =
        [("tf", Quality::BestEffort), ("tf_static", Quality::Kept)].map(|(name, quality)| {
            Ok::<_, NodeError>(middleware.subscription::<TFMessage>(&names.resolve(name)?, kind, quality)?)
        });
    let (moving, fixed) = (moving?, fixed?);
    let clock = RosClock::new(use_sim_time);
    let kind = MessageKind("rosgraph_msgs", "Clock");
    let clock_topic = names.resolve("/clock")?;
    let subscribe = || middleware.subscription::<Clock>(&clock_topic, kind, Quality::BestEffort);
    let ticks = use_sim_time.then(subscribe).transpose()?;
    let tree = RefCell::new(TransformTree::default());
    let mut heard = Heard::default();
    let Heard { description, semantic, joint_states, joint_state_count, complaints, .. } = &mut heard;
    let mut numbers = 0;
    smol::block_on(future::or(drop_after(patience), async {
        let hear_states = async {
            loop {
                let (state, origin) = states.next().await;
                *joint_state_count = joint_state_count.saturating_add(1);
                numbers +=
                    state.name.len() + state.position.len() + state.velocity.len() + state.effort.len();
                if joint_states.is_empty() || (joint_states.len() < MOST && numbers < MOST_NUMBERS) {
                    joint_states.push((state, origin.publisher, clock.read()));
                }
            }
        };
        let hear_description = async {
            if describe {
                loop {
                    *description = Some(descriptions.next().await.0.data);
                }
            }
        };
        let hear_semantic = async {
            loop {
                *semantic = Some(semantics.next().await.0.data);
            }
        };
        let hear_transforms = async |topic: &Subscription<TFMessage>, fixed: bool| {
            loop {
                let (message, _) = topic.next().await;
                note_transforms(&mut tree.borrow_mut(), message, clock.now(), fixed);
            }
        };
        let hear_complaints = async {
            while let Ok(line) = lines.recv().await {
                let is_new = complaints.len() < MOST_COMPLAINTS && !complaints.contains(&line.text);
                if line.level <= Level::Warn && is_new {
                    complaints.push(line.text);
                }
            }
        };
        let follow_clock = async {
            if let Some(ticks) = &ticks {
                loop {
                    clock.on_simulation_time(time_of(&ticks.next().await.0.clock));
                }
            }
        };
        let robot = future::zip(future::zip(hear_description, hear_semantic), follow_clock);
        let transforms = future::zip(hear_transforms(&moving, false), hear_transforms(&fixed, true));
        let topics = future::zip(hear_states, future::zip(robot, transforms));
        future::zip(topics, future::zip(hear_complaints, middleware.meet_peers())).await;
    }));
    heard.transforms = tree.into_inner();
    heard.simulated_time = use_sim_time.then(|| clock.now()).flatten();
    drop((states, descriptions, semantics, moving, fixed, ticks));
    middleware.leave();
    Ok(heard)
}

async fn drop_after(patience: Duration) {
    Timer::after(patience).await;
}

/// The robot that is described on the topics.
fn described(
    heard: &Heard,
    mesh_files: &MeshFiles,
    environment: Environment,
    findings: &mut Vec<Finding>,
) -> Option<RobotModel> {
    let about = "robot_description";
    let Some(urdf) = &heard.description else {
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
        srdf: heard.semantic.as_deref(),
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

fn about_robot(robot: &RobotModel) -> Vec<Finding> {
    let (links, positions) = (robot.links().len(), robot.position_names().len());
    let mut findings =
        vec![good("robot", format!("'{}': {links} links, {positions} positions", robot.name()))];
    findings.extend(robot.warnings().iter().map(|warning| note("robot", warning.to_string())));
    if robot.srdf().is_none() {
        findings.push(note("robot", "there is no SRDF: only pairs of adjacent bodies are left out"));
    }
    findings
}

/// Whether there is the time that was asked for.
fn about_clock(heard: &Heard, environment: Environment) -> Finding {
    match heard.simulated_time {
        Some(time) => good("clock", format!("simulated time is told; the last: {:.3} s", seconds(time))),
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

/// Whether what the drivers say is about this robot: the monitor itself judges.
fn about_joint_states(
    heard: &Heard,
    robot: Option<RobotModel>,
    parameters: &Parameters,
    (environment, patience): (Environment, Duration),
) -> Vec<Finding> {
    let about = "joint_states";
    let Some((first, ..)) = heard.joint_states.first() else {
        let (domain, seconds) = (environment.domain, patience.as_secs_f64());
        return vec![wrong(
            about,
            format!(
                "nobody published one in {seconds} s in domain {domain}: is the driver running, under this name and namespace \
                 (--ros-args -r joint_states:=NAME)?"
            ),
        )];
    };
    let rate = f64::from(heard.joint_state_count) / patience.as_secs_f64();
    let mut findings = vec![good(about, format!("{rate:.0} a second, of {}", quoted_list(&first.name)))];
    let Some(robot) = robot else {
        findings.push(note(about, "they are compared with no robot: there is none"));
        return findings;
    };
    match judge(robot, heard, parameters) {
        Err(error) => findings.push(wrong("robot", error)),
        Ok(judgement) => {
            findings.push(match &judgement.status {
                Status::Free => good(about, "the robot is free of itself"),
                Status::Colliding => note(
                    about,
                    "links of the robot touch each other at this state: if they always do, an SRDF is missing",
                ),
                Status::Unknown(reason) => wrong(about, reason.to_string()),
            });
            findings.extend(judgement.warnings.iter().map(|warning| note(about, warning.clone())));
        }
    }
    findings
}

/// What the monitor says to transforms, and joint states that came one after the other.
fn judge(robot: RobotModel, heard: &Heard, parameters: &Parameters) -> Result<Judgement, String> {
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default());
    let checker = checker.map_err(|error| error.to_string())?;
    // they waited here while others were listened to
    let settings = MonitorSettings {
        stale_after: 3600.0,
        transform_ttl: 3600.0,
        joint_prefix: parameters.joint_prefix.clone(),
        transform_joints: parameters.transform_joints.clone(),
        ..MonitorSettings::default()
    };
    let mut monitor = Monitor::new(settings, || Duration::ZERO);
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 0)));
    monitor.note_transforms(&heard.transforms);
    let mut judgement = None;
    for (message, publisher, came) in &heard.joint_states {
        judgement = Some(monitor.on_joint_state(joint_state_input(message.clone(), *publisher), *came));
    }
    judgement.ok_or_else(|| "no joint state came".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_peers_make_up_is_told_briefly_and_is_no_terminals_command() {
        let many = (0..5000).map(|number| wrong("peers", format!("peer {number}")));
        let long = good("joint_states", format!("\u{1b}[2J{}", "x".repeat(100_000)));
        let told = bounded(many.chain([long, good("robot", "'ur5e'")]).collect());
        assert_eq!(told.len(), 20 + 2 + 1);
        assert!(told.last().unwrap().text.starts_with("4980 more of the kind 'wrong'"), "{told:?}");
        let long = &told[20].text;
        assert!(long.starts_with("\u{fffd}[2J") && long.ends_with('…') && long.chars().count() == 1001);
        assert_eq!(told[21], good("robot", "'ur5e'"));
        assert_eq!(bounded(told.clone())[..20], told[..20]);
    }

    #[test]
    fn names_of_joints_are_listed_briefly() {
        let name = (0..100_000).map(|number| format!("joint{number}")).collect();
        let state = JointState { name, ..JointState::default() };
        let came = RosClock::new(false).read();
        let joint_states = vec![(state, SourceId([1; 16]), came)];
        let heard = Heard { joint_states, joint_state_count: 1, ..Heard::default() };
        let environment = Environment::read(|_| None).unwrap();
        let patience = (environment, Duration::from_secs(1));
        let findings = about_joint_states(&heard, None, &Parameters::default(), patience);
        assert!(findings[0].text.contains("'joint0'") && findings[0].text.len() < 1000, "{findings:?}");
    }

    #[test]
    fn variables_that_part_the_network_are_wrong() {
        let look = |variables: &[(&str, &str)]| {
            let mut findings = Vec::new();
            let get = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned());
            network(get, &mut findings).map(|_| findings)
        };
        let verdicts = |variables: &[(&str, &str)]| {
            look(variables).unwrap().into_iter().map(|finding| finding.verdict).collect::<Vec<_>>()
        };
        assert_eq!(verdicts(&[]), [Verdict::Good]);
        assert_eq!(verdicts(&[("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")]), [Verdict::Good; 2]);
        assert_eq!(verdicts(&[("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")]), [Verdict::Good, Verdict::Wrong]);
        assert_eq!(verdicts(&[("ROS_STATIC_PEERS", "10.0.0.1")]), [Verdict::Good, Verdict::Wrong]);
        assert!(look(&[("ROS_DOMAIN_ID", "x")]).is_err());
    }
}
