//! Tests of motion requests for the two-link robot. Its URDF contains the derivation of the expected results.

use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Duration;

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_monitor::{JointStateInput, Monitor, MonitorSettings, Now, Revision, Time};
use clearance_robot::MeshFiles;
use clearance_scene::Settings;
use clearance_scene::{Obstacle, World};
use ros2_interfaces_jazzy_serde::builtin_interfaces::msg::Duration as SpanMessage;
use ros2_interfaces_jazzy_serde::trajectory_msgs::msg::{JointTrajectory, JointTrajectoryPoint};

use super::*;
use crate::messages::clearance_msgs::DistanceEvent;
use crate::messages::clearance_srvs::MotionDistances;
use crate::services::request_rejection::LONGEST_MESSAGE;

const URDF: &str = include_str!("../../../../../urdf/two_link/two_link.urdf");
const JOINTS: [&str; 2] = ["joint1", "joint2"];
/// Folded as far as it is free of collisions, and by the same angle on the other side of the cube.
const NEAR: [f64; 2] = [0.0, 5.0 * PI / 6.0];
const BEYOND: [f64; 2] = [0.0, 7.0 * PI / 6.0];

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// The monitor's evaluation of the robot at these positions; without positions, no joint state is received.
fn evaluation(positions: &[f64]) -> Evaluation {
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    let mut monitor = Monitor::new(MonitorSettings::default(), || Duration::ZERO);
    monitor.set_checker(Arc::new(Revision::new(checker, 3, 1)));
    let now = Now { ros: Some(Time::from_nanoseconds(5)), steady: Duration::ZERO };
    let names = names(&JOINTS[..positions.len()]);
    if positions.is_empty() {
        return monitor.on_heartbeat(now);
    }
    let positions = positions.to_vec();
    monitor.on_joint_state(JointStateInput { names, positions, ..JointStateInput::default() }, now)
}

fn from_to(start: &[f64], goal: &[f64]) -> CheckMotionRequest {
    let [start, goal] = [start, goal].map(<[f64]>::to_vec);
    CheckMotionRequest { joint_names: names(&JOINTS), start, goal, ..CheckMotionRequest::default() }
}

fn ask_all(request: &CheckMotionRequest) -> CheckTrajectoryResponse {
    evaluate_motion(request, ContinuousDirection::Shortest, Some(&evaluation(&[0.0, 0.0])), &mut None)
        .response
}

fn ask(request: &CheckMotionRequest) -> MotionFindings {
    ask_all(request).motion
}

fn point(positions: [f64; 2], time: f64) -> JointTrajectoryPoint {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "tests take seconds")]
    let time_from_start = SpanMessage { sec: time as i32, nanosec: (time.fract() * 1e9) as u32 };
    JointTrajectoryPoint { positions: positions.to_vec(), time_from_start, ..JointTrajectoryPoint::default() }
}

fn along(points: Vec<JointTrajectoryPoint>) -> CheckTrajectoryRequest {
    let joint_names = names(&JOINTS);
    let trajectory = JointTrajectory { joint_names, points, ..JointTrajectory::default() };
    CheckTrajectoryRequest { trajectory, terms: MotionTerms::default() }
}

fn ask_along(request: &CheckTrajectoryRequest) -> CheckTrajectoryResponse {
    evaluate_trajectory(request, None, Some(&evaluation(&[0.0, 0.0])), &mut None).response
}

#[test]
fn a_free_way_is_free_with_its_certificate() {
    let mut request = from_to(&[0.0, 0.0], &[PI / 2.0, 0.0]);
    let answer = ask(&request);
    assert_eq!((answer.verdict, answer.t_free, answer.t_contact), (MotionFindings::FREE, 1.0, 1.0));
    assert_eq!((answer.message.as_str(), answer.certificate.as_str()), ("", ""));
    assert_eq!((answer.model_revision, answer.world_revision), (3, 1));

    request.terms.certificate = true;
    let evaluated =
        evaluate_motion(&request, ContinuousDirection::Shortest, Some(&evaluation(&[0.0, 0.0])), &mut None);
    let text = evaluated.certificate.unwrap();
    let certificate = Certificate::from_json(&text).unwrap();
    let motion = evaluated.response.motion;
    assert_eq!(motion.certificate_digest, certificate.digest);
    assert_eq!(motion.certificate, text);
    assert_eq!(certificate.segments.len(), 1);
    assert_eq!(certificate.segments[0].motion.to, Some(vec![PI / 2.0, 0.0]));
}

