//! Tests of the least distances of the robot from itself and from the world.

use clearance_checker::PairKind;
use clearance_geometry::math::{Extremes, Pose};
use clearance_geometry::{Primitive, Shape};
use clearance_scene::Obstacle;

use super::*;

const KINDS: [PairKind; 2] = PairKind::ALL;

/// The robot with balls of radius 0.1 m; at zero, the ball of the robot is at (2, 0, 0), 1.7 m from its base.
fn among(balls: &[[f64; 3]]) -> Monitor {
    let mut world = World::default();
    for (number, [x, y, z]) in balls.iter().enumerate() {
        let ball = Shape::Primitive(Primitive::Sphere { radius: 0.1 });
        world.add(Obstacle::of_shape(format!("ball{number}"), Pose::translation(*x, *y, *z), ball)).unwrap();
    }
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    let mut monitor = monitor();
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 1)));
    monitor
}

fn distances(evaluation: &Evaluation) -> [f64; 2] {
    KINDS.map(|kind| evaluation.distance_of(kind))
}

fn are_near(found: [f64; 2], expected: [f64; 2]) -> bool {
    found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9)
}

#[test]
fn both_are_reported_whichever_is_nearer() {
    let mut monitor = among(&[[2.0, 3.0, 0.0]]);
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert!(are_near(distances(&evaluation), [1.7, 2.8]), "{:?}", distances(&evaluation));
    let nearest = evaluation.nearest_of(PairKind::WorldPair).unwrap();
    assert_eq!(evaluation.revision.as_ref().unwrap().checker.body_name(nearest.b), "ball0");
    assert_eq!(evaluation.least_distance(PairKind::WorldPair).unwrap(), "2.8000 m, ball and ball0");

    let mut monitor = among(&[[2.0, 3.0, 0.0], [2.0, 0.25, 0.0]]);
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert!(are_near(distances(&evaluation), [1.7, 0.05]));
    assert_eq!(evaluation.distance(), evaluation.distance_of(PairKind::WorldPair));
}

#[test]
fn a_contact_leaves_the_other_distance() {
    let mut monitor = among(&[[2.0, 3.0, 0.0]]);
    let evaluation = monitor.on_joint_state(state(0.0, COLLIDING), at(0.0));
    assert_eq!(evaluation.distance_of(PairKind::SelfPair), 0.0);
    // from the corner (0.2, 0.2) of the base
    let of_world = evaluation.distance_of(PairKind::WorldPair);
    assert!((of_world - (1.8_f64.hypot(2.8) - 0.1)).abs() < 1e-9, "{of_world}");

    let mut monitor = among(&[[2.0, 0.15, 0.0]]);
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert!(are_near(distances(&evaluation), [1.7, 0.0]));
    assert_eq!(evaluation.status, Status::Colliding);
}

#[test]
fn what_is_not_there_is_infinitely_far_and_what_is_unknown_is_no_number() {
    let mut monitor = among(&[]);
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(evaluation.distance_of(PairKind::WorldPair), f64::INFINITY);
    let mut monitor = among(&[[2.0, 3.0, 0.0]]);
    monitor.set_settings(MonitorSettings { distance_limit: 1.0, ..MonitorSettings::default() });
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!(distances(&evaluation), [f64::INFINITY; 2]);
    let evaluation = monitor.on_joint_state(state(0.1, [f64::NAN, 0.0]), at(0.1));
    assert!(distances(&evaluation).iter().all(|distance| distance.is_nan()));
}

/// A recorded run in which the deadline came after all near pairs were decided.
#[test]
fn where_the_deadline_left_the_farther_distance_open_the_state_is_free() {
    let mut monitor = among(&[[2.0, 0.25, 0.0]]);
    monitor.leave_out(LeftOut::FartherDistance);
    let evaluation = monitor.on_joint_state(state(0.0, FREE), at(0.0));
    assert_eq!((&evaluation.status, evaluation.left_out), (&Status::Free, LeftOut::FartherDistance));
    assert!(evaluation.distance_of(PairKind::SelfPair).is_nan());
    assert!(evaluation.nearest_of(PairKind::SelfPair).is_none());
    assert!((evaluation.distance() - 0.05).abs() < 1e-9);
    assert_eq!(evaluation.distance(), evaluation.distance_of(PairKind::WorldPair));
    assert!(!evaluation.checked_state.unwrap().is_exact);
}

/// Whether distances are exact, or bounds within a tolerance or a budget.
#[test]
fn the_least_distance_is_the_lesser_of_both() {
    let exact =
        MonitorSettings { distance_limit: 5.0, exact_distance_share: 0.0, ..MonitorSettings::default() };
    let tolerant = MonitorSettings { distance_relative_tolerance: 0.2, ..exact.clone() };
    let budget = MonitorSettings { exact_distance_share: 1e-6, ..exact.clone() };
    let [mut rough, mut compared] = [0, 0];
    let around = |i: u32| {
        let angle = 1.1 * f64::from(i);
        [2.4 * angle.cos(), 2.4 * angle.sin(), 0.2 * f64::from(i % 3)]
    };
    for settings in [exact, tolerant, budget] {
        let balls: Vec<[f64; 3]> = (0..6).map(around).collect();
        let mut monitor = among(&balls);
        monitor.set_settings(settings);
        for step in 0..300 {
            let seconds = 1e-3 * f64::from(step);
            let positions = [0.3 + seconds, 2.0 * seconds];
            let evaluation = monitor.on_joint_state(state(seconds, positions), at(seconds));
            let Some(checked_state) = &evaluation.checked_state else { continue };
            let [of_self, of_world] = distances(&evaluation);
            assert_eq!(evaluation.distance(), of_self.lesser(of_world));
            rough += u32::from(!checked_state.is_exact);
            compared += 1;
        }
    }
    assert!(compared > 600 && rough > 50 && rough < compared, "{rough} of {compared} were bounds");
}
