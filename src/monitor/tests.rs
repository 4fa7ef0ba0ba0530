//! Every rule of the monitor, without a network.

#![expect(clippy::float_cmp, reason = "0 and infinity are said exactly")]

use std::sync::Arc;
use std::time::Duration;

use proptest::prelude::*;

use super::scene::{Transform, TransformTree};
use super::*;
use crate::checker::{CollisionChecker, Settings};
use crate::robot::{MeshFiles, RobotModel};
use crate::world::World;

/// Two arms of one metre that fold: apart at zero, the second on the base at pi; `follower` mimics the elbow.
const URDF: &str = r#"<robot name="folder">
  <link name="base"><collision><geometry><box size="0.4 0.4 0.4"/></geometry></collision></link>
  <link name="upper"/>
  <link name="ball"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="flag"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="ball"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/>
  </joint>
  <joint name="follower" type="revolute">
    <parent link="ball"/><child link="flag"/><axis xyz="0 0 1"/><mimic joint="elbow"/>
    <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/>
  </joint>
</robot>"#;

const FREE: [f64; 2] = [0.0, 0.0];
const COLLIDING: [f64; 2] = [0.0, std::f64::consts::PI];

fn revision(model: u64) -> Arc<Revision> {
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    Arc::new(Revision::new(checker, model, 0))
}

fn stopwatch() -> Duration {
    Duration::ZERO
}

/// A monitor of the folding robot; FREE up to 5 m, stale after half a second.
fn monitor() -> Monitor {
    let settings = MonitorSettings { distance_limit: 5.0, ..MonitorSettings::default() };
    let mut monitor = Monitor::new(settings, stopwatch);
    monitor.set_checker(revision(1));
    monitor
}

const SECOND: f64 = 1e9;
const START: f64 = 1000.0;

fn time(seconds: f64) -> Time {
    #[expect(clippy::cast_possible_truncation, reason = "tests take minutes")]
    Time::from_nanoseconds((seconds * SECOND).round() as i64)
}

/// Both clocks `seconds` after the start.
fn at(seconds: f64) -> Now {
    Now { ros: Some(time(START + seconds)), steady: Duration::from_secs_f64(seconds) }
}

/// A whole joint state stamped `seconds` after the start.
fn state(seconds: f64, [shoulder, elbow]: [f64; 2]) -> JointStateInput {
    input(seconds, &[("shoulder", shoulder), ("elbow", elbow)])
}

fn input(seconds: f64, joints: &[(&str, f64)]) -> JointStateInput {
    JointStateInput {
        source: SourceId([1; 16]),
        stamp: time(START + seconds),
        names: joints.iter().map(|(name, _)| (*name).to_owned()).collect(),
        positions: joints.iter().map(|(_, position)| *position).collect(),
        velocities: Vec::new(),
    }
}

fn settings_of_lookout() -> MonitorSettings {
    MonitorSettings {
        distance_limit: 5.0,
        look_ahead_horizon: 0.5,
        look_ahead_acceleration: 0.1,
        ..MonitorSettings::default()
    }
}

/// A monitor that looks half a second ahead; nothing accelerates by more than 0.1 rad/s².
fn lookout() -> Monitor {
    let mut monitor = monitor();
    monitor.set_settings(settings_of_lookout());
    monitor
}

/// A joint state with velocities.
fn moving(seconds: f64, positions: [f64; 2], velocities: &[f64]) -> JointStateInput {
    JointStateInput { velocities: velocities.to_vec(), ..state(seconds, positions) }
}

fn code(judgement: &Judgement) -> &'static str {
    judgement.status.reason().map_or(judgement.status.word(), Reason::code)
}

#[test]
fn what_is_right_is_judged() {
    let mut monitor = monitor();
    let free = monitor.on_joint_state(state(0.0, FREE), at(0.01));
    assert_eq!(code(&free), "FREE");
    assert!((free.distance() - 1.7).abs() < 1e-9, "{}", free.distance());
    assert!((free.age.unwrap() - 0.01).abs() < 1e-9);
    assert_eq!(free.stamp, Some(time(START)));

    let colliding = monitor.on_joint_state(state(0.1, COLLIDING), at(0.1));
    assert_eq!(code(&colliding), "COLLIDING");
    assert_eq!(colliding.distance(), 0.0);
}

#[test]
fn what_is_wrong_is_unknown_and_named() {
    let whole = [("shoulder", 0.0), ("elbow", 0.0)];
    let with = |name, value| [whole[0], whole[1], (name, value)];
    let cut = JointStateInput { positions: vec![0.0], ..state(0.0, FREE) };
    for (input, expected, named) in [
        (input(0.0, &[]), "partial", "'shoulder' and 'elbow'"),
        (input(0.0, &whole[..1]), "partial", "'elbow'"),
        (input(0.0, &[("other", 0.0)]), "partial", "'shoulder'"),
        (state(0.0, [0.0, f64::NAN]), "non_finite", "'elbow'"),
        (state(0.0, [f64::INFINITY, 0.0]), "non_finite", "'shoulder'"),
        (state(0.0, [f64::NEG_INFINITY, f64::NAN]), "non_finite", "'shoulder'"),
        (state(0.0, [0.0, 1e300]), "malformed", "'elbow'"),
        (input(0.0, &with("elbow", 0.0)), "malformed", "'elbow'"),
        (cut, "malformed", "2 names and 1 positions"),
        (state(-0.6, FREE), "stale", "0.600 s"),
        (state(0.6, FREE), "future_stamp", "0.600 s"),
    ] {
        let judgement = monitor().on_joint_state(input.clone(), at(0.0));
        assert_eq!(code(&judgement), expected, "{input:?}");
        let reason = judgement.status.reason().unwrap().to_string();
        assert!(reason.contains(named), "{reason}");
        assert!(judgement.evidence.is_none() && judgement.distance().is_nan());
    }
}