#[test]
fn a_contact_between_free_ends_is_found_where_it_is() {
    let touch = (PI - 0.3_f64.asin() - NEAR[1]) / (BEYOND[1] - NEAR[1]);
    let mut request = from_to(&NEAR, &BEYOND);
    let answer = ask(&request);
    assert_eq!(answer.verdict, MotionFindings::CONTACT);
    assert!(answer.t_free <= touch && touch <= answer.t_contact, "{answer:?}");
    assert!(answer.t_contact - answer.t_free < 1e-3);
    assert!(answer.witness_known);
    assert_eq!((answer.distance_lower, answer.distance_upper), (0.0, 0.0));
    assert_eq!((answer.pair.body_a.as_str(), answer.pair.body_b.as_str()), ("base", "tip"));

    request.terms.any_contact = true;
    let answer = ask(&request);
    assert_eq!((answer.verdict, answer.t_free), (MotionFindings::CONTACT, 0.0));
}

#[test]
fn what_is_not_decided_says_why() {
    let mut request = from_to(&[0.0, 0.0], &NEAR);
    request.terms.joint_tolerances = vec![0.0, 0.5];
    let answer = ask(&request);
    assert_eq!((answer.verdict, answer.reason_code.as_str()), (MotionFindings::UNDECIDED, "tube"));
    assert!(answer.message.contains("base and tip"), "{}", answer.message);
    assert!(0.0 < answer.t_free && answer.t_free <= answer.t_contact);

    let mut request = from_to(&[0.0, 0.0], &[0.0, 2.83]);
    assert_eq!(ask(&request).verdict, MotionFindings::FREE);
    request.terms.timeout = 1e-300;
    let answer = ask(&request);
    assert_eq!((answer.verdict, answer.reason_code.as_str()), (MotionFindings::UNDECIDED, "deadline"));
    request.terms.timeout = f64::MAX;
    assert_eq!(ask(&request).verdict, MotionFindings::FREE);
}

#[test]
fn a_way_may_begin_at_the_current_joint_state_and_leave_joints_out() {
    let request =
        CheckMotionRequest { joint_names: names(&JOINTS[..1]), goal: vec![1.0], ..from_to(&[], &[]) };
    let told = |evaluation: &Evaluation, request: &CheckMotionRequest| {
        evaluate_motion(request, ContinuousDirection::Shortest, Some(evaluation), &mut None).response.motion
    };
    assert_eq!(told(&evaluation(&[0.0, 0.0]), &request).verdict, MotionFindings::FREE);
    // joint 2 stays folded onto the base
    assert_eq!(told(&evaluation(&[0.0, PI]), &request).verdict, MotionFindings::CONTACT);
    for unknown in [&[][..], &[0.0], &[f64::NAN, 0.0]] {
        let answer = told(&evaluation(unknown), &request);
        assert_eq!((answer.verdict, answer.reason_code.as_str()), (0, "no_joint_state"), "{answer:?}");
        assert_eq!(answer.t_free, 0.0);
    }
    let request = CheckMotionRequest { start: vec![0.0], ..request };
    let answer = told(&evaluation(&[]), &request);
    assert_eq!(answer.verdict, MotionFindings::FREE);
    assert!(answer.message.starts_with("'joint2' stand at their defaults"), "{}", answer.message);
}

#[test]
fn without_a_model_nothing_is_checked() {
    let answer = evaluate_motion(&from_to(&NEAR, &BEYOND), ContinuousDirection::Shortest, None, &mut None)
        .response
        .motion;
    assert_eq!((answer.verdict, answer.reason_code.as_str()), (MotionFindings::ERROR, "no_model"));
    assert!(answer.message.contains("robot_description"), "{}", answer.message);
}

