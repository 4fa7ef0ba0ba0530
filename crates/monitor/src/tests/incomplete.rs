//! Tests that the status is UNKNOWN while the world is known to be incomplete.

use super::*;

fn incomplete_for(reason: &Reason) -> Monitor {
    let mut monitor = monitor();
    monitor.note_world_faults(vec!["a fault".to_owned()], Some(reason.clone()));
    monitor
}

fn reasons() -> [(Reason, &'static str); 3] {
    let (source, cause) = ("/camera".to_owned(), "it has no points".to_owned());
    let fault = "collision_object: object 'a': no shapes".to_owned();
    [
        (
            Reason::BlindCloud { source, cause, more: 0 },
            "'/camera' shows nothing of the environment: it has no points",
        ),
        (Reason::RejectedObstacle { fault, more: 2 }, "object 'a': no shapes; and 2 more parts"),
        (Reason::LostMessages { topics: vec!["3 of collision_object".to_owned()] }, "3 of collision_object"),
    ]
}

#[test]
fn a_world_known_to_be_incomplete_is_unknown_until_it_is_not() {
    for (reason, named) in reasons() {
        let mut monitor = incomplete_for(&reason);
        // COLLIDING is not reported either
        for (seconds, joints) in [(0.0, FREE), (0.1, COLLIDING), (0.2, FREE)] {
            let evaluation = monitor.on_joint_state(state(seconds, joints), at(seconds));
            assert_eq!(code(&evaluation), reason.code());
            assert!(evaluation.stale_world.is_some() && evaluation.robot_state.is_some());
            assert_eq!((evaluation.speed_scale, evaluation.distance().is_nan()), (0.0, true));
            let text = evaluation.status.reason().unwrap().to_string();
            assert!(text.contains(named), "{text}");
        }
        monitor.note_world_faults(Vec::new(), None);
        // published at once, not at the next heartbeat
        assert_eq!(monitor.time_to_heartbeat(at(0.2)), Duration::ZERO);
        assert_eq!(code(&monitor.on_heartbeat(at(0.2))), "FREE");
    }
}

#[test]
fn the_first_state_in_a_new_world_knows_that_it_is_incomplete() {
    let (reason, _) = reasons().into_iter().nth(1).unwrap();
    let mut monitor = monitor();
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), at(0.0))), "FREE");
    let mut incomplete = Arc::into_inner(revision(2)).unwrap();
    incomplete.incomplete = Some(reason);
    monitor.set_checker(Arc::new(incomplete));
    assert_eq!(code(&monitor.on_heartbeat(at(0.01))), "rejected_obstacle");
}

#[test]
fn what_is_known_of_the_robot_comes_before_what_is_missing_around_it() {
    let (reason, _) = reasons().into_iter().next().unwrap();
    let mut monitor = incomplete_for(&reason);
    assert_eq!(code(&monitor.on_heartbeat(at(0.0))), "no_joint_state");
    let partial = monitor.on_joint_state(input(0.0, &[("elbow", 0.0)]), at(0.0));
    assert_eq!(code(&partial), "partial");
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.1))), "blind_cloud");
    let stale = monitor.on_heartbeat(at(9.0));
    assert_eq!((code(&stale), stale.stale_world.is_some()), ("stale", true));
}