#[test]
fn what_is_odd_is_judged_with_a_warning() {
    let whole = [("shoulder", 0.0), ("elbow", 0.0)];
    let with = |name, value| [whole[0], whole[1], (name, value)];
    let unstamped = JointStateInput { stamp: Time::ZERO, ..state(0.0, FREE) };
    for (input, warned) in [
        (input(0.0, &with("follower", f64::NAN)), None),
        (input(0.0, &with("follower", 0.01)), None),
        (input(0.0, &with("follower", 0.5)), Some("'follower' is reported at 0.5, but it mimics 'elbow'")),
        (input(0.0, &with("gripper", f64::NAN)), Some("'gripper'")),
        (state(0.0, [0.0, 3.2 + 1e-4]), None),
        (state(0.0, [3.3, 0.0]), Some("joint 'shoulder' is at 3.3, outside its limits")),
        (unstamped, Some("stamp")),
    ] {
        let judgement = monitor().on_joint_state(input.clone(), at(0.0));
        assert!(judgement.evidence.is_some(), "{input:?}: {}", code(&judgement));
        assert_eq!(judgement.warnings.len(), usize::from(warned.is_some()), "{input:?}");
        assert!(judgement.warnings.iter().all(|w| w.contains(warned.unwrap_or_default())));
    }
}

#[test]
fn nothing_is_known_before_there_is_a_model_a_joint_state_and_a_clock() {
    let mut monitor = Monitor::new(MonitorSettings::default(), stopwatch);
    assert_eq!(code(&monitor.on_heartbeat(at(0.0))), "no_model");
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), at(0.0))), "no_model");
    monitor.note_model_fault("line 3: no such link".to_owned());
    let refused = monitor.on_heartbeat(at(0.1));
    assert!(refused.status.reason().unwrap().to_string().contains("line 3"));

    // the joint state that came before the model is judged when the model is there
    monitor.set_checker(revision(1));
    assert_eq!(code(&monitor.on_heartbeat(at(0.2))), "FREE");

    let mut monitor = self::monitor();
    assert_eq!(code(&monitor.on_heartbeat(at(0.0))), "no_joint_state");
    let no_clock = Now { ros: None, ..at(0.0) };
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), no_clock)), "no_clock");
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "FREE");
}

#[test]
fn a_heartbeat_repeats_the_last_judgement_until_it_is_stale() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    for (seconds, expected) in [(0.1, "FREE"), (0.5, "FREE"), (0.51, "stale"), (9.0, "stale")] {
        let judgement = monitor.on_heartbeat(at(seconds));
        assert_eq!(code(&judgement), expected, "after {seconds} s");
        assert!((judgement.age.unwrap() - seconds).abs() < 1e-9);
    }
    assert_eq!(code(&monitor.on_joint_state(state(9.1, FREE), at(9.1))), "FREE");
}

#[test]
fn a_stale_joint_state_that_was_also_broken_says_both() {
    let mut monitor = monitor();
    monitor.on_joint_state(input(0.0, &[("elbow", 0.0)]), at(0.0));
    let reason = monitor.on_heartbeat(at(1.0)).status.reason().unwrap().to_string();
    assert!(reason.contains("1.000 s old") && reason.contains("'shoulder'"), "{reason}");
}

#[test]
fn silence_is_noticed_when_time_stands_still_or_jumps_back() {
    for ros in [0.0, -100.0] {
        let mut monitor = monitor();
        monitor.on_joint_state(state(0.0, FREE), at(0.0));
        let later = Now { ros: Some(time(START + ros)), steady: Duration::from_secs(1) };
        assert!(!monitor.on_heartbeat(later).status.is_free(), "ROS time {ros}");
    }
}

#[test]
fn a_stamp_before_the_last_judged_one_of_its_publisher_is_out_of_order() {
    let mut monitor = monitor();
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.1))), "FREE");
    assert_eq!(code(&monitor.on_joint_state(state(0.05, FREE), at(0.12))), "out_of_order");
    assert_eq!(code(&monitor.on_heartbeat(at(0.15))), "out_of_order");
    // the same stamp again, and another publisher's, are in order
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.16))), "FREE");
    let other = JointStateInput { source: SourceId([2; 16]), ..state(0.05, FREE) };
    assert_eq!(code(&monitor.on_joint_state(other, at(0.17))), "FREE");
    // what was not judged orders nothing
    monitor.on_joint_state(state(0.3, [f64::NAN, 0.0]), at(0.3));
    assert_eq!(code(&monitor.on_joint_state(state(0.2, FREE), at(0.31))), "FREE");
}

/// A message of publisher `from` about some joints, stamped `seconds` after the start.
fn part(from: u8, seconds: f64, joints: &[(&str, f64)]) -> JointStateInput {
    JointStateInput { source: SourceId([from; 16]), ..input(seconds, joints) }
}

