//! Tests of `~/find_free_state` requests for the two-link robot. Its URDF has the derivation of the expected results.

use std::f64::consts::PI;
use std::sync::Arc;

use clearance_checker::Question;
use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_monitor::{JointStateInput, Monitor, MonitorSettings, Now, Revision, Time};
use clearance_robot::{MeshFiles, RobotModel, RobotText};
use clearance_scene::{Obstacle, Settings, World};

use super::*;

const URDF: &str = include_str!("../../../../../urdf/two_link/two_link.urdf");
const SRDF: &str = r#"<robot name="two_link">
    <group name="shoulder"><joint name="joint1"/></group>
    <group name="wrist"><joint name="joint2"/></group>
    <group name="nothing"/>
    <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
    <disable_collisions link1="upper" link2="tip" reason="Adjacent"/>
</robot>"#;
const JOINTS: [&str; 2] = ["joint1", "joint2"];
/// Folded onto the base, and joint2 where the ball of the tip reaches the cube of the base, with joint1 at zero.
const ONTO: [f64; 2] = [0.0, PI];
const STRETCHED: [f64; 2] = [0.0, 0.0];

fn first_touch() -> f64 {
    PI - 0.3_f64.asin()
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// The evaluation of the robot at these positions; without positions, no joint state is received.
fn evaluation(world: &World, positions: &[f64]) -> Evaluation {
    let text = RobotText { urdf: URDF, srdf: Some(SRDF), ..RobotText::default() };
    let robot = RobotModel::from_text(&text, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), world, Settings::default()).unwrap();
    let mut monitor = Monitor::new(MonitorSettings::default(), || Duration::ZERO);
    monitor.set_checker(Arc::new(Revision::new(checker, 3, 1)));
    let now = Now { ros: Some(Time::from_nanoseconds(5)), steady: Duration::ZERO };
    if positions.is_empty() {
        return monitor.on_heartbeat(now);
    }
    let (names, positions) = (names(&JOINTS), positions.to_vec());
    monitor.on_joint_state(JointStateInput { names, positions, ..JointStateInput::default() }, now)
}

/// A request with so much time that only broken requests and `timeout` of a test end the search.
fn at(positions: &[f64]) -> FindFreeStateRequest {
    FindFreeStateRequest {
        joint_names: names(&JOINTS[..positions.len()]),
        positions: positions.to_vec(),
        timeout: 3600.0,
        ..FindFreeStateRequest::default()
    }
}

fn ask(request: &FindFreeStateRequest) -> FindFreeStateResponse {
    search_free_state(request, Some(&evaluation(&World::default(), &ONTO)), &mut None)
}

/// A ball around the shoulder, which no joint moves away from the base.
fn with_ball_in_base() -> World {
    let mut world = World::default();
    let ball = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    world.add(Obstacle::of_shape("ball", Pose::translation(0.0, 0.0, 0.0), ball)).unwrap();
    world
}

#[test]
fn a_free_state_is_near_free_and_reached_on_a_free_line() {
    let evaluation = evaluation(&World::default(), &STRETCHED);
    let checker = &evaluation.revision.as_ref().unwrap().checker;
    for clearance in [0.0, 0.05] {
        let request = FindFreeStateRequest { clearance, ..at(&ONTO) };
        let answer = search_free_state(&request, Some(&evaluation), &mut None);
        assert_eq!((answer.result, answer.reason_code.as_str()), (FindFreeStateResponse::FOUND, ""));
        assert_eq!(
            (answer.message.as_str(), &answer.joint_names, &answer.start),
            ("", &names(&JOINTS), &ONTO.to_vec())
        );
        assert_eq!((answer.model_revision, answer.world_revision), (3, 1));

        let q = checker.robot().configuration(&answer.free_state).unwrap();
        let report = checker.check(&q, Question::Distance { limit: 1.0 }, &mut checker.workspace()).clone();
        assert!(report.is_free() && report.nearest.unwrap().distance >= clearance, "{answer:?}");
        let change = (answer.free_state[0] - ONTO[0]).hypot(answer.free_state[1] - ONTO[1]);
        assert!((answer.distance - change).abs() < 1e-12 && answer.distance <= 0.5);
        // the wrist alone has to turn this far; the shoulder turns the cube's face away, or a corner nearer
        assert!(answer.distance < 1.3 * (PI - first_touch()) + 2.0 * clearance, "{answer:?}");
        assert!((0.0..=1.0).contains(&answer.exit) && answer.exit > 0.5, "{answer:?}");
    }
}

#[test]
fn without_names_the_search_begins_at_the_current_state() {
    assert_eq!(ask(&at(&[])).start, ONTO);
    let alone = FindFreeStateRequest { joint_names: names(&["joint1"]), positions: vec![0.5], ..at(&[]) };
    assert_eq!(ask(&alone).start, [0.5, PI]);
    let silent = evaluation(&World::default(), &[]);
    let answer = search_free_state(&at(&[]), Some(&silent), &mut None);
    assert_eq!((answer.result, answer.reason_code.as_str()), (0, "no_joint_state"));
    let answer = search_free_state(&alone, Some(&silent), &mut None);
    assert!(answer.message.contains("'joint2' stand at their defaults"), "{}", answer.message);
    let answer = search_free_state(&at(&ONTO), None, &mut None);
    assert_eq!((answer.result, answer.reason_code.as_str()), (0, "no_model"));
}

