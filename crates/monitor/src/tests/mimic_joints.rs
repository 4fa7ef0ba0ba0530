//! Tests of reported positions of mimic joints: contradictions with the leader joint and between publishers.

use super::*;

const CASES_IN_ONE_MESSAGE: [(f64, &str); 8] = [
    (0.0, "FREE"),
    (0.019, "FREE"),
    (-0.021, "contradiction"),
    (1.5, "contradiction"),
    (std::f64::consts::TAU, "contradiction"),
    (f64::NAN, "non_finite"),
    (f64::NEG_INFINITY, "non_finite"),
    (1e300, "malformed"),
];

fn part(from: u8, seconds: f64, joints: &[(&str, f64)]) -> JointStateInput {
    JointStateInput { source: SourceId([from; 16]), ..input(seconds, joints) }
}

fn with_follower(seconds: f64, mimic_joint: f64) -> JointStateInput {
    input(seconds, &[("shoulder", 0.0), ("follower", mimic_joint), ("elbow", 0.0)])
}

fn monitor_that_warns() -> Monitor {
    let mut monitor = monitor();
    monitor.set_settings(MonitorSettings {
        distance_limit: 5.0,
        mimic_contradiction_is_unknown: false,
        ..MonitorSettings::default()
    });
    monitor
}

fn monitor_of(urdf: &str) -> Monitor {
    let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    let mut monitor = monitor();
    monitor.set_checker(Arc::new(Revision::new(checker, 2, 0)));
    monitor
}

#[test]
fn wrong_mimic_joints_of_one_message_are_unknown_and_named() {
    for (mimic_joint, expected) in CASES_IN_ONE_MESSAGE {
        let evaluation = monitor().on_joint_state(with_follower(0.0, mimic_joint), at(0.0));
        assert_eq!(code(&evaluation), expected, "{mimic_joint}");
        assert_eq!(evaluation.robot_state.is_some(), expected == "FREE");
        let reason = evaluation.status.reason().map_or("'follower'".to_owned(), ToString::to_string);
        assert!(reason.contains("'follower'"), "{reason}");
    }
    let twice = input(0.0, &[("shoulder", 0.0), ("elbow", 0.0), ("follower", 0.0), ("follower", 0.0)]);
    let twice = monitor().on_joint_state(twice, at(0.0));
    assert_eq!(code(&twice), "malformed");
    assert!(twice.status.reason().unwrap().to_string().contains("'follower' stands in it twice"));
}

#[test]
fn wrong_mimic_joints_of_a_message_of_their_own_are_unknown_as_well() {
    for (mimic_joint, expected) in CASES_IN_ONE_MESSAGE {
        for follower_first in [true, false] {
            let mut monitor = monitor();
            let parts = [
                part(1, 0.0, &[("shoulder", 0.0), ("elbow", 0.0)]),
                part(2, 0.0, &[("follower", mimic_joint)]),
            ];
            let [first, last] = if follower_first { [1, 0] } else { [0, 1] };
            monitor.on_joint_state(parts[first].clone(), at(0.0));
            let evaluation = monitor.on_joint_state(parts[last].clone(), at(0.0));
            assert_eq!(code(&evaluation), expected, "{mimic_joint}");
            // the contradiction ends when the report is stale, or when a newer one is received
            let own = part(2, 0.1, &[("follower", 0.0)]);
            assert_eq!(code(&monitor.on_joint_state(own, at(0.1))), "FREE", "after {mimic_joint}");
            monitor.on_joint_state(parts[1].clone(), at(0.2));
            assert_eq!(
                code(&monitor.on_joint_state(state(0.8, FREE), at(0.8))),
                "FREE",
                "long after {mimic_joint}"
            );
        }
    }
}