#[test]
fn what_several_publishers_say_is_one_state_with_an_age_for_each_joint() {
    let mut monitor = monitor();
    assert_eq!(code(&monitor.on_joint_state(part(1, 0.0, &[("shoulder", 0.0)]), at(0.0))), "partial");
    let whole = monitor.on_joint_state(part(2, 0.1, &[("elbow", COLLIDING[1])]), at(0.1));
    assert_eq!((code(&whole), whole.stamp), ("COLLIDING", Some(time(START))));
    assert!((whole.age.unwrap() - 0.1).abs() < 1e-9, "the oldest joint's");
    let moved = monitor.on_joint_state(part(2, 0.2, &[("elbow", 0.0)]), at(0.2));
    assert_eq!((code(&moved), moved.stamp), ("FREE", Some(time(START))));

    // one of the publishers falls silent
    let due = monitor.time_to_heartbeat(at(0.2));
    assert_eq!(due, Duration::from_millis(100));
    monitor.on_heartbeat(at(0.45));
    let due = monitor.time_to_heartbeat(at(0.45)).as_secs_f64();
    assert!((0.05..0.06).contains(&due), "{due}");
    let judgement = monitor.on_joint_state(part(2, 0.6, &[("elbow", 0.0)]), at(0.6));
    let reason = judgement.status.reason().unwrap().to_string();
    assert_eq!(code(&judgement), "stale");
    assert!(reason.contains("'shoulder' is 0.600 s old") && !reason.contains("elbow"), "{reason}");
    let judgement = monitor.on_joint_state(part(3, 0.6, &[("shoulder", 0.0)]), at(0.6));
    assert_eq!(code(&judgement), "FREE", "another takes its place");
    let reason = monitor.on_heartbeat(at(2.0)).status.reason().unwrap().to_string();
    assert!(reason.starts_with("the last joint state is 1.400 s old"), "{reason}");
}

#[test]
fn what_others_publish_on_the_topic_takes_nothing_from_the_robot() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    let gripper = monitor.on_joint_state(part(2, 0.1, &[("gripper", 0.0)]), at(0.1));
    assert_eq!((code(&gripper), gripper.stamp), ("FREE", Some(time(START))));
    assert!(gripper.warnings[0].contains("'gripper'"), "{:?}", gripper.warnings);
    let broken = JointStateInput { positions: Vec::new(), ..part(2, 0.2, &[("gripper", 0.0)]) };
    let broken = monitor.on_joint_state(broken, at(0.2));
    assert_eq!(code(&broken), "FREE");
    assert!(broken.warnings.iter().any(|w| w.contains("1 names and 0 positions")), "{:?}", broken.warnings);
    // the robot itself is heard no more
    assert_eq!(code(&monitor.on_joint_state(part(2, 0.6, &[("gripper", 0.0)]), at(0.6))), "stale");
    // the gripper is forgotten when it falls silent
    assert!(monitor.on_joint_state(state(1.2, FREE), at(1.2)).warnings.is_empty());
}

#[test]
fn of_each_joint_the_last_word_counts() {
    let mut monitor = monitor();
    monitor.on_joint_state(part(1, 0.0, &[("shoulder", 0.0), ("elbow", f64::NAN)]), at(0.0));
    assert_eq!(code(&monitor.on_heartbeat(at(0.0))), "non_finite");
    assert_eq!(code(&monitor.on_joint_state(part(2, 0.1, &[("elbow", 0.0)]), at(0.1))), "FREE");
    // what is malformed speaks for all joints that it names
    let cut = JointStateInput { positions: vec![0.0], ..part(1, 0.2, &[("shoulder", 0.0), ("other", 0.0)]) };
    assert_eq!(code(&monitor.on_joint_state(cut, at(0.2))), "malformed");
    assert_eq!(code(&monitor.on_joint_state(part(2, 0.3, &[("elbow", 0.0)]), at(0.3))), "malformed");
    assert_eq!(code(&monitor.on_joint_state(part(3, 0.4, &[("shoulder", 0.0)]), at(0.4))), "FREE");
}

#[test]
fn a_played_bag_is_one_publisher_that_says_what_several_said() {
    let mut monitor = monitor();
    monitor.on_joint_state(part(1, 0.10, &[("shoulder", 0.0)]), at(0.1));
    assert_eq!(code(&monitor.on_joint_state(part(1, 0.09, &[("elbow", 0.0)]), at(0.1))), "FREE");
    assert_eq!(code(&monitor.on_joint_state(part(1, 0.11, &[("shoulder", 0.0)]), at(0.11))), "FREE");
    assert_eq!(code(&monitor.on_joint_state(part(1, 0.10, &[("elbow", 0.0)]), at(0.11))), "FREE");
    assert_eq!(code(&monitor.on_joint_state(part(1, 0.08, &[("elbow", 0.0)]), at(0.11))), "out_of_order");
}

#[test]
fn what_is_only_heard_is_judged_with_the_next() {
    let mut monitor = monitor();
    monitor.hear(part(1, 0.0, &[("shoulder", 0.0)]), at(0.0));
    assert_eq!(code(&monitor.on_joint_state(part(2, 0.0, &[("elbow", 0.0)]), at(0.0))), "FREE");
}

#[test]
fn velocities_of_several_publishers_are_those_of_one_robot() {
    let mut monitor = lookout();
    let with = |from, name, velocity| JointStateInput {
        velocities: vec![velocity],
        ..part(from, 0.0, &[(name, 0.0)])
    };
    monitor.hear(with(1, "shoulder", 0.0), at(0.0));
    assert_eq!(monitor.on_joint_state(with(2, "elbow", 0.0), at(0.0)).time_to_contact(), 0.5);
    assert_eq!(monitor.on_joint_state(with(2, "elbow", f64::NAN), at(0.0)).time_to_contact(), 0.0);
}