#[test]
fn broken_requests_are_rejected_by_name() {
    type Break = fn(&mut CheckMotionRequest);
    let broken: [(Break, &str); 20] = [
        (|r| r.joint_names[1] = "wrist".into(), "joint_names: the robot has no joint 'wrist'"),
        (|r| r.joint_names[1] = "joint1".into(), "joint 'joint1' is given twice"),
        (|r| r.joint_names.clear(), "joint_names is empty"),
        (|r| r.start.truncate(1), "start has 1 numbers, but joint_names has 2 names"),
        (|r| r.goal.clear(), "goal has 0 numbers"),
        (|r| r.start[1] = f64::NAN, "start: joint 'joint2' has position NaN"),
        (|r| r.goal[0] = f64::INFINITY, "goal: joint 'joint1' has position inf"),
        (|r| r.goal[0] = 1e300, "goal: joint 'joint1' has position 1e300"),
        (|r| r.terms.tolerance = -1e-3, "tolerance is -0.001 m"),
        (|r| r.terms.tolerance = f64::NAN, "tolerance is NaN"),
        (|r| r.terms.tolerance = f64::INFINITY, "tolerance is inf"),
        (|r| r.terms.timeout = -1.0, "timeout is -1 s"),
        (|r| r.terms.timeout = f64::NAN, "timeout is NaN"),
        (|r| r.terms.margin = -0.1, "margin is -0.1 m"),
        (|r| r.terms.margin = f64::INFINITY, "margin is inf"),
        (|r| r.terms.event_distance = f64::NAN, "event_distance is NaN"),
        (|r| r.terms.joint_tolerances = vec![0.1], "joint_tolerances has 1 numbers"),
        (|r| r.terms.joint_tolerances = vec![0.1, -0.1], "tolerance of joint 'joint2' is -0.1"),
        (|r| r.terms.joint_tolerances = vec![f64::NAN, 0.0], "tolerance of joint 'joint1' is NaN"),
        (|r| r.joint_names[0] = "x".repeat(1 << 20), "joint_names: the name 'xxx"),
    ];
    for (break_it, named) in broken {
        let mut request = from_to(&NEAR, &BEYOND);
        break_it(&mut request);
        let answer = ask(&request);
        assert_eq!((answer.verdict, answer.reason_code.as_str()), (MotionFindings::ERROR, "bad_request"));
        assert!(answer.message.contains(named), "'{named}' is not in: {}", answer.message);
        assert!(answer.message.len() <= LONGEST_MESSAGE);
        assert_eq!((answer.t_free, answer.distance_upper), (0.0, f64::INFINITY));
    }
}

/// The ball of radius 0.1 m at the end of link 2 comes down onto the cube of half a side 0.2 m: its centre is at
/// height sin(joint 2), and the cube below it.
#[test]
fn distances_along_a_motion_are_those_of_its_geometry() {
    let nothing = ask_all(&from_to(&[0.0, 0.0], &NEAR)).distances;
    assert_eq!(nothing.event.result, DistanceEvent::NOT_CHECKED);
    assert_eq!((nothing.self_clearance.lower, nothing.self_clearance.upper), (0.0, f64::INFINITY));

    let mut request = from_to(&[0.0, 0.0], &NEAR);
    (request.terms.with_clearance, request.terms.event_distance) = (true, 0.25);
    let MotionDistances { self_clearance, world_clearance, clearance_reason_code, event } =
        ask_all(&request).distances;
    let least = NEAR[1].sin() - 0.2 - 0.1;
    assert!(self_clearance.lower <= least && least <= self_clearance.upper + 1e-9, "{self_clearance:?}");
    assert!(self_clearance.upper - self_clearance.lower < 3e-3, "{self_clearance:?}");
    assert_eq!(self_clearance.nearest.distance, self_clearance.upper);
    assert_eq!(self_clearance.nearest.pair.body_a, "base");
    assert!(self_clearance.t > 0.99 && self_clearance.time.is_nan());
    assert_eq!((world_clearance.lower, world_clearance.upper), (f64::INFINITY, f64::INFINITY));
    assert_eq!(clearance_reason_code, "");
    let reached = (PI - 0.55_f64.asin()) / NEAR[1];
    assert_eq!((event.result, event.pair.body_b.as_str()), (DistanceEvent::REACHED, "tip"));
    assert!(event.t_farther <= reached && reached <= event.t_reached, "{event:?} {reached}");

    request.terms.event_distance = 0.1;
    let event = ask_all(&request).distances.event;
    assert_eq!((event.result, event.t_farther, event.t_reached), (DistanceEvent::FARTHER, 1.0, 1.0));
    request.terms.timeout = 1e-300;
    let late = ask_all(&request).distances;
    assert_eq!((late.clearance_reason_code.as_str(), late.self_clearance.lower), ("deadline", 0.0));
    assert_eq!((late.event.result, late.event.reason_code.as_str()), (DistanceEvent::UNDECIDED, "deadline"));
}