#[test]
fn a_message_without_a_position_for_each_name_speaks_for_its_mimic_joints() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    let cut = JointStateInput {
        names: vec!["follower".to_owned(), "other".to_owned()],
        ..part(2, 0.1, &[("a", 0.0)])
    };
    assert_eq!(code(&monitor.on_joint_state(cut, at(0.1))), "malformed");
    let long = part(2, 0.2, &[("follower", 0.0), (long_name(), 0.0)]);
    assert_eq!(code(&monitor.on_joint_state(long, at(0.2))), "malformed");
    assert_eq!(code(&monitor.on_joint_state(part(2, 0.3, &[("follower", 0.0)]), at(0.3))), "FREE");
    // errors in the messages of another robot's driver have no effect
    let stranger = JointStateInput { positions: vec![0.0; 2], ..part(3, 0.4, &[("other", 0.0)]) };
    assert_eq!(code(&monitor.on_joint_state(stranger, at(0.4))), "FREE");
}

/// If two publishers disagree, the correct one is unknown, in whatever order their messages are received.
#[test]
fn publishers_that_disagree_about_a_mimic_joint_are_unknown_whoever_was_last() {
    let mut monitor = monitor();
    for round in 0..4u8 {
        let seconds = 0.04 * f64::from(round);
        monitor.on_joint_state(with_follower(seconds, 0.0), at(seconds));
        let other = part(2, seconds + 0.02, &[("follower", 1.5)]);
        assert_eq!(code(&monitor.on_joint_state(other, at(seconds + 0.02))), "contradiction");
        let driver = monitor.on_joint_state(with_follower(seconds + 0.03, 0.0), at(seconds + 0.03));
        assert_eq!(code(&driver), "contradiction");
    }
    assert_eq!(code(&monitor.on_joint_state(with_follower(0.5, 0.0), at(0.5))), "FREE");
}

/// A relay publishes old messages: its leader and its mimic joint agree with each other.
#[test]
fn a_moving_mimic_joint_reported_later_than_its_leader_is_no_contradiction() {
    for (message, expected) in [
        // 0.15 s late at 1 rad/s, with the leader or without
        (vec![("elbow", 1.0), ("follower", 1.0)], "FREE"),
        (vec![("follower", 1.0)], "FREE"),
        (vec![("follower", 0.5)], "contradiction"),
        (vec![("elbow", 1.15), ("follower", 1.0)], "contradiction"),
    ] {
        let mut monitor = monitor();
        let driver = JointStateInput {
            velocities: vec![0.0, 1.0],
            ..part(1, 0.0, &[("shoulder", 0.0), ("elbow", 1.15)])
        };
        monitor.on_joint_state(driver, at(0.0));
        let evaluation = monitor.on_joint_state(part(2, 0.01, &message), at(0.01));
        assert_eq!(code(&evaluation), expected, "{message:?}");
    }
}

/// However large, no velocity makes a report with a large error agree.
#[test]
fn velocities_excuse_half_a_radian_at_most() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    for velocity in [1e9, f64::INFINITY, f64::NAN] {
        let fast = JointStateInput { velocities: vec![velocity], ..part(2, 0.0, &[("follower", 0.6)]) };
        assert_eq!(code(&monitor.on_joint_state(fast, at(0.0))), "contradiction", "{velocity}");
    }
}

#[test]
fn mimic_contradictions_may_be_warnings_but_no_number_is_never_one() {
    for (mimic_joint, expected) in CASES_IN_ONE_MESSAGE {
        let evaluation = monitor_that_warns().on_joint_state(with_follower(0.0, mimic_joint), at(0.0));
        if expected == "contradiction" {
            assert_eq!(code(&evaluation), "FREE", "{mimic_joint}");
            let warned = format!("'follower' is reported at {mimic_joint}, but it mimics 'elbow'");
            assert!(
                evaluation.warnings.iter().any(|warning| warning.contains(&warned)),
                "{:?}",
                evaluation.warnings
            );
        } else {
            assert_eq!((code(&evaluation), evaluation.warnings.len()), (expected, 0), "{mimic_joint}");
        }
    }
}

