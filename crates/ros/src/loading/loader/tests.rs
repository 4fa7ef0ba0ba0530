//! Tests of the loader: a replaced robot is freed, and a monitor that has ended is not waited for.

use std::time::Duration;

use clearance_monitor::{JointStateHistory, Monitor, SourceId, Time};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::{JointState, PointCloud2, PointField};

use super::*;
use crate::messages::joint_state::joint_state_input;
use crate::messages::time_and_geometry::stamp_message;
use crate::scene::scene_update_context::robots_at_stamps;
use clearance_monitor::Now;

/// URDF of a robot with this name: one sphere that rotates about z.
fn urdf(name: &str) -> String {
    format!(
        "<robot name='{name}'><link name='base'/>
         <link name='ball'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>
         <joint name='turn' type='continuous'><parent link='base'/><child link='ball'/><axis xyz='0 0 1'/></joint></robot>"
    )
}

fn cloud() -> PointCloud2 {
    let field = |name: &str, offset| PointField {
        name: name.to_owned(),
        offset,
        datatype: PointField::FLOAT32,
        count: 1,
    };
    let mut message = PointCloud2 {
        height: 1,
        width: 1,
        fields: vec![field("x", 0), field("y", 4), field("z", 8)],
        point_step: 12,
        row_step: 12,
        data: [1.0_f32; 3].iter().flat_map(|number| number.to_le_bytes()).collect(),
        ..PointCloud2::default()
    };
    message.header.frame_id = "base".to_owned();
    message
}

/// Loader and monitor of a node, without a network.
struct Cell {
    loader: Loader,
    monitor: Monitor,
    joint_state_history: JointStateHistory,
    evaluation: Option<clearance_monitor::Evaluation>,
    parameters: Parameters,
}

impl Cell {
    fn pass(
        &mut self,
        milliseconds: u64,
        commands: Vec<LoaderCommand>,
        clouds: BTreeMap<String, CloudMessage>,
    ) {
        let robots_at_stamps =
            robots_at_stamps(&clouds, &self.joint_state_history, self.parameters.stale_after);
        let evaluation = self.evaluation.clone();
        let update_context = SceneUpdateContext {
            evaluation,
            robots_at_stamps,
            ..SceneUpdateContext::first(&self.parameters, now(milliseconds))
        };
        let monitor = &mut self.monitor;
        self.loader.process(Pass { update_context, commands, clouds }, |event| match event {
            MonitorEvent::Checker(revision) => monitor.set_checker(revision),
            MonitorEvent::ModelFault(fault) => panic!("{fault}"),
            _ => {}
        });
    }

    fn turn(&mut self, milliseconds: u64) {
        let now = now(milliseconds);
        let mut message =
            JointState { name: vec!["turn".to_owned()], position: vec![0.5], ..JointState::default() };
        message.header.stamp = stamp_message(now.ros.unwrap());
        let input = joint_state_input(message, SourceId([1; 16]));
        let evaluation = self.monitor.on_joint_state(input, now);
        self.joint_state_history.note(&evaluation, now.ros);
        self.evaluation = Some(evaluation);
    }
}

fn now(milliseconds: u64) -> Now {
    let nanoseconds = i64::try_from(milliseconds * 1_000_000).unwrap();
    let ros = Time::from_nanoseconds(1_700_000_000_000_000_000 + nanoseconds);
    Now { ros: Some(ros), steady: Duration::from_millis(milliseconds) }
}

#[test]
fn a_robot_that_is_replaced_is_freed() {
    let parameters = Parameters { point_cloud_topics: vec!["points".to_owned()], ..Parameters::default() };
    let surroundings: Surroundings = Box::new(|_| Ok(Scene::default()));
    let mut cell = Cell {
        loader: Loader::new(MeshFiles::default(), surroundings, MeshModel::Surface),
        monitor: Monitor::new(parameters.monitor_settings(), || Duration::ZERO),
        joint_state_history: JointStateHistory::default(),
        evaluation: None,
        parameters,
    };
    cell.pass(1000, vec![LoaderCommand::Description(urdf("first"))], BTreeMap::new());
    cell.turn(1010);
    let changed = CloudMessage {
        cloud: Arc::new(cloud()),
        received_at: now(1020),
        since: std::time::Instant::now(),
        is_shared: false,
    };
    cell.pass(1020, vec![LoaderCommand::Clouds], BTreeMap::from([("points".to_owned(), changed)]));
    cell.turn(1030);
    let revision = cell.evaluation.as_ref().unwrap().revision.as_ref().unwrap();
    assert_eq!(revision.checker.world().obstacles().count(), 1, "the cloud was taken");
    let (first, revision) = (Arc::downgrade(revision.checker.robot()), Arc::downgrade(revision));
    assert!(first.upgrade().is_some() && revision.upgrade().is_some());

    cell.pass(1040, vec![LoaderCommand::Description(urdf("second"))], BTreeMap::new());
    // the configuration of the second robot is unknown
    cell.evaluation = Some(cell.monitor.on_heartbeat(now(1050)));
    cell.joint_state_history.note(cell.evaluation.as_ref().unwrap(), now(1050).ros);
    assert_eq!(cell.evaluation.as_ref().unwrap().revision.as_ref().unwrap().checker.robot().name(), "second");
    assert!(revision.upgrade().is_none(), "the checker of the first robot is still there");
    assert!(first.upgrade().is_none(), "the first robot is still there");
}

/// A received message counts as waiting until a world contains it, or the loader reports that nothing is to be built.
#[test]
fn the_monitor_knows_how_many_messages_a_world_has_before_it_comes() {
    let surroundings: Surroundings = Box::new(|_| Ok(Scene::default()));
    let mut loader = Loader::new(MeshFiles::default(), surroundings, MeshModel::Surface);
    let parameters = Parameters::default();
    let mut told = |milliseconds, commands| {
        let update_context = SceneUpdateContext::first(&parameters, now(milliseconds));
        let mut events = Vec::new();
        loader
            .process(Pass { update_context, commands, clouds: BTreeMap::new() }, |event| events.push(event));
        let names = events.iter().map(|event| match event {
            MonitorEvent::WorldUpdate(WorldUpdate::Completing(update_count)) => {
                format!("completing {update_count}")
            }
            MonitorEvent::Checker(_) => "checker".to_owned(),
            MonitorEvent::World { .. } => "world".to_owned(),
            _ => "other".to_owned(),
        });
        names.filter(|name| name != "other").collect::<Vec<_>>()
    };
    let scene = || LoaderCommand::Scene(Box::new(SceneCommand::on("collision_object")));
    assert_eq!(told(0, vec![scene()]), ["completing 1", "world"]);
    let with_robot = vec![scene(), LoaderCommand::Description(urdf("first")), scene()];
    assert_eq!(told(10, with_robot), ["completing 2", "checker", "world"]);
    assert_eq!(told(20, vec![scene(), LoaderCommand::Frames]), ["completing 1", "world"]);
    assert_eq!(told(30, vec![LoaderCommand::Clouds]), ["world"]);
}

#[test]
fn a_monitor_that_has_ended_is_not_waited_for() {
    let (events, events_in) = mailbox::unbounded();
    let waiting = std::thread::spawn({
        let events = events.clone();
        move || await_publication(&events)
    });
    // the stop event is taken; the request comes after it, or finds the queue closed
    drop(events_in);
    assert!(!waiting.join().unwrap());
    assert!(!await_publication(&events));
}
