//! Tests of recording and replay: runs of a node without a network, recorded, replayed, modified and cut off.

mod contacts;
mod damaged_files;
mod limits;
mod obstacle_states;
mod several_runs;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use clearance_monitor::{
    Evaluation, JointStateHistory, LeftOut, Monitor, Now, Reason, SourceId, Status, Time,
};
use clearance_robot::{MeshFiles, MeshLog, RobotModel, RobotText};
use clearance_scene::MeshModel;
use clearance_scene::{Scene, TransformTree};
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{Pose, TransformStamped};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::CollisionObject;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::{JointState, PointCloud2, PointField};
use ros2_interfaces_jazzy_serde::shape_msgs::msg::SolidPrimitive;
use ros2_interfaces_jazzy_serde::tf2_msgs::msg::TFMessage;
use serde_json::json;

use crate::loading::loader::Loader;
use crate::loading::loader_inputs::Pass;
use crate::messages::joint_state::joint_state_input;
use crate::messages::time_and_geometry::stamp_message;
use crate::monitor_events::monitor_event::MonitorEvent;
use crate::names::Names;
use crate::parameters::parameter_set::Parameters;
use crate::parameters::recording_settings::RecordingSettings;
use crate::recording::recorded_event::{
    CommandLineInputs, OriginalMessage, RecordedCloud, RecordedEvaluation, RecordedEvent,
};
use crate::recording::recorder::{RecordedNode, Recorder};
use crate::recording::recorder_handle::{Backlog, RecorderHandle};
use crate::recording::save::save_part;
use crate::recording::step::{
    RecordedCommand, RecordedMonitorEvent, SceneSource, parameters_from_json, parameters_to_json,
};
use crate::replay::archive::Archive;
use crate::replay::replayer::replay;
use crate::replay::replayer::{Outcome, Prepared, recorded_path};
use crate::scene::cloud_inbox::CloudMessage;
use crate::scene::command_conversion::object_command;
use crate::scene::loader_command::LoaderCommand;
use crate::scene::scene_update_context::{SceneUpdateContext, robots_at_stamps};
use crate::scene::transform_messages::note_transforms;

/// A rod that turns about z, with a mesh as its tip.
const URDF: &str = r#"<robot name="rod">
  <link name="base"><collision><geometry><box size="0.4 0.4 0.4"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 0 1"/></joint>
  <link name="rod"><collision><origin xyz="1 0 0"/><geometry><mesh filename="tip.obj"/></geometry></collision></link>
</robot>"#;
const TIP: &str = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const SOURCE: SourceId = SourceId([7; 16]);

/// A node without its network, and a recorder.
struct Cell {
    monitor: Monitor,
    loader: Loader,
    recording: RecorderHandle,
    recorder: Recorder,
    meshes: MeshLog,
    parameters: Parameters,
    transforms: TransformTree,
    evaluation: Option<Evaluation>,
    joint_state_history: JointStateHistory,
    milliseconds: u64,
}

impl Cell {
    /// Records to `record.mcap` in a folder that holds the robot.
    fn start(folder: &Path) -> Self {
        Self::limited(folder, 0.0)
    }