#[test]
fn more_publishers_than_are_remembered_do_no_harm() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    for from in 2..200 {
        monitor.on_joint_state(part(from, 0.1, &[("gripper", 0.0)]), at(0.1));
    }
    // the robot was forgotten: that is not taken for free
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "partial");
    assert_eq!(code(&monitor.on_joint_state(state(0.2, FREE), at(0.2))), "FREE");
}

/// A base that drives in a plane, with an arm of one joint; or one that floats.
fn base_on(kind: &str) -> Arc<Revision> {
    let text = format!(
        r#"<robot name="rover">
  <link name="odom"/>
  <link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="arm"/>
  <joint name="drive" type="{kind}">
    <parent link="odom"/><child link="base"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="lift" type="prismatic">
    <parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>"#
    );
    let robot = RobotModel::from_urdf(&text, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    Arc::new(Revision::new(checker, 1, 0))
}

/// `tf` from odom to base, by way of a frame between, stamped `seconds` after the start.
fn tree(seconds: f64, pose: crate::math::Pose) -> TransformTree {
    let mut tree = TransformTree::default();
    let fixed = Transform { parent: "odom".to_owned(), pose_pf: crate::math::Pose::identity(), stamp: None };
    assert!(tree.note("between", fixed));
    let moving =
        Transform { parent: "between".to_owned(), pose_pf: pose, stamp: Some(time(START + seconds)) };
    assert!(tree.note("base", moving));
    tree
}

fn rover(kind: &str) -> Monitor {
    let transform_joints = vec!["drive".to_owned()];
    let settings = MonitorSettings { transform_joints, ..MonitorSettings::default() };
    let mut monitor = Monitor::new(settings, stopwatch);
    monitor.set_checker(base_on(kind));
    monitor
}

fn pose(xyz: [f64; 3], rpy: [f64; 3]) -> crate::math::Pose {
    crate::math::pose_from_xyz_rpy(xyz, rpy)
}

#[test]
fn a_base_stands_where_tf_tells() {
    for (kind, there) in [
        ("planar", pose([3.0, 2.0, 0.0], [0.0, 0.0, 2.5])),
        ("planar", pose([3.0, 2.0, 0.0], [0.0, 0.0, -3.1])),
        ("floating", pose([3.0, 2.0, -1.0], [0.4, 1.0, -2.5])),
    ] {
        let mut monitor = rover(kind);
        let lift = || input(0.0, &[("lift", 0.5)]);
        let judgement = monitor.on_joint_state(lift(), at(0.0));
        let reason = judgement.status.reason().unwrap().to_string();
        assert_eq!(code(&judgement), "partial", "without a word of tf: {reason}");
        monitor.note_transforms(&TransformTree::default());
        let judgement = monitor.on_joint_state(lift(), at(0.0));
        let reason = judgement.status.reason().unwrap().to_string();
        assert_eq!(code(&judgement), "no_transform");
        assert!(reason.contains("'odom' to 'base'") && reason.contains("'drive'"), "{reason}");

        monitor.note_transforms(&tree(0.0, there));
        let judgement = monitor.on_heartbeat(at(0.0));
        assert_eq!(code(&judgement), "FREE");
        let evidence = judgement.evidence.unwrap();
        let base = judgement.revision.unwrap().checker.robot().link_by_name("base").unwrap();
        let apart = evidence.poses.pose(base).inv_mul(&there);
        assert!(apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-9, "{kind}: {apart}");
    }
}

#[test]
fn a_transform_that_is_old_or_leaves_the_plane_places_nothing() {
    let lift = |seconds| input(seconds, &[("lift", 0.5), ("drive/x", f64::NAN)]);
    let mut monitor = rover("planar");
    monitor.note_transforms(&tree(0.0, pose([3.0, 0.0, 0.0], [0.0; 3])));
    assert_eq!(
        code(&monitor.on_joint_state(lift(0.0), at(0.0))),
        "FREE",
        "joint states say nothing about it"
    );
    assert_eq!(code(&monitor.on_joint_state(lift(1.0), at(1.0))), "FREE");
    let due = monitor.time_to_heartbeat(at(1.0));
    assert!(due < Duration::from_millis(2), "{due:?}");
    let judgement = monitor.on_heartbeat(at(1.01));
    assert!(judgement.placement.is_none() && code(&judgement) == "no_transform");
    assert!(judgement.status.reason().unwrap().to_string().contains("1.010 s old"));
    monitor.note_transforms(&tree(1.1, pose([3.0, 0.0, 0.0], [0.0; 3])));
    assert_eq!(code(&monitor.on_heartbeat(at(1.1))), "FREE");

    for (there, why) in [
        (tree(1.2, pose([3.0, 0.0, 0.01], [0.0; 3])), "leaves the joint's plane by 0.0100"),
        (tree(1.2, pose([3.0, 0.0, 0.0], [0.01, 0.0, 0.0])), "leaves the joint's plane by 0.0100"),
        (tree(9.0, pose([3.0, 0.0, 0.0], [0.0; 3])), "in the future"),
    ] {
        monitor.note_transforms(&there);
        let judgement = monitor.on_joint_state(lift(1.2), at(1.2));
        let reason = judgement.status.reason().unwrap().to_string();
        assert!(code(&judgement) == "no_transform" && reason.contains(why), "{reason}");
    }
}

#[test]
fn a_wish_for_transforms_that_cannot_be_fulfilled_is_told() {
    let transform_joints = vec!["drive".to_owned(), "lift".to_owned(), "wing".to_owned()];
    let mut monitor = rover("floating");
    monitor.set_settings(MonitorSettings { transform_joints, ..MonitorSettings::default() });
    monitor.note_transforms(&tree(0.0, pose([3.0, 0.0, 0.0], [0.0; 3])));
    let judgement = monitor.on_joint_state(input(0.0, &[("lift", 0.5)]), at(0.0));
    assert_eq!(code(&judgement), "FREE");
    assert_eq!(judgement.warnings.len(), 2);
    assert!(judgement.warnings[0].contains("'lift'") && judgement.warnings[1].contains("'wing'"));
}

const SPEED: SpeedSettings = SpeedSettings {
    own: SpeedDistances { slowdown: 0.5, stop: 0.1 },
    world: SpeedDistances { slowdown: 0.0, stop: 0.0 },
    reaction_time: 0.1,
    trigger_count: 1,
    release_count: 1,
};

/// A monitor that slows down; stale after half a second.
fn governed(speed: SpeedSettings) -> Monitor {
    let mut monitor = monitor();
    monitor.set_settings(MonitorSettings { speed, ..MonitorSettings::default() });
    monitor
}

/// The distance with this elbow.
fn distance_at(elbow: f64) -> f64 {
    governed(SPEED).on_joint_state(state(0.0, [0.0, elbow]), at(0.0)).distance()
}

#[test]
fn the_speed_is_that_of_the_distance_and_the_way_to_it() {
    let (near, distance) = ([0.0, 2.6], distance_at(2.6));
    assert!((0.1..0.5).contains(&distance), "{distance}");
    let share = |velocities: &[f64]| {
        governed(SPEED).on_joint_state(moving(0.0, near, velocities), at(0.0)).speed_scale
    };
    let at_rest = (distance - 0.1) / 0.4;
    assert!((share(&[0.0, 0.0]) - at_rest).abs() < 1e-9);
    assert_eq!(share(&[]), share(&[0.0, 0.0]), "where nothing is known of velocities, the distance counts");
    // the ball is above the base, a little to the right: the shoulder lifts it, or lowers it
    assert_eq!(share(&[1.0, 0.0]), 1.0);
    assert!(share(&[-1.0, 0.0]) < at_rest);
    assert!(share(&[0.0, 0.3]) < at_rest);
    assert_eq!(share(&[0.0, 3.0]), 0.0);
    assert_eq!(share(&[0.0, -0.3]), 1.0);
    assert_eq!(governed(SPEED).on_joint_state(state(0.0, FREE), at(0.0)).speed_scale, 1.0);
}

#[test]
fn without_velocities_the_last_state_tells_the_way() {
    let mut monitor = governed(SPEED);
    let speeds: Vec<f64> = [(0.0, 2.6), (0.1, 2.61), (0.2, 2.6), (0.3, 2.6)]
        .map(|(t, elbow)| monitor.on_joint_state(state(t, [0.0, elbow]), at(t)).speed_scale)
        .into();
    let [resting, folding, opening, held] = speeds[..] else { panic!() };
    let by_velocity = |elbow, velocity| {
        governed(SPEED).on_joint_state(moving(0.0, [0.0, elbow], &[0.0, velocity]), at(0.0)).speed_scale
    };
    assert_eq!((resting, opening, held), (by_velocity(2.6, 0.0), 1.0, resting));
    assert!((folding - by_velocity(2.61, 0.1)).abs() < 1e-3, "{folding}");
}

#[test]
fn what_is_not_free_has_no_speed() {
    let mut monitor = governed(SpeedSettings { release_count: 2, ..SpeedSettings::default() });
    let mut speed = |input, seconds| monitor.on_joint_state(input, at(seconds)).speed_scale;
    assert_eq!([speed(state(0.0, FREE), 0.0), speed(state(0.1, FREE), 0.1)], [0.0, 1.0]);
    assert_eq!(speed(state(0.2, COLLIDING), 0.2), 0.0);
    assert_eq!([speed(state(0.3, FREE), 0.3), speed(state(0.4, FREE), 0.4)], [0.0, 1.0]);
    assert_eq!(speed(state(0.5, [0.0, f64::NAN]), 0.5), 0.0);
    assert_eq!([speed(state(0.6, FREE), 0.6), speed(state(0.7, FREE), 0.7)], [0.0, 1.0]);
    // a heartbeat is no state; what grows stale stops
    assert_eq!(monitor.on_heartbeat(at(1.0)).speed_scale, 1.0);
    assert_eq!(monitor.on_heartbeat(at(1.3)).speed_scale, 0.0);
    assert_eq!(monitor.on_joint_state(state(1.4, FREE), at(1.4)).speed_scale, 0.0);
    // a change of the world is none of the states in a row either way
    monitor.on_joint_state(state(1.5, FREE), at(1.5));
    monitor.set_checker(revision(2));
    assert_eq!(monitor.on_joint_state(state(1.6, FREE), at(1.6)).speed_scale, 1.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn the_speed_is_that_of_the_change_of_the_distance(elbow in 2.4..2.8f64, velocity in -2.0..2.0f64) {
        const STEP: f64 = 1e-4;
        let distance = distance_at(elbow);
        let rate = (distance_at(elbow - STEP * velocity) - distance_at(elbow + STEP * velocity)) / (2.0 * STEP);
        prop_assume!(rate.abs() > 0.01 && distance > 0.0 && distance < 0.5);
        let judgement = governed(SPEED).on_joint_state(moving(0.0, [0.0, elbow], &[0.0, velocity]), at(0.0));
        let expected = if rate < 0.0 { 1.0 } else { ((distance - 0.1 * rate - 0.1) / 0.4).clamp(0.0, 1.0) };
        prop_assert!((judgement.speed_scale - expected).abs() < 1e-3, "{} but {expected}", judgement.speed_scale);
    }
}

#[test]
fn a_clock_that_was_set_back_orders_anew() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(100.0, FREE), at(100.0));
    let restarted = Now { ros: at(0.0).ros, steady: at(100.1).steady };
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), restarted)), "FREE");
}