#[test]
fn a_margin_is_kept_or_named() {
    let mut request = from_to(&[0.0, 0.0], &NEAR);
    request.terms.margin = 0.19;
    assert_eq!(ask(&request).verdict, MotionFindings::FREE);
    request.terms.margin = 0.25;
    let answer = ask(&request);
    assert_eq!((answer.verdict, answer.distance_upper), (MotionFindings::CONTACT, 0.25));
    let reached = (PI - 0.55_f64.asin()) / NEAR[1];
    assert!(answer.t_free <= reached && reached <= answer.t_contact, "{answer:?} {reached}");
}

#[test]
fn distances_along_a_trajectory_name_the_segment_and_the_time() {
    let mut request = along(vec![point([0.0, 0.0], 0.0), point([1.0, 0.0], 2.0), point(NEAR, 4.0)]);
    (request.terms.with_clearance, request.terms.event_distance) = (true, 0.25);
    let MotionDistances { self_clearance, event, .. } = ask_along(&request).distances;
    assert_eq!((self_clearance.segment, event.segment), (1, 1));
    assert!((self_clearance.time - (2.0 + 2.0 * self_clearance.t)).abs() < 1e-9);
    assert!(event.time_farther <= event.time_reached && event.time_reached < 4.0);
}

#[test]
fn huge_motions_end() {
    for any_contact in [false, true] {
        for certificate in [false, true] {
            let mut request = from_to(&[0.0, 0.0], &[1e8, -1e8]);
            request.terms = MotionTerms { any_contact, certificate, timeout: 0.2, ..MotionTerms::default() };
            assert_ne!(ask(&request).verdict, MotionFindings::FREE);
        }
    }
}

#[test]
fn trajectories_say_which_segment_and_when() {
    let free = along(vec![point([0.0, 0.0], 0.0), point([1.0, 0.0], 1.5), point([1.0, 1.0], 4.0)]);
    let answer = ask_along(&free);
    assert_eq!((answer.motion.verdict, answer.segment), (MotionFindings::FREE, 1));
    assert_eq!((answer.time_free, answer.time_contact), (4.0, 4.0));

    let hits = along(vec![point([0.0, 0.0], 0.0), point(NEAR, 2.0), point(BEYOND, 4.0)]);
    let answer = ask_along(&hits);
    assert_eq!((answer.motion.verdict, answer.segment), (MotionFindings::CONTACT, 1));
    assert!((answer.time_free - (2.0 + 2.0 * answer.motion.t_free)).abs() < 1e-9);
    assert!(answer.time_free <= answer.time_contact && answer.time_contact < 2.5);

    let untimed = along(vec![point(NEAR, 0.0), point(BEYOND, 0.0)]);
    let answer = ask_along(&untimed);
    assert_eq!(answer.motion.verdict, MotionFindings::CONTACT);
    assert!(answer.time_free.is_nan() && answer.time_contact.is_nan());
}

