//! Tests of state requests for the two-link robot. Its URDF contains the derivation of the expected results.

use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Duration;

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_monitor::{JointStateInput, Monitor, MonitorSettings, Now, Reason, Revision, Time};
use clearance_robot::{MeshFiles, RobotModel};
use clearance_scene::Settings;
use clearance_scene::{Obstacle, World};

use super::*;
use crate::messages::clearance_msgs::BodyPair;
use crate::services::body_list::LONGEST_NAMES;
use crate::services::request_rejection::LONGEST_MESSAGE;

const URDF: &str = include_str!("../../../../../urdf/two_link/two_link.urdf");
const JOINTS: [&str; 2] = ["joint1", "joint2"];
/// Folded as far as it is free of collisions (distance 0.2 m), and folded onto the base.
const NEAR: [f64; 2] = [0.0, 5.0 * PI / 6.0];
const ONTO: [f64; 2] = [0.0, PI];
const FREE: u8 = CheckStatesResponse::FREE;
const COLLIDING: u8 = CheckStatesResponse::COLLIDING;
const UNKNOWN: u8 = CheckStatesResponse::UNKNOWN;

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// A sphere 0.5 m in front of the tip's sphere, with both joints at zero.
fn with_ball() -> World {
    let mut world = World::default();
    let ball = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
    world.add(Obstacle::of_shape("ball", Pose::translation(2.7, 0.0, 0.0), ball)).unwrap();
    world
}

fn monitor(world: &World, settings: MonitorSettings) -> Monitor {
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), world, Settings::default()).unwrap();
    let mut monitor = Monitor::new(settings, || Duration::ZERO);
    monitor.set_checker(Arc::new(Revision::new(checker, 3, 1)));
    monitor
}

/// The monitor's evaluation of the robot at these positions; without positions, no joint state is received.
fn evaluate(monitor: &mut Monitor, positions: &[f64]) -> Evaluation {
    let now = Now { ros: Some(Time::from_nanoseconds(5)), steady: Duration::ZERO };
    let names = names(&JOINTS[..positions.len()]);
    if positions.is_empty() {
        return monitor.on_heartbeat(now);
    }
    let positions = positions.to_vec();
    monitor.on_joint_state(JointStateInput { names, positions, ..JointStateInput::default() }, now)
}

fn evaluation(world: &World, positions: &[f64]) -> Evaluation {
    evaluate(&mut monitor(world, MonitorSettings::default()), positions)
}

fn batch(states: &[[f64; 2]]) -> CheckStatesRequest {
    let positions = states.as_flattened().to_vec();
    CheckStatesRequest { joint_names: names(&JOINTS), positions, ..CheckStatesRequest::default() }
}

fn ask(request: &CheckStatesRequest) -> CheckStatesResponse {
    evaluate_states(request, Some(&evaluation(&World::default(), &[0.0, 0.0])), &mut None)
}

fn at(positions: &[f64]) -> GetDistancesRequest {
    let joint_names = names(&JOINTS[..positions.len()]);
    GetDistancesRequest { joint_names, positions: positions.to_vec(), ..GetDistancesRequest::default() }
}

fn ask_distances(request: &GetDistancesRequest) -> GetDistancesResponse {
    evaluate_distances(request, Some(&evaluation(&with_ball(), &[0.0, 0.0])), &mut None)
}

fn reported_pair(response: &GetDistancesResponse, i: usize) -> [&str; 2] {
    let BodyPair { body_a, body_b, .. } = &response.pairs[i].pair;
    let mut pair = [body_a.as_str(), body_b.as_str()];
    pair.sort_unstable();
    pair
}

#[test]
fn every_state_gets_its_answer() {
    let mut request = batch(&[[0.0, 0.0], ONTO, NEAR]);
    let answer = ask(&request);
    assert_eq!(answer.verdicts, [FREE, COLLIDING, FREE]);
    assert_eq!((answer.verdict, answer.message.as_str(), answer.reason_code.as_str()), (COLLIDING, "", ""));
    assert!(answer.distances.is_empty());
    assert_eq!((answer.pair_a[0], answer.pair_b[0]), (NOBODY, NOBODY));
    let pair =
        [answer.pair_a[1], answer.pair_b[1]].map(|i| answer.bodies[usize::try_from(i).unwrap()].as_str());
    assert_eq!(pair, ["base", "tip"]);
    assert_eq!(answer.body_types, [BodyPair::LINK; 2]);
    assert_eq!((answer.model_revision, answer.world_revision), (3, 1));

    request.with_distance = true;
    let answer = ask(&request);
    assert_eq!(answer.verdicts, [FREE, COLLIDING, FREE]);
    for (distance, expected) in answer.distances.iter().zip([0.7, 0.0, 0.2]) {
        assert!((distance - expected).abs() < 1e-9, "{answer:?}");
    }
    assert_eq!((answer.pair_a.as_slice(), answer.pair_b.as_slice()), (&[0; 3][..], &[1; 3][..]));
    assert_eq!(answer.bodies, ["base", "tip"]);

    request.distance_limit = 0.3;
    let answer = ask(&request);
    assert_eq!((answer.distances[0], answer.pair_a[0]), (f64::INFINITY, NOBODY));
    assert_eq!(answer.verdicts, [FREE, COLLIDING, FREE]);
    assert_eq!(ask(&batch(&[NEAR])).verdict, FREE);
}