#[test]
fn a_free_state_stays_unless_it_lacks_the_clearance() {
    let answer = ask(&at(&STRETCHED));
    assert_eq!(
        (answer.result, answer.start.as_slice()),
        (FindFreeStateResponse::ALREADY_FREE, &STRETCHED[..])
    );
    assert!(answer.free_state.is_empty() && answer.distance == 0.0);
    // stretched, the tip is 0.7 m from the base
    let near = |clearance| ask(&FindFreeStateRequest { clearance, ..at(&STRETCHED) }).result;
    assert_eq!(near(0.69), FindFreeStateResponse::ALREADY_FREE);
    assert_ne!(near(0.71), FindFreeStateResponse::ALREADY_FREE);
}

#[test]
fn only_what_may_move_moves() {
    let of_wrist = ask(&FindFreeStateRequest { group: "wrist".to_owned(), ..at(&ONTO) });
    let locked = ask(&FindFreeStateRequest { locked_joints: names(&["joint1"]), ..at(&ONTO) });
    for answer in [of_wrist, locked] {
        assert_eq!((answer.result, answer.free_state[0]), (FindFreeStateResponse::FOUND, 0.0));
        assert!((answer.distance - (PI - first_touch())).abs() < 0.01, "{answer:?}");
        assert!(answer.free_state[1].abs() < first_touch(), "within the limits of joint2");
    }
    // the shoulder turns with base and tip
    for request in [
        FindFreeStateRequest { locked_joints: names(&JOINTS), ..at(&ONTO) },
        FindFreeStateRequest { group: "wrist".to_owned(), locked_joints: names(&["joint2"]), ..at(&ONTO) },
    ] {
        let answer = ask(&request);
        let found = (answer.result, answer.reason_code.as_str());
        assert_eq!(found, (FindFreeStateResponse::NONE_FOUND, "not_movable"));
        let mut pair = [answer.unmoved_pair.body_a.as_str(), answer.unmoved_pair.body_b.as_str()];
        pair.sort_unstable();
        assert_eq!(pair, ["base", "tip"]);
        assert!(answer.message.contains("locked_joints") && answer.free_state.is_empty(), "{answer:?}");
    }
}

#[test]
fn none_is_found_within_limits_that_are_too_narrow() {
    let none = |request: &FindFreeStateRequest, reason: &str, word: &str| {
        let answer = ask(request);
        assert_eq!((answer.result, answer.reason_code.as_str()), (FindFreeStateResponse::NONE_FOUND, reason));
        assert!(answer.message.contains(word) && answer.free_state.is_empty(), "{answer:?}");
    };
    none(&FindFreeStateRequest { max_distance: 0.1, ..at(&ONTO) }, "beyond_limits", "max_distance");
    none(&FindFreeStateRequest { timeout: 1e-300, ..at(&ONTO) }, "unfinished", "timeout");

    let evaluation = evaluation(&with_ball_in_base(), &STRETCHED);
    let answer = search_free_state(&at(&STRETCHED), Some(&evaluation), &mut None);
    assert_eq!(
        (answer.result, answer.reason_code.as_str()),
        (FindFreeStateResponse::NONE_FOUND, "not_movable")
    );
    assert!(answer.message.contains("'base'") && answer.message.contains("'ball'"), "{}", answer.message);
}

#[test]
fn broken_requests_are_rejected_by_name() {
    type Break = fn(&mut FindFreeStateRequest);
    let broken: [(Break, &str); 14] = [
        (|r| r.positions.truncate(1), "positions has 1 numbers, but joint_names has 2 names"),
        (|r| r.joint_names.clear(), "positions has 2 numbers, but joint_names has 0 names"),
        (|r| r.positions[1] = f64::NAN, "positions: joint 'joint2' has position NaN"),
        (|r| r.joint_names[1] = "wrist".into(), "joint_names: the robot has no joint 'wrist'"),
        (|r| r.joint_names[1] = "joint1".into(), "joint 'joint1' is given twice"),
        (|r| r.group = "leg".into(), "group: the robot has no group 'leg'; its SRDF has 'shoulder'"),
        (|r| r.group = "nothing".into(), "group: group 'nothing' has no joint"),
        (|r| r.locked_joints = names(&["elbow"]), "no joint 'elbow'; it has 'joint1' and 'joint2'"),
        (|r| r.max_distance = -0.1, "max_distance is -0.1 rad or m, but must be finite and not negative"),
        (|r| r.max_distance = f64::NAN, "max_distance is NaN"),
        (|r| r.clearance = -1.0, "clearance is -1 m"),
        (|r| r.clearance = f64::INFINITY, "clearance is inf m"),
        (|r| r.timeout = -1.0, "timeout is -1 s"),
        (|r| r.timeout = f64::NAN, "timeout is NaN"),
    ];
    for (break_it, named) in broken {
        let mut request = at(&ONTO);
        break_it(&mut request);
        let answer = ask(&request);
        assert_eq!((answer.result, answer.reason_code.as_str()), (0, "bad_request"), "{named}");
        assert!(answer.message.contains(named), "'{named}' is not in: {}", answer.message);
        assert!(answer.start.is_empty() && answer.joint_names.is_empty());
    }
}

/// Numbers that are valid, but make no sense, neither panic nor hang.
#[test]
fn extreme_numbers_get_a_result() {
    for (max_distance, clearance) in
        [(f64::MAX, 0.0), (f64::MIN_POSITIVE, 0.0), (0.5, f64::MAX), (f64::MAX, f64::MAX)]
    {
        let is_possible = max_distance == f64::MAX && clearance == 0.0;
        // without a free state, only the timeout ends the search of such distances
        let timeout = if is_possible { 3600.0 } else { 0.2 };
        let answer = ask(&FindFreeStateRequest { max_distance, clearance, timeout, ..at(&ONTO) });
        let expected =
            if is_possible { FindFreeStateResponse::FOUND } else { FindFreeStateResponse::NONE_FOUND };
        assert_eq!(answer.result, expected, "{answer:?}");
    }
}
