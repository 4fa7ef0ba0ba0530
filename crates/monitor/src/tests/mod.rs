//! Tests of every rule of the monitor, without a network; shared helpers of the other test files.

#![expect(clippy::float_cmp, reason = "0 and infinity are said exactly")]

mod attached_objects;
mod between_states;
mod check_budget;
mod contact_history;
mod contacts;
mod free_status_property;
mod incomplete;
mod mimic_joints;
mod models;
mod publishers;
mod root_jumps;
mod root_location;
mod self_and_world;
mod separation;
mod speed;
mod time_to_contact;
mod tracked_obstacles;
mod transform_joints;
mod unpositioned;
mod unseen_motion;
mod world_updates;

use clearance_checker::CollisionChecker;
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::Settings;
use clearance_scene::World;
use std::sync::Arc;
use std::time::Duration;

use super::*;

/// Two arms of one metre that fold: free at zero, the second on the base at pi. The joint `mimic_joint` mimics the
/// elbow.
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

/// A complete joint state stamped `seconds` after the start.
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

/// A monitor with a look-ahead of half a second; the acceleration limit is 0.1 rad/s².
fn look_ahead() -> Monitor {
    let mut monitor = monitor();
    monitor.set_settings(settings_of_lookout());
    monitor
}

/// A joint state with velocities.
fn moving(seconds: f64, positions: [f64; 2], velocities: &[f64]) -> JointStateInput {
    JointStateInput { velocities: velocities.to_vec(), ..state(seconds, positions) }
}

fn code(evaluation: &Evaluation) -> &'static str {
    evaluation.status.reason().map_or(evaluation.status.word(), Reason::code)
}

#[test]
fn what_is_right_is_evaluated() {
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

/// A name that is one byte too long.
fn long_name() -> &'static str {
    Box::leak("n".repeat(1025).into_boxed_str())
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
        (input(0.0, &with(long_name(), 0.0)), "malformed", "has 1025 bytes, more than the limit of 1024"),
        (state(-0.6, FREE), "stale", "0.600 s"),
        (state(0.6, FREE), "future_stamp", "0.600 s"),
    ] {
        let evaluation = monitor().on_joint_state(input.clone(), at(0.0));
        assert_eq!(code(&evaluation), expected, "{input:?}");
        let reason = evaluation.status.reason().unwrap().to_string();
        assert!(reason.contains(named), "{reason}");
        assert!(evaluation.checked_state.is_none() && evaluation.distance().is_nan());
    }
}

#[test]
fn what_is_odd_is_evaluated_with_a_warning() {
    let whole = [("shoulder", 0.0), ("elbow", 0.0)];
    let with = |name, value| [whole[0], whole[1], (name, value)];
    let unstamped = JointStateInput { stamp: Time::ZERO, ..state(0.0, FREE) };
    for (input, warned) in [
        (input(0.0, &with("follower", 0.01)), None),
        (input(0.0, &with("gripper", f64::NAN)), Some("'gripper'")),
        (state(0.0, [0.0, 3.2 + 1e-4]), None),
        (state(0.0, [3.3, 0.0]), Some("joint 'shoulder' is at 3.3, outside its limits")),
        (unstamped, Some("stamp")),
    ] {
        let evaluation = monitor().on_joint_state(input.clone(), at(0.0));
        assert!(evaluation.checked_state.is_some(), "{input:?}: {}", code(&evaluation));
        assert_eq!(evaluation.warnings.len(), usize::from(warned.is_some()), "{input:?}");
        assert!(evaluation.warnings.iter().all(|w| w.contains(warned.unwrap_or_default())));
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

    // a joint state received before the model is evaluated once the model is loaded
    monitor.set_checker(revision(1));
    assert_eq!(code(&monitor.on_heartbeat(at(0.2))), "FREE");

    let mut monitor = self::monitor();
    assert_eq!(code(&monitor.on_heartbeat(at(0.0))), "no_joint_state");
    let no_clock = Now { ros: None, ..at(0.0) };
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), no_clock)), "no_clock");
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "FREE");
}