#[test]
fn what_was_heard_before_the_clock_was_set_far_back_counts_no_more() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(100.0, FREE), at(100.0));
    // a step within the tolerance takes nothing away
    let stepped = Now { ros: at(99.8).ros, steady: at(100.0).steady };
    assert_eq!(code(&monitor.on_heartbeat(stepped)), "FREE");
    let restarted = |seconds| Now { ros: at(seconds).ros, steady: at(100.1 + seconds).steady };
    let judgement = monitor.on_heartbeat(restarted(0.0));
    assert_eq!((code(&judgement), judgement.stamp, judgement.age), ("clock_jump", None, None));
    assert!(judgement.status.reason().unwrap().to_string().contains("99.800 s"), "{:?}", judgement.status);
    assert_eq!(code(&monitor.on_heartbeat(restarted(0.1))), "clock_jump");
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), restarted(0.1))), "FREE");
    // a leap forward makes it old
    assert_eq!(code(&monitor.on_heartbeat(Now { ros: at(50.0).ros, steady: at(100.3).steady })), "stale");
}

#[test]
fn nothing_is_known_while_checking_is_disabled() {
    let mut monitor = monitor();
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), at(0.0))), "FREE");
    monitor.set_enabled(false);
    assert_eq!(monitor.time_to_heartbeat(at(0.0)), Duration::ZERO);
    let judgement = monitor.on_heartbeat(at(0.0));
    assert!(code(&judgement) == "disabled" && judgement.placement.is_none());
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.1))), "disabled");
    // whatever is stale meanwhile
    assert_eq!(code(&monitor.on_heartbeat(at(9.0))), "disabled");
    monitor.set_enabled(true);
    assert_eq!(code(&monitor.on_heartbeat(at(9.0))), "stale");
    assert_eq!(code(&monitor.on_joint_state(state(9.1, FREE), at(9.1))), "FREE");
}