#[test]
fn while_another_robot_is_built_nothing_is_checked() {
    let mut monitor = monitor(&World::default(), MonitorSettings::default());
    evaluate(&mut monitor, &[0.0, 0.0]);
    monitor.note_model_swap();
    let evaluation = evaluate(&mut monitor, &[]);
    let answer = evaluate_states(&batch(&[NEAR]), Some(&evaluation), &mut None);
    assert_eq!((answer.verdict, answer.reason_code.as_str()), (CheckStatesResponse::ERROR, "no_model"));
    assert!(answer.message.contains("still being built"), "{}", answer.message);
}

#[test]
fn where_only_the_check_was_late_the_robot_stands_where_it_is() {
    let settings = MonitorSettings { check_deadline: 1e-9, ..MonitorSettings::default() };
    let evaluation = evaluate(&mut monitor(&World::default(), settings), &[0.0, PI]);
    assert_eq!(evaluation.status.reason().map(Reason::code), Some("deadline"));
    let request = CheckStatesRequest {
        joint_names: names(&["joint1"]),
        positions: vec![0.5],
        ..CheckStatesRequest::default()
    };
    let answer = evaluate_states(&request, Some(&evaluation), &mut None);
    assert_eq!((answer.verdict, answer.message.as_str()), (COLLIDING, ""));
}

#[test]
fn names_that_do_not_fit_are_left_out() {
    const LENGTH: usize = 1000;
    // one sphere in front of the tip for each state
    let states: Vec<[f64; 2]> = (0..12).map(|k| [0.4 * f64::from(k) - 2.4, 0.0]).collect();
    let mut world = World::default();
    for (k, [angle, _]) in states.iter().enumerate() {
        let ball = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
        let place = Pose::translation(2.3 * angle.cos(), 2.3 * angle.sin(), 0.0);
        world.add(Obstacle::of_shape(format!("{k:0LENGTH$}"), place, ball)).unwrap();
    }
    let mut request = batch(&states);
    request.with_distance = true;
    let answer = evaluate_states(&request, Some(&evaluation(&world, &[0.0, 0.0])), &mut None);
    assert!(answer.distances.iter().all(|distance| (distance - 0.1).abs() < 1e-9), "{answer:?}");
    let fitting = (LONGEST_NAMES - "tip".len()) / LENGTH;
    assert_eq!(answer.bodies.len(), 1 + fitting + 1);
    // the nearest self pair comes last: it takes no room from the others
    assert_eq!(answer.bodies.last().unwrap(), "base");
    let told = |i: usize| ![answer.pair_a[i], answer.pair_b[i]].contains(&NOBODY);
    assert!((0..states.len()).all(|i| told(i) == (i < fitting)), "{answer:?}");
}

#[test]
fn what_is_not_decided_in_time_is_unknown() {
    for with_distance in [false, true] {
        let request = CheckStatesRequest { timeout: 1e-300, with_distance, ..batch(&[NEAR, ONTO]) };
        let answer = ask(&request);
        assert_eq!((answer.verdict, answer.verdicts.as_slice()), (UNKNOWN, &[UNKNOWN; 2][..]));
        assert_eq!(answer.reason_code, "deadline");
        assert!(answer.message.contains("2 of 2 states"), "{}", answer.message);
        assert!(answer.distances.iter().all(|distance| distance.is_nan()));
    }
    let answer = ask_distances(&GetDistancesRequest { timeout: 1e-300, ..at(&[0.0, 0.0]) });
    assert_eq!((answer.verdict, answer.reason_code.as_str()), (UNKNOWN, "deadline"));
    let request = CheckStatesRequest { timeout: f64::MAX, ..batch(&[NEAR, ONTO]) };
    assert_eq!(ask(&request).verdicts, [FREE, COLLIDING]);
}