#[test]
fn broken_trajectories_are_rejected_by_name() {
    type Break = fn(&mut JointTrajectory);
    let broken: [(Break, &str); 8] = [
        (|t| t.points.clear(), "at least two points, but it has 0"),
        (|t| t.joint_names.clear(), "trajectory.joint_names is empty"),
        (|t| t.joint_names[0] = "wrist".into(), "'wrist'"),
        (|t| t.points[1].positions.truncate(1), "point 1: 1 positions for 2 joints"),
        (|t| t.points[1].positions[0] = f64::NAN, "point 1: its positions of joint 'joint1'"),
        (|t| t.points[0].velocities = vec![0.0; 3], "point 0: 3 velocities for 2 joints"),
        (|t| t.points[1].time_from_start.sec = -1, "time_from_start -1 s"),
        (|t| t.points[0].time_from_start.sec = 9, "time_from_start 1 s does not come after 9 s"),
    ];
    for (break_it, named) in broken {
        let mut request = along(vec![point(NEAR, 0.0), point(BEYOND, 1.0)]);
        break_it(&mut request.trajectory);
        let answer = ask_along(&request).motion;
        assert_eq!((answer.verdict, answer.reason_code.as_str()), (MotionFindings::ERROR, "bad_request"));
        assert!(answer.message.contains(named), "'{named}' is not in: {}", answer.message);
    }
}

#[test]
fn a_certificate_that_cannot_be_sent_is_left_out_with_a_word() {
    let zigzag = |n: u32| (0..n).map(|i| point([f64::from(i % 2), 0.0], f64::from(i))).collect();
    for (points, sent) in [(100, true), (1_000, false), (20_000, false)] {
        let mut request = along(zigzag(points));
        request.terms.certificate = true;
        let evaluated = evaluate_trajectory(&request, None, Some(&evaluation(&[0.0, 0.0])), &mut None);
        let motion = evaluated.response.motion;
        assert_eq!(motion.verdict, MotionFindings::FREE);
        assert_eq!(evaluated.certificate.is_some(), sent, "{points} points");
        assert_eq!(!motion.certificate_digest.is_empty(), sent);
        assert_eq!(motion.message.contains("clearance motion --certificate"), !sent);
        assert!(evaluated.certificate.unwrap_or_default().len() <= LONGEST_CERTIFICATE);
    }
}

/// Evaluation of a robot with a bar on a continuous joint, at these positions; joint `k` mimics it.
fn at_the_wheel(position: f64, mimic: &str) -> Evaluation {
    let urdf = format!(
        "<robot name='r'><link name='base'/><link name='bar'><collision><origin xyz='0.5 0 0'/><geometry><box size='1 0.05 0.05'/>\
         </geometry></collision></link><joint name='j' type='continuous'><parent link='base'/><child link='bar'/><axis xyz='0 0 1'/></joint>\
         <link name='flag'/><joint name='k' type='continuous'><parent link='base'/><child link='flag'/><axis xyz='0 0 1'/>{mimic}</joint></robot>"
    );
    let robot = RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap();
    let mut world = World::default();
    let ball = Shape::Primitive(Primitive::Sphere { radius: 0.02 });
    world.add(Obstacle::of_shape("ball", Pose::translation(-0.8, 0.0, 0.0), ball)).unwrap();
    let names = robot.position_names().to_vec();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    let mut monitor = Monitor::new(MonitorSettings::default(), || Duration::ZERO);
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 1)));
    let now = Now { ros: Some(Time::from_nanoseconds(5)), steady: Duration::ZERO };
    let positions = vec![position; names.len()];
    monitor.on_joint_state(JointStateInput { names, positions, ..JointStateInput::default() }, now)
}