#[test]
fn nothing_is_known_until_another_model_is_there_or_refused() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    monitor.note_model_swap();
    assert_eq!(code(&monitor.on_heartbeat(at(0.0))), "model_swap");
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.1))), "model_swap");
    monitor.set_checker(revision(2));
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "FREE");

    monitor.note_model_swap();
    monitor.note_model_fault("not XML".to_owned());
    let judgement = monitor.on_heartbeat(at(0.2));
    assert_eq!(code(&judgement), "FREE");
    assert!(judgement.warnings[0].contains("not XML"), "{:?}", judgement.warnings);
}

#[test]
fn a_check_that_takes_too_long_is_unknown_unless_it_found_a_collision() {
    let mut monitor = monitor();
    monitor.set_settings(MonitorSettings {
        check_deadline: 1e-9,
        distance_limit: 5.0,
        ..settings_of_lookout()
    });
    let judgement = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(code(&judgement), "deadline");
    let reason = judgement.status.reason().unwrap().to_string();
    assert!(
        reason.contains("1 pairs were decided") && reason.contains("'base'") && reason.contains("'ball'"),
        "{reason}"
    );
    assert!(judgement.evidence.is_none() && judgement.distance().is_nan() && judgement.placement.is_some());
    assert_eq!(judgement.time_to_contact(), 0.0);
    assert!(judgement.warnings[0].contains("check_deadline"), "{:?}", judgement.warnings);
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "deadline");
    assert_eq!(code(&monitor.on_heartbeat(at(1.0))), "stale");

    monitor.set_settings(MonitorSettings { check_deadline: 10.0, ..settings_of_lookout() });
    assert_eq!(code(&monitor.on_joint_state(state(1.0, COLLIDING), at(1.0))), "COLLIDING");
    let free = monitor.on_joint_state(state(1.1, FREE), at(1.1));
    assert!(code(&free) == "FREE" && (free.distance() - 1.7).abs() < 1e-9, "{}", free.distance());
}

#[test]
fn a_new_model_or_setting_judges_the_last_joint_state_anew() {
    let mut monitor = monitor();
    let judgement = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(judgement.revision.unwrap().model, 1);
    assert!(monitor.time_to_heartbeat(at(0.0)) > Duration::ZERO);

    monitor.set_checker(revision(2));
    assert_eq!(monitor.time_to_heartbeat(at(0.0)), Duration::ZERO);
    assert_eq!(monitor.on_heartbeat(at(0.1)).revision.unwrap().model, 2);

    monitor.set_settings(MonitorSettings { distance_limit: 1.0, ..MonitorSettings::default() });
    let judgement = monitor.on_heartbeat(at(0.2));
    assert_eq!((code(&judgement), judgement.distance()), ("FREE", f64::INFINITY));

    // a model that was refused changes nothing
    monitor.note_model_fault("not XML".to_owned());
    assert_eq!(code(&monitor.on_heartbeat(at(0.3))), "FREE");
}