#[test]
fn a_batch_with_something_open_is_not_free() {
    let evaluation = evaluation(&World::default(), &[0.0, 0.0]);
    let checker = &evaluation.revision.as_ref().unwrap().checker;
    let free = CollisionReport::default();
    let hit = CollisionReport {
        self_collision: true,
        colliding_pairs: vec![checker.pairs().self_pairs()[0]],
        ..CollisionReport::default()
    };
    for (reports, expected) in [
        (vec![Some(&free)], FREE),
        (vec![Some(&free), None], UNKNOWN),
        (vec![None, Some(&free)], UNKNOWN),
        (vec![None, Some(&hit), Some(&free)], COLLIDING),
        (vec![Some(&hit), None], COLLIDING),
    ] {
        let mut batch = BatchResponse::new(checker, false);
        let open = reports.contains(&None);
        for report in reports {
            batch.add(report);
        }
        let response = batch.response([None, None]);
        assert_eq!((response.verdict, response.reason_code == "deadline"), (expected, open));
    }
}

#[test]
fn joints_that_are_not_named_stand_where_they_are() {
    let request =
        CheckStatesRequest { joint_names: names(&JOINTS[..1]), positions: vec![0.0, 1.0], ..batch(&[]) };
    let empty = World::default();
    let verdicts = |now: &[f64]| evaluate_states(&request, Some(&evaluation(&empty, now)), &mut None);
    assert_eq!(verdicts(&[0.0, 0.0]).verdicts, [FREE; 2]);
    assert_eq!(verdicts(&ONTO).verdicts, [COLLIDING; 2]);
    let answer = verdicts(&[]);
    assert_eq!(answer.verdicts, [FREE; 2]);
    assert!(answer.message.starts_with("'joint2' stand at their defaults"), "{}", answer.message);

    let current = |now: &[f64]| evaluate_distances(&at(&[]), Some(&evaluation(&empty, now)), &mut None);
    assert_eq!((current(&NEAR).verdict, current(&ONTO).verdict), (FREE, COLLIDING));
    let answer = current(&[]);
    assert_eq!((answer.verdict, answer.reason_code.as_str()), (0, "no_joint_state"));
}

#[test]
fn pairs_come_nearest_first() {
    let answer = ask_distances(&at(&[0.0, 0.0]));
    assert_eq!((answer.verdict, answer.message.as_str()), (FREE, ""));
    assert_eq!(reported_pair(&answer, 0), ["ball", "tip"]);
    assert!((answer.pairs[0].distance - 0.5).abs() < 1e-9, "{answer:?}");
    assert!((answer.pairs[1].distance - 0.7).abs() < 1e-9, "{answer:?}");
    assert!(answer.pairs.is_sorted_by(|a, b| a.distance <= b.distance));
    assert_eq!(answer.pairs_found as usize, answer.pairs.len());
    let all = answer.pairs.len();

    let near = ask_distances(&GetDistancesRequest { max_distance: 0.6, ..at(&[0.0, 0.0]) });
    assert_eq!((near.pairs.len(), reported_pair(&near, 0)), (1, ["ball", "tip"]));
    let one = ask_distances(&GetDistancesRequest { max_pairs: 1, ..at(&[0.0, 0.0]) });
    assert_eq!((one.pairs.len(), one.pairs_found as usize), (1, all));
    let of_base = ask_distances(&GetDistancesRequest { bodies: names(&["base"]), ..at(&[0.0, 0.0]) });
    assert!((0..of_base.pairs.len()).all(|i| reported_pair(&of_base, i).contains(&"base")));
    assert!(!of_base.pairs.is_empty() && of_base.pairs.len() < all);

    // the status always covers the whole robot, also if only some bodies are reported
    let request = GetDistancesRequest { bodies: names(&["ball"]), max_distance: 0.1, ..at(&ONTO) };
    let answer = ask_distances(&request);
    assert_eq!((answer.verdict, answer.pairs.len()), (COLLIDING, 0));
    assert_eq!(ask_distances(&at(&ONTO)).pairs[0].distance, 0.0);
}

/// Names of a pair in a response to a batch; none if there is no pair.
fn named(answer: &CheckStatesResponse, [a, b]: [i32; 2]) -> Vec<&str> {
    let indices = [a, b].map(usize::try_from);
    indices.into_iter().flatten().map(|index| answer.bodies[index].as_str()).collect()
}