    fn limited(folder: &Path, max_duration: f64) -> Self {
        std::fs::write(folder.join("rod.urdf"), URDF).unwrap();
        std::fs::write(folder.join("tip.obj"), TIP).unwrap();
        let parameters = Parameters {
            influence_distance: 2.0,
            point_cloud_topics: vec!["points".to_owned()],
            point_cloud_ttl: 3600.0,
            ..Parameters::default()
        };
        let meshes = MeshLog::default();
        let mesh_files = MeshFiles::default().beside_urdf(folder).with_log(meshes.clone());
        let robot = RobotModel::load_with(&folder.join("rod.urdf"), None, &mesh_files).unwrap();
        let mut loader = Loader::new(mesh_files, nothing_around(), MeshModel::Surface);
        let mut monitor = Monitor::new(parameters.monitor_settings(), || Duration::ZERO);
        let update_context = SceneUpdateContext::first(&parameters, now(0));
        monitor.set_checker(loader.load_given(robot, &update_context).unwrap());
        let file = folder.join("record.mcap");
        let settings = RecordingSettings { file, max_size: 0.0, max_duration };
        let urdf = recorded_path(&folder.join("rod.urdf"));
        let given = CommandLineInputs {
            arguments: json!({ "urdf": urdf }),
            files: vec![urdf],
            meshes: meshes.clone(),
        };
        let names = Names::new("clearance", &[]).unwrap();
        let node = RecordedNode { names: &names, inputs: given, parameters: &parameters };
        let (recording, recorder) = Recorder::start(&settings, node).unwrap();
        recording.note(|| RecordedEvent::Meshes(meshes.take()));
        Self {
            monitor,
            loader,
            recording,
            recorder,
            meshes,
            parameters,
            transforms: TransformTree::default(),
            evaluation: None,
            joint_state_history: JointStateHistory::default(),
            milliseconds: 1000,
        }
    }

    fn tick(&mut self) -> Now {
        self.milliseconds += 10;
        now(self.milliseconds)
    }

    fn turn(&mut self, angle: f64) -> Evaluation {
        let now = self.tick();
        let evaluation = self.monitor.on_joint_state(joint_state_input(joint_state(angle, now), SOURCE), now);
        self.monitor.prepare();
        self.publish(evaluation, now, Some(joint_state(angle, now)))
    }

    /// Receives a joint state that is not evaluated, because the next one follows at once.
    fn pass_over(&mut self, angle: f64) {
        let now = self.tick();
        let message = joint_state(angle, now);
        self.recording.note(|| RecordedEvent::JointStateReceived {
            now,
            message: Box::new(message.clone()),
            source: SOURCE,
        });
        let input = joint_state_input(message, SOURCE);
        self.joint_state_history.note_received(&input, &self.monitor, now.ros);
        self.monitor.receive(input, now);
    }

    fn enable(&mut self, enabled: bool) {
        self.recording.note(|| RecordedEvent::Enabled(enabled));
        self.monitor.set_enabled(enabled);
    }

    fn change(&mut self, change: impl FnOnce(&mut Parameters)) {
        change(&mut self.parameters);
        self.recording.note(|| RecordedEvent::Parameters(Box::new(self.parameters.clone())));
        self.monitor.set_settings(self.parameters.monitor_settings());
    }

    fn wait(&mut self) -> Evaluation {
        let now = self.tick();
        let evaluation = self.monitor.on_heartbeat(now);
        self.publish(evaluation, now, None)
    }

    fn publish(&mut self, evaluation: Evaluation, now: Now, joint_state: Option<JointState>) -> Evaluation {
        self.evaluation = Some(evaluation.clone());
        self.joint_state_history.note(&evaluation, now.ros);
        let joint_state = joint_state.map(|message| (message, SOURCE));
        self.recording.note(|| {
            RecordedEvent::Evaluated(Box::new(RecordedEvaluation {
                now,
                joint_state,
                result: (&evaluation).into(),
            }))
        });
        evaluation
    }

    /// Receives a transform of a camera.
    fn transform(&mut self) {
        let now = self.tick();
        let mut transform = TransformStamped { child_frame_id: "camera".into(), ..Default::default() };
        transform.header.frame_id = "base".into();
        transform.transform.rotation.w = 1.0;
        transform.transform.translation.z = 0.05;
        let message = TFMessage { transforms: vec![transform] };
        self.recording.note(|| RecordedEvent::Transforms {
            message: message.clone(),
            now: now.ros,
            fixed: true,
        });
        note_transforms(&mut self.transforms, message, now.ros, true);
    }