#[test]
fn the_next_heartbeat_is_due_after_its_period_or_when_the_judgement_turns_stale() {
    let mut monitor = monitor();
    assert_eq!(monitor.time_to_heartbeat(at(0.0)), Duration::ZERO);
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(monitor.time_to_heartbeat(at(0.02)), Duration::from_millis(80));
    monitor.on_heartbeat(at(0.45));
    let due = monitor.time_to_heartbeat(at(0.45));
    assert!((0.05..0.06).contains(&due.as_secs_f64()), "{due:?}");
    assert_eq!(code(&monitor.on_heartbeat(at(0.45 + due.as_secs_f64()))), "stale");
}

#[test]
fn a_world_that_nobody_has_seen_lately_is_unknown() {
    let seen = |seconds| Some(Sight { stamp: time(START + seconds), at: Duration::from_secs_f64(seconds) });
    let watched = |seen| {
        let mut revision = Arc::into_inner(revision(2)).unwrap();
        let source = |name: &str, seen| WorldSource { name: name.to_owned(), seen, ttl: 0.25 };
        revision.sources = vec![
            source("/camera", seen),
            source("/other", Some(Sight { stamp: time(START + 9.0), at: Duration::from_secs(9) })),
        ];
        revision.warnings = vec!["a cloud was dropped".to_owned()];
        Arc::new(revision)
    };
    let mut monitor = monitor();
    monitor.set_checker(watched(None));
    let judgement = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(code(&judgement), "stale_world");
    assert!(judgement.status.reason().unwrap().to_string().contains("'/camera'"));
    assert!(judgement.evidence.is_none() && judgement.placement.is_some() && judgement.distance().is_nan());
    assert_eq!(&*judgement.warnings, ["a cloud was dropped"]);

    monitor.set_checker(watched(seen(0.0)));
    assert_eq!(code(&monitor.on_heartbeat(at(0.2))), "FREE");
    let due = monitor.time_to_heartbeat(at(0.2));
    assert!((0.05..0.06).contains(&due.as_secs_f64()), "{due:?}");
    let judgement = monitor.on_heartbeat(at(0.2 + due.as_secs_f64()));
    assert_eq!((code(&judgement), judgement.stale_world.is_some()), ("stale_world", true));
    // a joint state does not make it known, nor does a collision that it would be
    assert_eq!(code(&monitor.on_joint_state(state(0.3, COLLIDING), at(0.3))), "stale_world");
    // what comes late has used up its time already
    monitor.set_checker(watched(Some(Sight { stamp: time(START), at: Duration::from_secs_f64(0.3) })));
    assert_eq!(code(&monitor.on_heartbeat(at(0.3))), "stale_world");
    monitor.set_checker(watched(seen(0.3)));
    assert_eq!(code(&monitor.on_heartbeat(at(0.31))), "COLLIDING");
    // a stale joint state is told first
    let judgement = monitor.on_heartbeat(at(1.0));
    assert_eq!((code(&judgement), judgement.stale_world.is_some()), ("stale", true));
    assert!(judgement.placement.is_none());
}

#[test]
fn what_was_refused_of_the_world_is_told() {
    let mut monitor = monitor();
    monitor.note_world_faults(vec!["object 'a': no shapes".to_owned()]);
    assert_eq!(&*monitor.on_joint_state(state(0.0, FREE), at(0.0)).warnings, ["object 'a': no shapes"]);
    monitor.note_world_faults(Vec::new());
    assert!(monitor.on_heartbeat(at(0.1)).warnings.is_empty());
}

#[test]
fn hostile_names_make_no_long_message() {
    let long = "x".repeat(1 << 20);
    let names: Vec<String> = (0..1000).map(|i| format!("{long}{i}")).collect();
    let positions = vec![0.0; names.len()];
    let hostile = JointStateInput { names, positions, ..state(0.0, FREE) };
    let judgement = monitor().on_joint_state(hostile, at(0.0));
    assert_eq!(code(&judgement), "partial");
    assert!(judgement.status.reason().unwrap().to_string().len() < 1000);

    let twice = input(0.0, &[("elbow", 0.0), ("elbow", 1.0), (&long, 0.0)]);
    let judgement = monitor().on_joint_state(twice, at(0.0));
    assert!(judgement.warnings.iter().all(|warning| warning.len() < 1000));
}

#[test]
fn the_time_to_contact_is_proven_from_velocities() {
    let ahead = |judgement: &Judgement| judgement.evidence.as_ref().unwrap().look_ahead.unwrap();
    let mut monitor = lookout();
    let still = monitor.on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0));
    assert_eq!((ahead(&still).free_for, ahead(&still).first), (0.5, None));
    assert_eq!(still.time_to_contact(), 0.5);

    // the ball touches the cube's face where the elbow is at pi - asin 0.3: 2.836899953
    let touch = std::f64::consts::PI - 0.3_f64.asin();
    let near = monitor.on_joint_state(moving(0.1, [0.0, touch - 0.2], &[0.0, 1.0]), at(0.15));
    let free_for = ahead(&near).free_for;
    // with 0.1 rad/s² more than its speed it takes 0.198 s
    assert!((0.18..0.199).contains(&free_for), "{free_for}");
    assert!(ahead(&near).first.is_some());
    assert!((near.time_to_contact() - (free_for - 0.05)).abs() < 1e-9, "its age counts");
    assert_eq!(monitor.on_heartbeat(at(0.4)).time_to_contact(), 0.0);

    let hit = monitor.on_joint_state(moving(0.5, COLLIDING, &[0.0, 0.0]), at(0.5));
    assert_eq!(ahead(&hit).free_for, 0.0);
    assert!(ahead(&hit).first.is_some());
    // what spins wildly takes no time
    let wild = monitor.on_joint_state(moving(0.6, FREE, &[1e7, -1e7]), at(0.6));
    assert!(wild.time_to_contact() < 1e-3);
}