#[test]
fn both_kinds_of_pairs_have_their_least_distance() {
    let evaluation = evaluation(&with_ball(), &[0.0, 0.0]);
    let ask = |request: CheckStatesRequest| evaluate_states(&request, Some(&evaluation), &mut None);
    let all = CheckStatesRequest { with_distance: true, ..batch(&[[0.0, 0.0], ONTO, NEAR]) };
    let answer = ask(all.clone());
    let are_near = |found: &[f64], expected: [f64; 3]| {
        found.len() == 3 && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9)
    };
    assert!(are_near(&answer.self_distances, [0.7, 0.0, 0.2]), "{answer:?}");
    // folded, the elbow of radius 0.1 is at (1, 0, 0)
    assert!(are_near(&answer.world_distances, [0.5, 1.5, 1.5]), "{answer:?}");
    for state in 0..3 {
        let of_self = [answer.self_pair_a[state], answer.self_pair_b[state]];
        let of_world = [answer.world_pair_a[state], answer.world_pair_b[state]];
        assert_eq!(named(&answer, of_self), ["base", "tip"]);
        assert_eq!(named(&answer, of_world), ["tip", "ball"]);
    }
    let plain = ask(CheckStatesRequest { with_distance: false, ..all.clone() });
    let counts = [plain.self_pair_a.len(), plain.world_pair_b.len(), plain.self_distances.len()];
    assert_eq!(counts, [0; 3]);

    let limited = ask(CheckStatesRequest { distance_limit: 1.0, ..all.clone() });
    assert!(limited.world_distances[1..].iter().all(|distance| *distance == f64::INFINITY));
    assert_eq!((limited.world_pair_a[1], limited.world_pair_b[1]), (NOBODY, NOBODY));
    assert_eq!(limited.self_distances, answer.self_distances);
    let late = ask(CheckStatesRequest { timeout: 1e-300, ..all });
    assert!(late.self_distances.iter().chain(&late.world_distances).all(|distance| distance.is_nan()));
    assert!(late.self_pair_a.iter().chain(&late.world_pair_a).all(|index| *index == NOBODY));
}

#[test]
fn the_nearest_of_each_kind_is_reported_listed_or_not() {
    let all = ask_distances(&at(&[0.0, 0.0]));
    let one = ask_distances(&GetDistancesRequest { max_pairs: 1, ..at(&[0.0, 0.0]) });
    for answer in [&all, &one] {
        assert_eq!(
            (answer.self_distance, answer.world_distance),
            (all.pairs[1].distance, all.pairs[0].distance)
        );
        assert_eq!((&answer.self_nearest, &answer.world_nearest), (&all.pairs[1], &all.pairs[0]));
    }
    let near = ask_distances(&GetDistancesRequest { max_distance: 0.6, ..at(&[0.0, 0.0]) });
    assert_eq!((near.self_distance, near.self_nearest), (f64::INFINITY, PairDistanceMessage::default()));
    let of_ball = ask_distances(&GetDistancesRequest { bodies: names(&["ball"]), ..at(&ONTO) });
    assert_eq!(of_ball.self_distance, f64::INFINITY, "of the requested pairs");
    assert!((of_ball.world_distance - 1.5).abs() < 1e-9, "{of_ball:?}");
    let late = ask_distances(&GetDistancesRequest { timeout: 1e-300, ..at(&[0.0, 0.0]) });
    assert!(late.self_distance.is_nan() && late.world_distance.is_nan());
    assert_eq!(ask_distances(&at(&ONTO)).self_distance, 0.0);
}

#[test]
fn without_a_model_nothing_is_checked() {
    let answer = evaluate_states(&batch(&[NEAR]), None, &mut None);
    assert_eq!((answer.verdict, answer.reason_code.as_str()), (CheckStatesResponse::ERROR, "no_model"));
    let answer = evaluate_distances(&at(&NEAR), None, &mut None);
    assert_eq!((answer.verdict, answer.reason_code.as_str()), (CheckStatesResponse::ERROR, "no_model"));
    assert!(answer.message.contains("robot_description"), "{}", answer.message);
    assert!(answer.self_distance.is_nan() && answer.world_distance.is_nan());
}

