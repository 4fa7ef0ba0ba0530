//! Tests of merging the joint states of several publishers into one state.

use std::f64::consts::{PI, TAU};

use super::*;

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

    // one of the publishers stops
    let due = monitor.time_to_heartbeat(at(0.2));
    assert_eq!(due, Duration::from_millis(100));
    monitor.on_heartbeat(at(0.45));
    let due = monitor.time_to_heartbeat(at(0.45)).as_secs_f64();
    assert!((0.05..0.06).contains(&due), "{due}");
    let evaluation = monitor.on_joint_state(part(2, 0.6, &[("elbow", 0.0)]), at(0.6));
    let reason = evaluation.status.reason().unwrap().to_string();
    assert_eq!(code(&evaluation), "stale");
    assert!(reason.contains("'shoulder' is 0.600 s old") && !reason.contains("elbow"), "{reason}");
    let evaluation = monitor.on_joint_state(part(3, 0.6, &[("shoulder", 0.0)]), at(0.6));
    assert_eq!(code(&evaluation), "FREE", "another takes its place");
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
    let broken = JointStateInput { positions: vec![0.0; 2], ..part(2, 0.2, &[("gripper", 0.0)]) };
    let broken = monitor.on_joint_state(broken, at(0.2));
    assert_eq!(code(&broken), "FREE");
    assert!(broken.warnings.iter().any(|w| w.contains("1 names and 2 positions")), "{:?}", broken.warnings);
    // the robot's own joint states have stopped
    assert_eq!(code(&monitor.on_joint_state(part(2, 0.6, &[("gripper", 0.0)]), at(0.6))), "stale");
    // the gripper's message is removed when it becomes stale
    assert!(monitor.on_joint_state(state(1.2, FREE), at(1.2)).warnings.is_empty());
}

#[test]
fn of_each_joint_the_last_word_counts() {
    let mut monitor = monitor();
    monitor.on_joint_state(part(1, 0.0, &[("shoulder", 0.0), ("elbow", f64::NAN)]), at(0.0));
    assert_eq!(code(&monitor.on_heartbeat(at(0.0))), "non_finite");
    assert_eq!(code(&monitor.on_joint_state(part(2, 0.1, &[("elbow", 0.0)]), at(0.1))), "FREE");
    // a malformed message affects all joints that it names
    let cut = JointStateInput { positions: vec![0.0], ..part(1, 0.2, &[("shoulder", 0.0), ("other", 0.0)]) };
    assert_eq!(code(&monitor.on_joint_state(cut, at(0.2))), "malformed");
    assert_eq!(code(&monitor.on_joint_state(part(2, 0.3, &[("elbow", 0.0)]), at(0.3))), "malformed");
    assert_eq!(code(&monitor.on_joint_state(part(3, 0.4, &[("shoulder", 0.0)]), at(0.4))), "FREE");
}

#[test]
fn a_played_bag_is_one_publisher_with_the_states_of_several() {
    let mut monitor = monitor();
    monitor.on_joint_state(part(1, 0.10, &[("shoulder", 0.0)]), at(0.1));
    assert_eq!(code(&monitor.on_joint_state(part(1, 0.09, &[("elbow", 0.0)]), at(0.1))), "FREE");
    assert_eq!(code(&monitor.on_joint_state(part(1, 0.11, &[("shoulder", 0.0)]), at(0.11))), "FREE");
    assert_eq!(code(&monitor.on_joint_state(part(1, 0.10, &[("elbow", 0.0)]), at(0.11))), "FREE");
    assert_eq!(code(&monitor.on_joint_state(part(1, 0.08, &[("elbow", 0.0)]), at(0.11))), "out_of_order");
}

#[test]
fn what_is_only_received_is_evaluated_with_the_next_state() {
    let mut monitor = monitor();
    monitor.receive(part(1, 0.0, &[("shoulder", 0.0)]), at(0.0));
    assert_eq!(code(&monitor.on_joint_state(part(2, 0.0, &[("elbow", 0.0)]), at(0.0))), "FREE");
}

#[test]
fn velocities_of_several_publishers_are_those_of_one_robot() {
    let mut monitor = look_ahead();
    let with = |from, name, velocity| JointStateInput {
        velocities: vec![velocity],
        ..part(from, 0.0, &[(name, 0.0)])
    };
    monitor.receive(with(1, "shoulder", 0.0), at(0.0));
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
    // the robot's messages were removed: the status is not FREE
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "partial");
    assert_eq!(code(&monitor.on_joint_state(state(0.2, FREE), at(0.2))), "FREE");
}