#[test]
fn continuous_joints_go_the_shortest_way_from_the_current_state() {
    use ContinuousDirection::{AsGiven, Shortest};
    let (free, contact) = (MotionFindings::FREE, MotionFindings::CONTACT);
    let evaluation = at_the_wheel(3.0, "");
    for (start, default_direction, requested_direction, verdict) in [
        (&[][..], Shortest, MotionTerms::DEFAULT, contact),
        (&[], AsGiven, MotionTerms::DEFAULT, free),
        (&[], Shortest, MotionTerms::AS_GIVEN, free),
        (&[], AsGiven, MotionTerms::SHORTEST, contact),
        (&[3.0], Shortest, MotionTerms::DEFAULT, free),
        (&[3.0], AsGiven, MotionTerms::SHORTEST, contact),
    ] {
        let terms = MotionTerms { continuous_joint_direction: requested_direction, ..MotionTerms::default() };
        let (joint_names, start, goal) = (names(&["j"]), start.to_vec(), vec![-3.0]);
        let request = CheckMotionRequest { joint_names, start, goal, terms, duration: 0.0 };
        let CheckTrajectoryResponse { motion, turns, .. } =
            evaluate_motion(&request, default_direction, Some(&evaluation), &mut None).response;
        assert_eq!(motion.verdict, verdict, "{request:?}");
        assert_eq!((turns.continuous_joints, turns.continuous_goals), (names(&["j"]), vec![-3.0]));
        let long = verdict == free;
        assert!((turns.continuous_starts[0] - if long { 3.0 } else { 3.0 - 2.0 * PI }).abs() < 1e-9);
        assert_eq!(motion.message.contains("'j' turns by more than half a turn"), long, "{}", motion.message);
    }
}

#[test]
fn trajectories_go_the_shortest_way_only_on_request() {
    let evaluation = at_the_wheel(0.0, "");
    let point = |position: f64, sec| JointTrajectoryPoint {
        positions: vec![position],
        time_from_start: SpanMessage { sec, nanosec: 0 },
        ..JointTrajectoryPoint::default()
    };
    let points = vec![point(2.0, 0), point(3.0, 1), point(-3.0, 2)];
    let trajectory = JointTrajectory { joint_names: names(&["j"]), points, ..JointTrajectory::default() };
    let mut request = CheckTrajectoryRequest { trajectory, terms: MotionTerms::default() };
    let mut answer = |direction: u8| {
        request.terms.continuous_joint_direction = direction;
        evaluate_trajectory(&request, None, Some(&evaluation), &mut None).response
    };
    let given = answer(MotionTerms::DEFAULT);
    assert_eq!(given.motion.verdict, MotionFindings::FREE);
    assert!(given.motion.message.starts_with("segment 1: continuous joint 'j'"), "{}", given.motion.message);
    assert_eq!(answer(MotionTerms::AS_GIVEN).motion.verdict, MotionFindings::FREE);
    let short = answer(MotionTerms::SHORTEST);
    assert_eq!((short.motion.verdict, short.segment), (MotionFindings::CONTACT, 1));
    assert!((short.turns.continuous_starts[0] - (2.0 - 2.0 * PI)).abs() < 1e-9);
    let broken = answer(7);
    assert_eq!((broken.motion.verdict, broken.motion.reason_code.as_str()), (0, "bad_request"));
    assert!(broken.motion.message.contains("continuous_joint_direction is 7"), "{}", broken.motion.message);
}

/// A full turn of the leader joint would move the mimic joint to another position.
#[test]
fn a_mimic_joint_may_keep_its_leader_from_the_shortest_way() {
    let evaluation = at_the_wheel(3.0, "<mimic joint='j' multiplier='0.5'/>");
    let mut request = from_to(&[], &[-3.0]);
    request.joint_names = names(&["j"]);
    let answer = |request: &CheckMotionRequest| {
        evaluate_motion(request, ContinuousDirection::Shortest, Some(&evaluation), &mut None).response.motion
    };
    let by_default = answer(&request);
    assert_eq!(by_default.verdict, MotionFindings::FREE);
    assert!(
        ["'j'", "'k' mimics it", "checked as given"].iter().all(|w| by_default.message.contains(w)),
        "{by_default:?}"
    );
    request.terms.continuous_joint_direction = MotionTerms::SHORTEST;
    let on_request = answer(&request);
    assert_eq!((on_request.verdict, on_request.reason_code.as_str()), (MotionFindings::ERROR, "bad_request"));
    assert!(
        on_request.message.contains("'j'") && on_request.message.contains("'k'"),
        "{}",
        on_request.message
    );
}