#[test]
fn broken_requests_are_rejected_by_name() {
    type Break = fn(&mut CheckStatesRequest);
    let broken: [(Break, &str); 11] = [
        (|r| r.joint_names.clear(), "joint_names is empty"),
        (|r| r.positions.clear(), "positions has 0 numbers"),
        (|r| r.positions.truncate(3), "positions has 3 numbers"),
        (|r| r.positions[3] = f64::NAN, "state 1: joint 'joint2' has position NaN"),
        (|r| r.positions[0] = 1e300, "state 0: joint 'joint1' has position 1e300"),
        (|r| r.joint_names[1] = "wrist".into(), "joint_names: the robot has no joint 'wrist'"),
        (|r| r.joint_names[1] = "joint1".into(), "joint 'joint1' is given twice"),
        (|r| r.joint_names[0] = "x".repeat(1 << 20), "the name 'xxx"),
        (|r| r.positions = vec![0.0; 2 * STATES + 2], "positions has 10001 states, but at most 10000"),
        (|r| r.timeout = f64::NAN, "timeout is NaN"),
        (|r| r.distance_limit = -1.0, "distance_limit is -1 m"),
    ];
    for (break_it, named) in broken {
        let mut request = batch(&[NEAR, ONTO]);
        break_it(&mut request);
        let answer = ask(&request);
        assert_eq!((answer.verdict, answer.reason_code.as_str()), (0, "bad_request"), "{named}");
        assert!(answer.message.contains(named), "'{named}' is not in: {}", answer.message);
        assert!(answer.message.len() <= LONGEST_MESSAGE && answer.verdicts.is_empty());
    }
}

#[test]
fn broken_questions_for_distances_are_rejected_by_name() {
    type Break = fn(&mut GetDistancesRequest);
    let broken: [(Break, &str); 5] = [
        (|r| r.positions.truncate(1), "positions has 1 numbers, but joint_names has 2 names"),
        (|r| r.positions[1] = f64::INFINITY, "positions: joint 'joint2' has position inf"),
        (|r| r.bodies = names(&["base", "table"]), "no link, obstacle or attached object 'table'"),
        (|r| r.max_distance = f64::NAN, "max_distance is NaN"),
        (|r| r.timeout = -1.0, "timeout is -1 s"),
    ];
    for (break_it, named) in broken {
        let mut request = at(&NEAR);
        break_it(&mut request);
        let answer = ask_distances(&request);
        assert_eq!((answer.verdict, answer.reason_code.as_str()), (0, "bad_request"), "{named}");
        assert!(answer.message.contains(named), "'{named}' is not in: {}", answer.message);
    }
}

/// The robot has nothing that could collide: this proves nothing.
#[test]
fn a_robot_without_geometry_is_not_checked() {
    let urdf = r#"<robot name="bare"><link name="base"/></robot>"#;
    let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    let mut monitor = Monitor::new(MonitorSettings::default(), || Duration::ZERO);
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 0)));
    for enabled in [true, false] {
        monitor.set_enabled(enabled);
        let evaluation = monitor.on_heartbeat(Now { ros: None, steady: Duration::ZERO });
        let answer = evaluate_states(&batch(&[NEAR]), Some(&evaluation), &mut None);
        assert_eq!(answer.reason_code, "no_model");
        assert!(answer.message.contains("no link of the robot has collision geometry"), "{}", answer.message);
    }
}

fn with_gradients(positions: &[f64]) -> GetDistancesRequest {
    GetDistancesRequest { with_gradients: true, ..at(positions) }
}

#[test]
fn without_the_request_there_are_no_gradients() {
    let answer = ask_distances(&at(&NEAR));
    assert!(answer.signed_distances.is_empty() && answer.normals.is_empty() && answer.gradient.is_empty());
    assert!(answer.signed_distances_upper.is_empty() && answer.witness_counts.is_empty());
    assert!(answer.gradient_joints.is_empty());
}