    fn ball(&mut self, x: f64) {
        let (received_at, message) = (self.tick(), ball(x));
        let original = OriginalMessage::Object(Box::new(message.clone()));
        let step = RecordedCommand::Scene {
            by: SceneSource::CollisionObject,
            received_at: received_at.into(),
            unknown_is_occupied: false,
            lost: 0,
            is_shared: false,
        };
        let command = LoaderCommand::Scene(Box::new(object_command(&message)));
        self.process(vec![(command, step, Some(original))], None);
    }

    fn cloud(&mut self) {
        self.process(vec![(LoaderCommand::Clouds, RecordedCommand::Clouds, None)], Some(cloud()));
    }

    fn process(
        &mut self,
        commands: Vec<(LoaderCommand, RecordedCommand, Option<OriginalMessage>)>,
        cloud: Option<PointCloud2>,
    ) {
        let now = self.tick();
        let cloud = cloud.map(|cloud| RecordedCloud {
            topic: "points".to_owned(),
            received_at: now,
            is_shared: false,
            cloud: Arc::new(cloud),
        });
        let (commands, steps): (Vec<_>, Vec<_>) =
            commands.into_iter().map(|(command, step, original)| (command, (step, original))).unzip();
        self.recording.note(|| RecordedEvent::Pass {
            now,
            parameters: Box::new(self.parameters.clone()),
            commands: steps,
            clouds: cloud.iter().cloned().collect(),
        });
        let clouds: BTreeMap<_, _> = (cloud.into_iter())
            .map(|RecordedCloud { topic, received_at, is_shared, cloud }| {
                (topic, CloudMessage { cloud, received_at, since: std::time::Instant::now(), is_shared })
            })
            .collect();
        let update_context = SceneUpdateContext {
            transforms: self.transforms.clone(),
            evaluation: self.evaluation.clone(),
            robots_at_stamps: robots_at_stamps(
                &clouds,
                &self.joint_state_history,
                self.parameters.stale_after,
            ),
            ..SceneUpdateContext::first(&self.parameters, now)
        };
        let pass = Pass { update_context, commands, clouds };
        let mut told = Vec::new();
        self.loader.process(pass, |event| told.push(event));
        self.recording.note(|| RecordedEvent::Meshes(self.meshes.take()));
        for event in told {
            match event {
                MonitorEvent::Checker(revision) => {
                    self.recording.note(|| RecordedEvent::MonitorEvent(RecordedMonitorEvent::Checker));
                    self.monitor.set_checker(revision);
                }
                MonitorEvent::World { faults, incomplete, .. } => {
                    self.recording.note(|| RecordedEvent::MonitorEvent(RecordedMonitorEvent::World));
                    self.monitor.note_world_faults(faults, incomplete);
                }
                MonitorEvent::WorldUpdate(update) => {
                    self.recording
                        .note(|| RecordedEvent::MonitorEvent(RecordedMonitorEvent::WorldUpdate(update)));
                    update.apply_to(&mut self.monitor);
                }
                _ => panic!("nothing else is expected"),
            }
        }
    }

    fn end(self) {
        self.ended().unwrap();
    }

    /// Ends the recording. Returns why it is incomplete, if it is.
    fn ended(self) -> Result<(), String> {
        drop(self.recording);
        self.recorder.finish()
    }
}

fn now(milliseconds: u64) -> Now {
    let steady = Duration::from_millis(milliseconds);
    let ros = Time::from_nanoseconds(1_700_000_000_000_000_000 + i64::try_from(steady.as_nanos()).unwrap());
    Now { ros: Some(ros), steady }
}

fn joint_state(angle: f64, now: Now) -> JointState {
    let mut message =
        JointState { name: vec!["turn".to_owned()], position: vec![angle], ..JointState::default() };
    message.header.stamp = stamp_message(now.ros.unwrap());
    message
}

