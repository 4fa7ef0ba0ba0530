//! Tests that a world that lags behind its messages is not FREE for long.

use super::*;

fn received(seconds: f64) -> Duration {
    Duration::from_secs_f64(seconds)
}

#[test]
fn a_message_that_is_not_in_force_soon_makes_the_state_unknown_until_it_is() {
    let mut monitor = monitor();
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), at(0.0))), "FREE");
    monitor.note_world_update(received(0.05));
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.1))), "FREE");
    // published as soon as the lag is too long, not at the next heartbeat
    let due = monitor.time_to_heartbeat(at(0.1)).as_secs_f64();
    assert!((0.049..0.051).contains(&due), "{due}");
    // COLLIDING is not reported either, and a query while the monitor is busy returns no outdated status
    let busy = monitor.on_heartbeat(at(0.14)).aged(at(0.16));
    assert!(!busy.status.is_free() && busy.stale_world.is_some());
    for (seconds, joints) in [(0.151, FREE), (0.2, COLLIDING), (5.0, FREE)] {
        let evaluation = monitor.on_joint_state(state(seconds, joints), at(seconds));
        assert_eq!(code(&evaluation), "world_update");
        assert!(evaluation.stale_world.is_some() && evaluation.robot_state.is_some());
        assert_eq!((evaluation.speed_scale, evaluation.distance().is_nan()), (0.0, true));
    }
    let reason = monitor.on_heartbeat(at(5.0)).status.reason().unwrap().to_string();
    assert!(reason.contains("1 messages about it are not in force yet, the oldest for 4.950 s"), "{reason}");

    // the announcement of a new world does not put it into force
    monitor.note_world_updates_completing(1);
    assert_eq!(code(&monitor.on_heartbeat(at(5.1))), "world_update");
    monitor.set_checker(revision(1));
    assert_eq!(code(&monitor.on_heartbeat(at(5.2))), "FREE");
}

#[test]
fn a_message_that_changes_nothing_is_in_force_without_another_checker() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    monitor.note_world_update(received(0.0));
    assert_eq!(code(&monitor.on_heartbeat(at(0.2))), "world_update");
    monitor.note_world_updates_completing(1);
    monitor.note_world_faults(Vec::new(), None);
    // published at once
    assert_eq!(monitor.time_to_heartbeat(at(0.2)), Duration::ZERO);
    assert_eq!(code(&monitor.on_heartbeat(at(0.2))), "FREE");
}

#[test]
fn messages_that_wait_behind_one_that_takes_long_count_from_their_own_receipt() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.4, FREE), at(0.4));
    monitor.note_world_update(received(0.0));
    monitor.note_world_update(received(0.45));
    monitor.note_world_updates_completing(1);
    monitor.set_checker(revision(1));
    assert_eq!(code(&monitor.on_heartbeat(at(0.5))), "FREE");
    assert_eq!(code(&monitor.on_heartbeat(at(0.55))), "world_update");
    // a message that requires no change is no longer waited for
    monitor.note_world_update_withdrawn();
    assert_eq!(code(&monitor.on_heartbeat(at(0.56))), "FREE");
    // a message that waited long inside the node is late at once
    monitor.note_world_update(received(0.3));
    assert_eq!(monitor.time_to_heartbeat(at(0.57)), Duration::ZERO);
    assert_eq!(code(&monitor.on_heartbeat(at(0.57))), "world_update");
}

/// Thirty messages a second; each is in force 20 ms later.
#[test]
fn ordinary_updates_are_never_reported() {
    let mut monitor = monitor();
    for update in 0..300 {
        let seconds = 0.033 * f64::from(update);
        monitor.note_world_update(received(seconds));
        assert_eq!(code(&monitor.on_joint_state(state(seconds, FREE), at(seconds))), "FREE");
        assert_eq!(code(&monitor.on_heartbeat(at(seconds + 0.019))), "FREE");
        monitor.note_world_updates_completing(1);
        if update % 2 == 0 {
            monitor.set_checker(revision(1));
        }
        monitor.note_world_faults(Vec::new(), None);
        assert_eq!(code(&monitor.on_heartbeat(at(seconds + 0.02))), "FREE");
    }
}

#[test]
fn more_updates_than_were_received_do_no_harm() {
    let mut monitor = monitor();
    monitor.note_world_updates_completing(usize::MAX);
    monitor.note_world_update_withdrawn();
    monitor.set_checker(revision(1));
    monitor.note_world_update(Duration::MAX);
    assert_eq!(code(&monitor.on_joint_state(state(0.0, FREE), at(0.0))), "FREE");
}
