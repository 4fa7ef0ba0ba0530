//! Tests of the contact points of colliding pairs.

use clearance_checker::PairContacts;
use clearance_geometry::math::{Pose, Vector};
use clearance_geometry::{Primitive, Shape};
use clearance_scene::Obstacle;

use super::*;

/// The robot, whose ball at (2, 0, 0) of radius 0.1 m is 0.02 m deep in a wall, with this many contacts of each pair.
fn at_a_wall(contacts_per_pair: usize) -> Monitor {
    let mut world = World::default();
    let wall = Shape::Primitive(Primitive::Box { half_extents: [1.0, 1.0, 1.0] });
    world.add(Obstacle::of_shape("wall", Pose::translation(3.08, 0.0, 0.0), wall)).unwrap();
    let robot = RobotModel::from_urdf(URDF, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &world, Settings::default()).unwrap();
    let mut monitor = Monitor::new(settings(contacts_per_pair), stopwatch);
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 1)));
    monitor
}

fn settings(contacts_per_pair: usize) -> MonitorSettings {
    MonitorSettings { contacts_per_pair, ..settings_of_lookout() }
}

fn contacts(evaluation: &Evaluation) -> &[ContactsOfPair] {
    &evaluation.checked_state.as_ref().unwrap().contacts
}

#[test]
fn colliding_pairs_have_contacts_if_they_are_requested() {
    let evaluation = at_a_wall(4).on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0));
    assert_eq!(code(&evaluation), "COLLIDING");
    let [ContactsOfPair { bodies, contacts: PairContacts { deepest, .. } }] = contacts(&evaluation) else {
        panic!("{:?}", contacts(&evaluation))
    };
    assert_eq!(evaluation.checked_state.as_ref().unwrap().report.colliding_pairs, [*bodies]);
    assert!((deepest.depth.unwrap() - 0.02).abs() < 1e-6, "{deepest:?}");
    assert!((deepest.normal.unwrap() - Vector::x()).norm() < 1e-6, "towards the second body: {deepest:?}");

    let none = at_a_wall(0).on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0));
    assert_eq!((contacts(&none), none.left_out), (&[][..], LeftOut::Nothing));
    let mut monitor = at_a_wall(4);
    let free = monitor.on_joint_state(moving(0.0, [0.0, 1.0], &[0.0, 0.0]), at(0.0));
    assert_eq!((code(&free), contacts(&free)), ("FREE", &[][..]));
    // the setting changes while the node runs
    let mut monitor = at_a_wall(0);
    monitor.set_settings(settings(1));
    let one = monitor.on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0));
    assert_eq!(contacts(&one).iter().map(|of_pair| of_pair.contacts.count()).sum::<usize>(), 1);
}

/// Everything else of an evaluation is the same with contacts.
#[test]
fn contacts_change_nothing_else() {
    let [mut with, mut without] = [3, 0].map(at_a_wall);
    for step in 0..60 {
        let (seconds, turn) = (0.01 * f64::from(step), 0.05 * f64::from(step - 30));
        let [a, b] = [&mut with, &mut without]
            .map(|monitor| monitor.on_joint_state(moving(seconds, [0.0, turn], &[0.0, 0.1]), at(seconds)));
        assert_eq!((&a.status, a.speed_scale, &a.warnings), (&b.status, b.speed_scale, &b.warnings));
        assert_eq!(a.time_to_contact(), b.time_to_contact());
        let [mut a, mut b] = [a, b].map(|e| e.checked_state.unwrap().report.clone());
        (a.work, b.work) = Default::default();
        assert_eq!(a, b);
    }
}

/// A recorded run in which the deadline passed while contacts were searched, or before.
#[test]
fn where_the_deadline_left_contacts_open_there_is_a_warning() {
    let told = |evaluation: &Evaluation| {
        evaluation
            .warnings
            .iter()
            .any(|warning| warning.starts_with("contacts of some colliding pairs are not known"))
    };
    let mut monitor = at_a_wall(4);
    monitor.leave_out(LeftOut::Contacts);
    let evaluation = monitor.on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0));
    assert_eq!((code(&evaluation), evaluation.left_out), ("COLLIDING", LeftOut::Contacts));
    assert!(told(&evaluation) && evaluation.checked_state.as_ref().unwrap().look_ahead.is_some());
    // a replay has all contacts, of which the recorded ones were the first
    assert_eq!(contacts(&evaluation).len(), 1);

    let mut monitor = at_a_wall(4);
    monitor.leave_out(LeftOut::LookAhead);
    let evaluation = monitor.on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0));
    assert!(told(&evaluation) && contacts(&evaluation).is_empty());
    assert_eq!(evaluation.left_out, LeftOut::LookAhead);
}