/// A publisher that was left running beside the driver: which of the two is correct is unknown.
#[test]
fn what_publishers_contradict_is_unknown() {
    let mut monitor = monitor();
    let driver = |seconds| part(1, seconds, &[("shoulder", 0.0), ("elbow", 1.2)]);
    monitor.on_joint_state(driver(0.0), at(0.0));
    let told = monitor.on_joint_state(part(2, 0.02, &[("shoulder", 0.0), ("elbow", COLLIDING[1])]), at(0.02));
    assert_eq!(code(&told), "contradiction");
    let reason = told.status.reason().unwrap().to_string();
    assert!(
        reason.contains("joint 'elbow' is reported at 3.14") && reason.contains("at 1.2 by two"),
        "{reason}"
    );
    // a publisher that is slightly behind, or has been silent for a while, is no contradiction
    let near = monitor.on_joint_state(part(2, 0.04, &[("shoulder", 0.0), ("elbow", 1.21)]), at(0.04));
    assert_eq!(code(&near), "FREE");
    let later = monitor.on_joint_state(part(2, 0.4, &[("shoulder", 0.0), ("elbow", 2.0)]), at(0.4));
    assert_ne!(code(&later), "contradiction");
}

/// A relay of the driver's messages lags by the joint's motion since then; a larger difference is not a lag.
#[test]
fn who_lags_behind_a_moving_joint_contradicts_nobody() {
    for (behind, expected) in [(0.15, "FREE"), (0.4, "contradiction")] {
        let mut monitor = monitor();
        let mut driver = part(1, 0.0, &[("shoulder", 0.0), ("elbow", 1.0)]);
        driver.velocities = vec![0.0, 1.0];
        monitor.on_joint_state(driver, at(0.0));
        let relay = part(2, 0.01, &[("shoulder", 0.0), ("elbow", 1.0 - behind)]);
        assert_eq!(code(&monitor.on_joint_state(relay, at(0.01))), expected, "{behind}");
    }
}

/// A continuous joint, and further joints.
fn turning(rest: &str) -> Monitor {
    let text = format!(
        "<robot name='r'><link name='a'/><link name='b'><collision><geometry><sphere radius='1'/></geometry></collision></link>
        <joint name='j' type='continuous'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/></joint>{rest}</robot>"
    );
    let robot = RobotModel::from_urdf(&text, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    let mut monitor = monitor();
    monitor.set_checker(Arc::new(Revision::new(checker, 2, 0)));
    monitor
}

/// One publisher counts turns from its encoder's zero, the other from its start position.
#[test]
fn whole_turns_of_a_continuous_joint_contradict_nobody() {
    let geared = "<link name='c'/><joint name='gear' type='continuous'><parent link='b'/><child link='c'/><axis xyz='0 0 1'/>
        <mimic joint='j' multiplier='0.5'/></joint>";
    for (rest, other, expected) in [
        ("", TAU, "FREE"),
        ("", -9.0 * TAU + 0.01, "FREE"),
        ("", 3.0 * TAU - 0.2, "contradiction"),
        ("", PI, "contradiction"),
        // half a turn of the joint that mimics it
        (geared, TAU, "contradiction"),
        (geared, 0.01, "FREE"),
    ] {
        let mut monitor = turning(rest);
        monitor.on_joint_state(part(1, 0.0, &[("j", 0.02)]), at(0.0));
        assert_eq!(
            code(&monitor.on_joint_state(part(2, 0.01, &[("j", other)]), at(0.01))),
            expected,
            "{other}"
        );
    }
}

/// A joint is reported once, however many publishers contradict each other about it.
#[test]
fn a_joint_is_reported_once_whichever_publisher_contradicts() {
    let mut monitor = monitor();
    for source in 1..=5 {
        let elbow = 0.2 * f64::from(source);
        let told = monitor.on_joint_state(
            part(source, 0.01 * f64::from(source), &[("shoulder", 0.0), ("elbow", elbow)]),
            at(0.01 * f64::from(source)),
        );
        let more = match told.status.reason() {
            Some(Reason::Contradiction { more, .. }) => Some(*more),
            _ => None,
        };
        assert_eq!(more, (source > 1).then_some(0));
    }
}

/// A chain of prismatic joints.
#[test]
fn of_many_contradictions_one_is_reported_and_the_rest_counted() {
    const JOINTS: usize = 12;
    let joint = |i: usize| {
        format!(
            r#"<link name="l{}"/><joint name="j{i}" type="prismatic"><parent link="l{i}"/><child link="l{}"/><axis xyz="0 0 1"/>
            <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>"#,
            i + 1,
            i + 1
        )
    };
    let text = format!(
        r#"<robot name="chain"><link name="l0"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>{}</robot>"#,
        (0..JOINTS).map(joint).collect::<String>()
    );
    let robot = RobotModel::from_urdf(&text, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    let mut monitor = monitor();
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 0)));
    let names: Vec<String> = (0..JOINTS).map(|i| format!("j{i}")).collect();
    let all =
        |position: f64| -> Vec<(&str, f64)> { names.iter().map(|name| (name.as_str(), position)).collect() };
    monitor.on_joint_state(part(1, 0.0, &all(0.0)), at(0.0));
    let told = monitor.on_joint_state(part(2, 0.01, &all(1.0)), at(0.01));
    let reason = told.status.reason().unwrap().to_string();
    assert!(reason.contains("joint 'j0'") && reason.contains("11 more joints"), "{reason}");
}