fn ball(x: f64) -> CollisionObject {
    let mut message = CollisionObject { id: "ball".to_owned(), ..CollisionObject::default() };
    message.header.frame_id = "base".to_owned();
    message.primitives.push(SolidPrimitive {
        type_: SolidPrimitive::SPHERE,
        dimensions: vec![0.1],
        ..SolidPrimitive::default()
    });
    let mut pose = Pose::default();
    (pose.position.x, pose.position.y, pose.orientation.w) = (x, 0.3, 0.9);
    pose.orientation.x = 0.3;
    message.primitive_poses.push(pose);
    message
}

fn cloud() -> PointCloud2 {
    let points: [[f32; 3]; 3] = [[1.3, 0.1, 0.2], [1.4, 0.0, 0.0], [f32::NAN, 0.0, 0.0]];
    let field = |name: &str, offset| PointField {
        name: name.to_owned(),
        offset,
        datatype: PointField::FLOAT32,
        count: 1,
    };
    let mut message = PointCloud2 {
        height: 1,
        width: 3,
        fields: vec![field("x", 0), field("y", 4), field("z", 8)],
        point_step: 12,
        row_step: 36,
        data: points.iter().flatten().flat_map(|number| number.to_le_bytes()).collect(),
        ..PointCloud2::default()
    };
    message.header.frame_id = "camera".to_owned();
    message
}

fn nothing_around() -> crate::loading::loader::Surroundings {
    Box::new(|_| Ok(Scene::default()))
}

/// Replays a recording, with the robot that it contains.
fn again(file: &Path) -> Result<Outcome, String> {
    let archive = Archive::read(file).map_err(|error| error.to_string())?;
    let urdf: PathBuf = serde_json::from_value(archive.given["urdf"].clone()).map_err(|e| e.to_string())?;
    let mesh_files = archive.meshes().beside_urdf(urdf.parent().ok_or("no folder")?);
    let text = String::from_utf8(archive.file(&urdf)?.to_vec()).map_err(|error| error.to_string())?;
    let text = RobotText { urdf: &text, urdf_name: None, srdf: None, srdf_name: None };
    let robot = RobotModel::from_text(&text, &mesh_files).map_err(|error| error.to_string())?;
    let prepared = Prepared {
        robot: Some(robot),
        mesh_files,
        surroundings: nothing_around(),
        mesh_model: MeshModel::Surface,
    };
    replay(file, prepared).map_err(|error| error.to_string())
}

/// A run with every kind of step and 25 answers.
fn run(cell: &mut Cell) {
    cell.wait();
    cell.transform();
    for i in 0..10 {
        cell.turn(f64::from(i) * 0.1);
    }
    cell.ball(1.1);
    cell.turn(0.3);
    cell.cloud();
    for i in 0..12 {
        cell.turn(f64::from(i) * 0.07);
    }
    cell.wait();
}

const ANSWERS: u64 = 25;

#[test]
fn a_recorded_run_is_the_same_run_bit_for_bit_without_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    run(&mut cell);
    let last = cell.evaluation.clone().unwrap();
    assert!(
        last.checked_state.is_some_and(|checked_state| checked_state.report.nearest.is_some()),
        "{:?}",
        last.status
    );
    assert_eq!(last.revision.unwrap().world, 2);
    cell.end();
    std::fs::remove_file(folder.path().join("tip.obj")).unwrap();
    std::fs::remove_file(folder.path().join("rod.urdf")).unwrap();
    let outcome = again(&folder.path().join("record.mcap")).unwrap();
    assert_eq!((outcome.same, outcome.difference, outcome.cut_off), (ANSWERS, None, false));
}

#[test]
fn tolerances_give_the_same_answers_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    cell.change(|p| (p.distance_relative_tolerance, p.distance_absolute_tolerance) = (0.3, 0.05));
    run(&mut cell);
    for i in 0..40 {
        cell.turn(0.84 + f64::from(i) * 2e-4);
    }
    // with a deadline that is not reached, with one that is, and without any
    for deadline in [10.0, 1e-9, 0.0] {
        cell.change(|p| p.check_deadline = deadline);
        cell.turn(0.84);
        cell.turn(0.85);
    }
    cell.end();
    let outcome = again(&folder.path().join("record.mcap")).unwrap();
    assert_eq!((outcome.same, outcome.late, outcome.difference), (ANSWERS + 46, 2, None));
}

