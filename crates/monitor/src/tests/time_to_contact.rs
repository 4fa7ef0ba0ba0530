//! Tests of the time to contact.

use super::*;

#[test]
fn the_time_to_contact_is_proven_from_velocities() {
    let ahead = |evaluation: &Evaluation| evaluation.checked_state.as_ref().unwrap().look_ahead.unwrap();
    let mut monitor = look_ahead();
    let still = monitor.on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0));
    assert_eq!((ahead(&still).free_for, ahead(&still).first), (0.5, None));
    assert_eq!(still.time_to_contact(), 0.5);

    // the ball touches the cube's face where the elbow is at pi - asin 0.3: 2.836899953
    let touch = std::f64::consts::PI - 0.3_f64.asin();
    let near = monitor.on_joint_state(moving(0.1, [0.0, touch - 0.2], &[0.0, 1.0]), at(0.15));
    let free_for = ahead(&near).free_for;
    // with an acceleration of 0.1 rad/s² from its velocity, contact is after 0.198 s
    assert!((0.18..0.199).contains(&free_for), "{free_for}");
    assert!(ahead(&near).first.is_some());
    assert!((near.time_to_contact() - (free_for - 0.05)).abs() < 1e-9, "its age counts");
    assert_eq!(monitor.on_heartbeat(at(0.4)).time_to_contact(), 0.0);

    let hit = monitor.on_joint_state(moving(0.5, COLLIDING, &[0.0, 0.0]), at(0.5));
    assert_eq!(ahead(&hit).free_for, 0.0);
    assert!(ahead(&hit).first.is_some());
    // a huge velocity leaves almost no time
    let wild = monitor.on_joint_state(moving(0.6, FREE, &[1e7, -1e7]), at(0.6));
    assert!(wild.time_to_contact() < 1e-3);
}

#[test]
fn without_velocities_the_time_to_contact_is_not_known() {
    for velocities in [&[][..], &[0.0], &[0.0, f64::NAN], &[0.0, 1e300], &[0.0; 3]] {
        let evaluation = look_ahead().on_joint_state(moving(0.0, FREE, velocities), at(0.0));
        assert_eq!(code(&evaluation), "FREE");
        assert!(evaluation.checked_state.as_ref().unwrap().look_ahead.is_none(), "{velocities:?}");
        assert_eq!(evaluation.time_to_contact(), 0.0);
        assert!(evaluation.warnings[0].contains("time to contact"), "{:?}", evaluation.warnings);
    }
    let off = monitor().on_joint_state(moving(0.0, FREE, &[0.0, 0.0]), at(0.0));
    assert_eq!((off.time_to_contact(), off.warnings.len()), (0.0, 0));
}