#[test]
fn a_heartbeat_repeats_the_last_evaluation_until_it_is_stale() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    for (seconds, expected) in [(0.1, "FREE"), (0.5, "FREE"), (0.51, "stale"), (9.0, "stale")] {
        let evaluation = monitor.on_heartbeat(at(seconds));
        assert_eq!(code(&evaluation), expected, "after {seconds} s");
        assert!((evaluation.age.unwrap() - seconds).abs() < 1e-9);
    }
    assert_eq!(code(&monitor.on_joint_state(state(9.1, FREE), at(9.1))), "FREE");
}

/// A query during a long check must not return an outdated status.
#[test]
fn an_evaluation_ages_while_the_monitor_is_busy() {
    let mut monitor = monitor();
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    let fresh = evaluation.clone().aged(at(0.49));
    assert_eq!((code(&fresh), fresh.robot_state.is_some()), ("FREE", true));
    assert!((fresh.age.unwrap() - 0.49).abs() < 1e-9);
    let old = evaluation.aged(at(0.51));
    assert_eq!((code(&old), old.robot_state.is_some(), old.checked_state.is_some()), ("stale", false, false));
    assert_eq!((old.speed_scale, old.stale_world.is_some()), (0.0, false));
    assert!(old.status.reason().unwrap().to_string().contains("evaluated for 0.510 s"));
}

#[test]
fn a_robot_without_collision_geometry_is_never_free() {
    let urdf = r#"<robot name="picture"><link name="base"><visual><geometry><sphere radius="1"/></geometry></visual></link></robot>"#;
    let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    let mut monitor = monitor();
    monitor.set_checker(Arc::new(Revision::new(checker, 2, 0)));
    let evaluation = monitor.on_joint_state(input(0.0, &[("any", 0.0)]), at(0.0));
    assert_eq!(code(&evaluation), "no_geometry");
    assert_eq!(code(&monitor.on_heartbeat(at(9.0))), "no_geometry");
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
fn a_stamp_before_the_last_evaluated_one_of_its_publisher_is_out_of_order() {
    let mut monitor = monitor();
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.1))), "FREE");
    assert_eq!(code(&monitor.on_joint_state(state(0.05, FREE), at(0.12))), "out_of_order");
    assert_eq!(code(&monitor.on_heartbeat(at(0.15))), "out_of_order");
    // the same stamp again is in order, and so is an older one of another publisher
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.16))), "FREE");
    let other = JointStateInput { source: SourceId([2; 16]), ..state(0.05, FREE) };
    assert_eq!(code(&monitor.on_joint_state(other, at(0.17))), "FREE");
    // a message that was not evaluated does not define an order
    monitor.on_joint_state(state(0.3, [f64::NAN, 0.0]), at(0.3));
    assert_eq!(code(&monitor.on_joint_state(state(0.2, FREE), at(0.31))), "FREE");
}

#[test]
fn a_clock_that_was_set_back_orders_anew() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(100.0, FREE), at(100.0));
    let restarted = Now { ros: at(0.0).ros, steady: at(100.1).steady };
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), restarted)), "FREE");
}

#[test]
fn states_received_before_the_clock_was_set_far_back_are_dropped() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(100.0, FREE), at(100.0));
    // a step back within the tolerance has no effect
    let stepped = Now { ros: at(99.8).ros, steady: at(100.0).steady };
    assert_eq!(code(&monitor.on_heartbeat(stepped)), "FREE");
    let restarted = |seconds| Now { ros: at(seconds).ros, steady: at(100.1 + seconds).steady };
    let evaluation = monitor.on_heartbeat(restarted(0.0));
    assert_eq!((code(&evaluation), evaluation.stamp, evaluation.age), ("clock_jump", None, None));
    assert!(evaluation.status.reason().unwrap().to_string().contains("99.800 s"), "{:?}", evaluation.status);
    assert_eq!(code(&monitor.on_heartbeat(restarted(0.1))), "clock_jump");
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), restarted(0.1))), "FREE");
    // a step forward makes the state stale
    assert_eq!(code(&monitor.on_heartbeat(Now { ros: at(50.0).ros, steady: at(100.3).steady })), "stale");
}