#[test]
fn what_was_passed_over_turned_off_slowed_or_late_is_so_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    // until the first cloud is applied, which needs a known robot position, every state is UNKNOWN
    cell.transform();
    cell.turn(0.9);
    cell.cloud();
    cell.ball(1.1);
    cell.change(|p| {
        (p.slowdown_distance_world, p.slowdown_reaction_time) = (5.0, 0.0);
        (p.slowdown_release_count, p.look_ahead_horizon) = (2, 1.0);
    });
    cell.turn(0.9);
    // an older stamp than the one of the skipped joint state is out of order
    cell.pass_over(0.8);
    assert!(cell.turn(0.8).speed_scale > 0.0);
    cell.enable(false);
    assert_eq!(cell.wait().status, Status::Unknown(Reason::Disabled));
    cell.enable(true);
    assert_eq!(cell.turn(0.9).status, Status::Free);
    cell.change(|p| p.check_deadline = 1e-9);
    for _ in 0..3 {
        assert_eq!(cell.turn(0.9).left_out, LeftOut::Pairs);
    }
    assert_eq!(cell.wait().left_out, LeftOut::Pairs);
    cell.change(|p| p.check_deadline = 0.0);
    assert_eq!(cell.turn(0.9).speed_scale, 0.0, "what was asked before the deadline passed counts no more");
    assert!(cell.turn(0.9).speed_scale > 0.0);
    cell.end();
    let outcome = again(&folder.path().join("record.mcap")).unwrap();
    assert_eq!((outcome.same, outcome.late, outcome.difference), (11, 4, None));
}

#[test]
fn a_result_that_differs_from_the_recorded_one_is_reported_also_by_its_part() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    run(&mut cell);
    let other = cell.evaluation.clone().unwrap();
    // an evaluation of another joint state
    let now = cell.tick();
    let _ = cell.monitor.on_joint_state(joint_state_input(joint_state(2.0, now), SOURCE), now);
    cell.publish(other, now, Some(joint_state(2.0, now)));
    cell.turn(0.1);
    cell.end();
    let whole = folder.path().join("record.mcap");
    let outcome = again(&whole).unwrap();
    assert_eq!(outcome.same, ANSWERS);
    let difference = outcome.difference.unwrap();
    assert_eq!((difference.answer, difference.field.as_str()), (ANSWERS + 1, "age"));
    let part = folder.path().join("part.mcap");
    save_part(&whole, &part, difference.answer, 2).unwrap();
    let shown = again(&part).unwrap();
    assert!((2..ANSWERS).contains(&shown.same), "{}", shown.same);
    let shown = shown.difference.unwrap();
    assert_eq!((shown.recorded, shown.replayed), (difference.recorded, difference.replayed));
    assert!(
        save_part(&whole, &part, 1, 1).unwrap_err().to_string().contains("part.mcap"),
        "no file is overwritten"
    );
}

#[test]
fn parameters_go_both_ways() {
    let mut parameters = Parameters { padding: 0.1 + 0.2, ..Parameters::default() };
    parameters.record_file = "true".to_owned();
    parameters.point_cloud_topics = vec!["true".to_owned(), "/a".to_owned()];
    (parameters.cloud_crop_min, parameters.cloud_crop_max) = (vec![5.0, 0.0, 0.0], vec![6.0, 1.0, 1.0]);
    let json = parameters_to_json(&parameters);
    let text = serde_json::to_string(&json).unwrap();
    assert_eq!(parameters_from_json(&serde_json::from_str(&text).unwrap()), Ok(parameters));
    let mut wrong = json;
    wrong.insert("speed".to_owned(), true.into());
    assert!(parameters_from_json(&wrong).unwrap_err().contains("'speed'"));
}