#[test]
fn without_velocities_the_time_to_contact_is_not_known() {
    for velocities in [&[][..], &[0.0], &[0.0, f64::NAN], &[0.0, 1e300], &[0.0; 3]] {
        let judgement = lookout().on_joint_state(moving(0.0, FREE, velocities), at(0.0));
        assert_eq!(code(&judgement), "FREE");
        assert!(judgement.evidence.as_ref().unwrap().look_ahead.is_none(), "{velocities:?}");
        assert_eq!(judgement.time_to_contact(), 0.0);
        assert!(judgement.warnings[0].contains("time to contact"), "{:?}", judgement.warnings);
    }
    let off = monitor().on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0));
    assert_eq!((off.time_to_contact(), off.warnings.len()), (0.0, 0));
}

/// What may happen to a monitor.
#[derive(Clone, Debug)]
enum Happening {
    JointState(JointStateInput),
    Heartbeat,
    Model,
}

fn position() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -4.0..4.0f64,
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -0.0]),
    ]
}

fn happening() -> impl Strategy<Value = Happening> {
    let name = prop::sample::select(vec!["shoulder", "elbow", "follower", "other", ""]);
    let whole = (position(), position())
        .prop_map(|(a, b)| (vec!["shoulder".to_owned(), "elbow".to_owned()], vec![a, b]));
    let any =
        (prop::collection::vec(name.prop_map(str::to_owned), 0..4), prop::collection::vec(position(), 0..4));
    let stamp = prop_oneof![
        6 => (-1.0..1.0f64).prop_map(|s| time(START + s)),
        1 => prop::sample::select(vec![i64::MIN, -1, 0, 1, i64::MAX]).prop_map(Time::from_nanoseconds),
    ];
    let source = prop::sample::select(vec![SourceId([1; 16]), SourceId([2; 16])]);
    let velocities = prop::collection::vec(prop_oneof![position(), Just(1e9)], 0..4);
    let joint_state = (prop_oneof![whole, any], velocities, stamp, source).prop_map(
        |((names, positions), velocities, stamp, source)| {
            Happening::JointState(JointStateInput { source, stamp, names, positions, velocities })
        },
    );
    prop_oneof![6 => joint_state, 3 => Just(Happening::Heartbeat), 1 => Just(Happening::Model)]
}

fn now() -> impl Strategy<Value = Now> {
    let ros = prop_oneof![
        8 => (-1.0..1.0f64).prop_map(|s| Some(time(START + s))),
        1 => Just(None),
        1 => prop::sample::select(vec![i64::MIN, i64::MAX]).prop_map(|n| Some(Time::from_nanoseconds(n))),
    ];
    (ros, 0..2000u64).prop_map(|(ros, ms)| Now { ros, steady: Duration::from_millis(ms) })
}

/// Whether FREE may be said at `now` after all that was heard, of each message when it came: by the last that names each joint.
fn may_be_free(heard: &[(JointStateInput, Now)], now: Now) -> bool {
    let Some(ros) = now.ros else { return false };
    ["shoulder", "elbow"].into_iter().all(|name| {
        let names = |input: &JointStateInput| input.names.iter().filter(|n| *n == name).count();
        let Some((input, came)) = heard.iter().rev().find(|(input, _)| names(input) > 0) else {
            return false;
        };
        let place = input.names.iter().position(|n| n == name).unwrap();
        let fresh = match input.stamp {
            Time::ZERO => true,
            stamp => ros.seconds_since(stamp).abs() <= 0.5,
        };
        let silence = now.steady.saturating_sub(came.steady);
        input.names.len() == input.positions.len()
            && names(input) == 1
            && input.positions[place].is_finite()
            && fresh
            && silence <= Duration::from_millis(500)
    })
}

proptest! {
    #[test]
    fn nothing_panics_and_free_is_never_said_without_a_whole_fresh_joint_state(
        happenings in prop::collection::vec((happening(), now()), 0..30)
    ) {
        let mut monitor = lookout();
        let mut heard = Vec::new();
        for (happening, now) in happenings {
            let judgement = match happening {
                Happening::JointState(input) => {
                    heard.push((input.clone(), now));
                    monitor.on_joint_state(input, now)
                }
                Happening::Heartbeat => monitor.on_heartbeat(now),
                Happening::Model => {
                    monitor.set_checker(revision(2));
                    monitor.on_heartbeat(now)
                }
            };
            let _ = monitor.time_to_heartbeat(now);
            prop_assert!((0.0..=0.5).contains(&judgement.time_to_contact()));
            prop_assert!(judgement.speed_scale == 0.0 || judgement.status.is_free());
            let allowed = may_be_free(&heard, now);
            prop_assert!(!judgement.status.is_free() || allowed, "{:?}", judgement.status);
            prop_assert_eq!(
                judgement.evidence.is_some(),
                !matches!(judgement.status, Status::Unknown(_))
            );
        }
    }
}