#[test]
fn nothing_is_known_while_checking_is_disabled() {
    let mut monitor = monitor();
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), at(0.0))), "FREE");
    monitor.set_enabled(false);
    assert_eq!(monitor.time_to_heartbeat(at(0.0)), Duration::ZERO);
    let evaluation = monitor.on_heartbeat(at(0.0));
    assert!(code(&evaluation) == "disabled" && evaluation.robot_state.is_none());
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.1))), "disabled");
    // also if the state has become stale
    assert_eq!(code(&monitor.on_heartbeat(at(9.0))), "disabled");
    monitor.set_enabled(true);
    assert_eq!(code(&monitor.on_heartbeat(at(9.0))), "stale");
    assert_eq!(code(&monitor.on_joint_state(state(9.1, FREE), at(9.1))), "FREE");
}

#[test]
fn a_check_that_takes_too_long_is_unknown_unless_it_found_a_collision() {
    let mut monitor = monitor();
    monitor.set_settings(MonitorSettings {
        check_deadline: 1e-9,
        distance_limit: 5.0,
        ..settings_of_lookout()
    });
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(code(&evaluation), "deadline");
    let reason = evaluation.status.reason().unwrap().to_string();
    assert!(
        reason.contains("1 pairs were decided") && reason.contains("'base'") && reason.contains("'ball'"),
        "{reason}"
    );
    assert!(
        evaluation.checked_state.is_none()
            && evaluation.distance().is_nan()
            && evaluation.robot_state.is_some()
    );
    assert_eq!(evaluation.time_to_contact(), 0.0);
    assert!(evaluation.warnings[0].contains("check_deadline"), "{:?}", evaluation.warnings);
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "deadline");
    assert_eq!(code(&monitor.on_heartbeat(at(1.0))), "stale");

    monitor.set_settings(MonitorSettings { check_deadline: 10.0, ..settings_of_lookout() });
    assert_eq!(code(&monitor.on_joint_state(state(1.0, COLLIDING), at(1.0))), "COLLIDING");
    let free = monitor.on_joint_state(state(1.1, FREE), at(1.1));
    assert!(code(&free) == "FREE" && (free.distance() - 1.7).abs() < 1e-9, "{}", free.distance());
}

/// With a tolerance, a reported distance is never larger than the true one, and a free state stays FREE.
#[test]
fn distances_within_a_tolerance_are_reported_too_small_if_anything() {
    let mut exact = monitor();
    let mut tolerant = monitor();
    let allowed = |settings: &mut MonitorSettings| {
        settings.distance_absolute_tolerance = 0.01;
        settings.distance_relative_tolerance = 0.2;
        settings.influence_distance = 1.0;
        settings.clone()
    };
    tolerant
        .set_settings(allowed(&mut MonitorSettings { distance_limit: 5.0, ..MonitorSettings::default() }));
    let mut smaller = 0;
    for i in 0..200 {
        let seconds = f64::from(i) * 0.01;
        let folding = [0.1 * seconds, 1.65 * seconds];
        let [exact, tolerant] = [&mut exact, &mut tolerant]
            .map(|monitor| monitor.on_joint_state(state(seconds, folding), at(seconds)));
        assert_eq!(tolerant.status, exact.status);
        let (told, truth) = (tolerant.distance(), exact.distance());
        assert!(told <= truth && told >= 0.8 * truth - 0.01, "{told} m instead of {truth} m");
        assert_eq!(told == 0.0, tolerant.status == Status::Colliding);
        smaller += u32::from(told < truth);
    }
    assert!(smaller > 100, "only {smaller} distances made use of the tolerance");
}

#[test]
fn a_new_model_or_setting_evaluates_the_last_joint_state_anew() {
    let mut monitor = monitor();
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(evaluation.revision.unwrap().model, 1);
    assert!(monitor.time_to_heartbeat(at(0.0)) > Duration::ZERO);

    monitor.set_checker(revision(2));
    assert_eq!(monitor.time_to_heartbeat(at(0.0)), Duration::ZERO);
    assert_eq!(monitor.on_heartbeat(at(0.1)).revision.unwrap().model, 2);

    monitor.set_settings(MonitorSettings { distance_limit: 1.0, ..MonitorSettings::default() });
    let evaluation = monitor.on_heartbeat(at(0.2));
    assert_eq!((code(&evaluation), evaluation.distance()), ("FREE", f64::INFINITY));

    // a rejected model has no effect
    monitor.note_model_fault("not XML".to_owned());
    assert_eq!(code(&monitor.on_heartbeat(at(0.3))), "FREE");
}