/// Apart, the signed distances are the distances, bit by bit, and the rows their derivatives: the answers themselves, differentiated.
#[test]
fn gradients_are_those_of_the_distances() {
    const STEP: f64 = 1e-6;
    let at_angles = [0.3, 1.9];
    let answer = ask_distances(&with_gradients(&at_angles));
    assert_eq!((answer.message.as_str(), answer.gradient_joints.as_slice()), ("", &names(&JOINTS)[..]));
    let count = answer.pairs.len();
    assert!(count >= 3, "{answer:?}");
    let told: Vec<f64> = answer.pairs.iter().map(|pair| pair.distance).collect();
    assert_eq!((&answer.signed_distances, &answer.signed_distances_upper), (&told, &told));
    assert_eq!((answer.witness_counts.len(), answer.gradient.len()), (count, 2 * count));
    for joint in 0..2 {
        let [before, after] = [-STEP, STEP].map(|step| {
            let mut positions = at_angles;
            positions[joint] += step;
            ask_distances(&at(&positions)).pairs
        });
        for (row, pair) in answer.pairs.iter().enumerate().filter(|(row, _)| answer.witness_counts[*row] == 1)
        {
            let distance = |pairs: &[PairDistanceMessage]| {
                pairs.iter().find(|other| other.pair == pair.pair).unwrap().distance
            };
            let difference = (distance(&after) - distance(&before)) / (2.0 * STEP);
            let entry = answer.gradient[2 * row + joint];
            assert!((entry - difference).abs() < 1e-6, "{:?} {joint}: {entry}, not {difference}", pair.pair);
        }
    }
    for (pair, normal) in answer.pairs.iter().zip(&answer.normals) {
        let [p, q] = &pair.witness_points;
        let along = (q.x - p.x) * normal.x + (q.y - p.y) * normal.y + (q.z - p.z) * normal.z;
        assert!((along - pair.distance).abs() < 1e-9, "{pair:?}: {normal:?} points to the second body");
    }
}

#[test]
fn gradients_follow_the_listed_pairs() {
    let all = ask_distances(&with_gradients(&[0.3, 1.9]));
    let one = ask_distances(&GetDistancesRequest { max_pairs: 1, ..with_gradients(&[0.3, 1.9]) });
    assert_eq!((one.pairs.len(), &one.gradient[..]), (1, &all.gradient[..2]));
    let of_ball =
        ask_distances(&GetDistancesRequest { bodies: names(&["ball"]), ..with_gradients(&[0.3, 1.9]) });
    assert!(of_ball.pairs.len() >= 2 && of_ball.pairs.len() < all.pairs.len());
    for (row, pair) in of_ball.pairs.iter().enumerate() {
        let same = all.pairs.iter().position(|other| other == pair).unwrap();
        assert_eq!(of_ball.gradient[2 * row..2 * row + 2], all.gradient[2 * same..2 * same + 2]);
    }
}

/// Folded onto the base: the middle of the tip's ball, of radius 0.1 m, is that of the base's cube, of side 0.4 m.
#[test]
fn bodies_that_overlap_have_minus_their_depth() {
    let answer = ask_distances(&with_gradients(&ONTO));
    assert_eq!((answer.verdict, answer.pairs[0].distance), (COLLIDING, 0.0));
    assert_eq!(reported_pair(&answer, 0), ["base", "tip"]);
    assert!(answer.signed_distances[0] <= answer.signed_distances_upper[0]);
    assert!((answer.signed_distances[0] + 0.3).abs() < 1e-6, "{answer:?}");
    let normal = &answer.normals[0];
    assert!((normal.x.hypot(normal.y).hypot(normal.z) - 1.0).abs() < 1e-9, "{normal:?}");
}

#[test]
fn what_the_timeout_leaves_out_is_no_number() {
    let evaluation = evaluation(&with_ball(), &[0.0, 0.0]);
    let checker = &evaluation.revision.as_ref().unwrap().checker;
    let mut workspace = checker.workspace();
    let q = checker.robot().configuration(&[0.3, 1.9]).unwrap();
    let pairs: Vec<_> =
        checker.clearance(&q, f64::INFINITY, &mut workspace).pairs.iter().map(|p| (p.a, p.b)).collect();
    let late = checker.clearance_of_pairs(&q, &pairs, Some(Instant::now()), &mut workspace);
    assert_eq!(late.pairs, []);
    let first = checker.clearance_of_pairs(&q, &pairs[..1], None, &mut workspace);

    let mut response = GetDistancesResponse { message: "a note".to_owned(), ..Default::default() };
    add_gradients(&mut response, checker.robot(), &pairs, &first);
    let open = pairs.len() - 1;
    assert_eq!(
        response.message,
        format!("a note; the timeout left the gradients of {open} of {} pairs open", pairs.len())
    );
    assert_eq!((response.reason_code.as_str(), response.gradient.len()), ("deadline", 2 * pairs.len()));
    assert_eq!(response.signed_distances[0], first.pairs[0].distance);
    assert!(response.signed_distances[1..].iter().all(|distance| distance.is_nan()));
    assert!(response.gradient[..2].iter().all(|entry| entry.is_finite()));
    assert!(response.gradient[2..].iter().all(|entry| entry.is_nan()));
    assert!(response.witness_counts[1..].iter().all(|count| *count == GetDistancesResponse::MANY_UNKNOWN));
}