/// Sliding fingers, and mimic joints of mimic joints, of fixed joints and of continuous ones, with multiplier and
/// offset.
#[test]
fn mimic_joints_of_every_kind_are_compared_with_where_they_are_checked() {
    let joint = |name: &str, kind: &str, mimic: &str| {
        format!(
            r#"<link name="{name}_link"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
            <joint name="{name}" type="{kind}"><parent link="base"/><child link="{name}_link"/><axis xyz="0 0 1"/>
            <limit lower="-9" upper="9" effort="1" velocity="1"/>{mimic}</joint>"#
        )
    };
    let joints = [
        joint("finger", "prismatic", ""),
        joint("other", "prismatic", "<mimic joint='finger' multiplier='-1' offset='0.1'/>"),
        joint("third", "revolute", "<mimic joint='other' multiplier='10'/>"),
        joint("bolt", "fixed", ""),
        joint("cap", "revolute", "<mimic joint='bolt' multiplier='7' offset='0.3'/>"),
        joint("wheel", "continuous", ""),
        joint("gear", "continuous", "<mimic joint='wheel' multiplier='-2'/>"),
        joint("still", "prismatic", "<mimic joint='finger' multiplier='0' offset='0.2'/>"),
    ];
    let urdf = format!("<robot name='r'><link name='base'/>{}</robot>", joints.concat());
    // finger at 0.04, wheel at 3
    for (name, right, wrong) in [
        ("other", 0.0615, 0.0625),
        ("third", 0.6, 0.63),
        ("cap", 0.31, 0.0),
        ("gear", -6.0 + 2.0 * std::f64::consts::TAU, -5.9),
        ("still", 0.2, 0.04),
    ] {
        for (value, expected) in [(right, true), (wrong, false)] {
            let state = input(0.0, &[("finger", 0.04), ("wheel", 3.0), (name, value)]);
            let evaluation = monitor_of(&urdf).on_joint_state(state, at(0.0));
            assert_eq!(
                code(&evaluation) != "contradiction",
                expected,
                "{name} at {value}: {:?}",
                evaluation.status
            );
            let apart = part(2, 0.0, &[(name, value)]);
            let mut monitor = monitor_of(&urdf);
            monitor.on_joint_state(input(0.0, &[("finger", 0.04), ("wheel", 3.0)]), at(0.0));
            let evaluation = monitor.on_joint_state(apart, at(0.0));
            assert_eq!(code(&evaluation) != "contradiction", expected, "{name} alone at {value}");
        }
    }
}

#[test]
fn of_many_mimic_contradictions_one_is_reported_and_the_rest_counted() {
    let mimic_joint = |i: usize| {
        format!(
            r#"<link name="l{i}"/><joint name="f{i}" type="continuous"><parent link="l"/><child link="l{i}"/><mimic joint="j"/></joint>"#
        )
    };
    let urdf = format!(
        r#"<robot name="fan"><link name="base"/><link name="l"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
        <joint name="j" type="continuous"><parent link="base"/><child link="l"/></joint>{}</robot>"#,
        (0..5).map(mimic_joint).collect::<String>()
    );
    let names: Vec<String> = (0..5).map(|i| format!("f{i}")).collect();
    let joints: Vec<(&str, f64)> =
        [("j", 0.0)].into_iter().chain(names.iter().map(|name| (name.as_str(), 1.0))).collect();
    let evaluation = monitor_of(&urdf).on_joint_state(input(0.0, &joints), at(0.0));
    let reason = evaluation.status.reason().unwrap().to_string();
    assert!(reason.contains("'f0'") && reason.contains("4 more mimic joints"), "{reason}");
}

#[test]
fn positions_that_contradicted_each_other_are_no_more_right_when_they_are_stale() {
    let mut monitor = monitor();
    assert_eq!(code(&monitor.on_joint_state(with_follower(0.0, 1.5), at(0.0))), "contradiction");
    let stale = monitor.on_heartbeat(at(10.0));
    assert_eq!(code(&stale), "stale");
    assert!(stale.status.reason().unwrap().is_about_positions());
    let silent = self::monitor().on_heartbeat(at(10.0));
    assert!(!silent.status.reason().unwrap().is_about_positions());
}