#[test]
fn the_next_heartbeat_is_due_after_its_period_or_when_the_evaluation_turns_stale() {
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
    let seen =
        |seconds| Some(Observation { stamp: time(START + seconds), at: Duration::from_secs_f64(seconds) });
    let watched = |seen| {
        let mut revision = Arc::into_inner(revision(2)).unwrap();
        let source = |name: &str, seen| WorldSource { name: name.to_owned(), seen, ttl: 0.25 };
        revision.sources = vec![
            source("/camera", seen),
            source("/other", Some(Observation { stamp: time(START + 9.0), at: Duration::from_secs(9) })),
        ];
        revision.warnings = vec!["a cloud was dropped".to_owned()];
        Arc::new(revision)
    };
    let mut monitor = monitor();
    monitor.set_checker(watched(None));
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(code(&evaluation), "stale_world");
    assert!(evaluation.status.reason().unwrap().to_string().contains("'/camera'"));
    assert!(
        evaluation.checked_state.is_none()
            && evaluation.robot_state.is_some()
            && evaluation.distance().is_nan()
    );
    assert_eq!(&*evaluation.warnings, ["a cloud was dropped"]);

    monitor.set_checker(watched(seen(0.0)));
    assert_eq!(code(&monitor.on_heartbeat(at(0.2))), "FREE");
    let due = monitor.time_to_heartbeat(at(0.2));
    assert!((0.05..0.06).contains(&due.as_secs_f64()), "{due:?}");
    let evaluation = monitor.on_heartbeat(at(0.2 + due.as_secs_f64()));
    assert_eq!((code(&evaluation), evaluation.stale_world.is_some()), ("stale_world", true));
    // nor is it reported to a query while the monitor is busy
    let aged = monitor.on_heartbeat(at(0.2)).aged(at(0.26));
    assert_eq!((code(&aged), aged.stale_world.is_some(), aged.robot_state.is_some()), ("stale", true, true));
    // neither a joint state nor a collision makes the status known
    assert_eq!(code(&monitor.on_joint_state(state(0.3, COLLIDING), at(0.3))), "stale_world");
    // a message that is received late has used up its time-to-live already
    monitor.set_checker(watched(Some(Observation { stamp: time(START), at: Duration::from_secs_f64(0.3) })));
    assert_eq!(code(&monitor.on_heartbeat(at(0.3))), "stale_world");
    monitor.set_checker(watched(seen(0.3)));
    assert_eq!(code(&monitor.on_heartbeat(at(0.31))), "COLLIDING");
    // a stale joint state is reported first
    let evaluation = monitor.on_heartbeat(at(1.0));
    assert_eq!((code(&evaluation), evaluation.stale_world.is_some()), ("stale", true));
    assert!(evaluation.robot_state.is_none());
}

#[test]
fn what_was_rejected_of_the_world_is_reported() {
    let mut monitor = monitor();
    monitor.note_world_faults(vec!["object 'a': no shapes".to_owned()], None);
    assert_eq!(&*monitor.on_joint_state(state(0.0, FREE), at(0.0)).warnings, ["object 'a': no shapes"]);
    monitor.note_world_faults(Vec::new(), None);
    assert!(monitor.on_heartbeat(at(0.1)).warnings.is_empty());
}

#[test]
fn hostile_names_make_no_long_message() {
    let long = "x".repeat(1 << 20);
    let names: Vec<String> = (0..1000).map(|i| format!("{long}{i}")).collect();
    let positions = vec![0.0; names.len()];
    let hostile = JointStateInput { names, positions, ..state(0.0, FREE) };
    let evaluation = monitor().on_joint_state(hostile, at(0.0));
    assert_eq!(code(&evaluation), "partial");
    assert!(evaluation.status.reason().unwrap().to_string().len() < 1000);

    let twice = input(0.0, &[("elbow", 0.0), ("elbow", 1.0), (&long, 0.0)]);
    let evaluation = monitor().on_joint_state(twice, at(0.0));
    assert!(evaluation.warnings.iter().all(|warning| warning.len() < 1000));
}
