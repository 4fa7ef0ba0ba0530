//! Tests of joint states with names and no positions.

use super::*;

/// A joint state with only velocities, or only efforts.
fn unpositioned(seconds: f64, names: &[&str], velocities: &[f64]) -> JointStateInput {
    let names = names.iter().map(|&name| name.to_owned()).collect();
    JointStateInput { names, velocities: velocities.to_vec(), positions: Vec::new(), ..state(seconds, FREE) }
}

fn warns(evaluation: &Evaluation) -> bool {
    evaluation.warnings.iter().any(|warning| warning.contains("gives no positions"))
}

#[test]
fn a_joint_state_without_positions_is_skipped_with_a_warning() {
    for velocities in [&[][..], &[9.0][..]] {
        let mut monitor = monitor();
        monitor.on_joint_state(state(0.0, FREE), at(0.0));
        let evaluation = monitor.on_joint_state(unpositioned(0.1, &["elbow"], velocities), at(0.1));
        assert_eq!((code(&evaluation), warns(&evaluation)), ("FREE", true));
        // its velocities are not combined with the positions
        let checked_state = evaluation.checked_state.unwrap();
        assert_eq!((&checked_state.velocities, &checked_state.rates), (&None, &None));
        assert_eq!(evaluation.stamp, Some(time(START)));
        // the age of the earlier positions grows
        for i in 2..6 {
            let seconds = 0.1 * f64::from(i);
            monitor.on_joint_state(unpositioned(seconds, &["elbow"], velocities), at(seconds));
        }
        let evaluation = monitor.on_joint_state(unpositioned(0.6, &["elbow"], velocities), at(0.6));
        assert_eq!((code(&evaluation), warns(&evaluation)), ("stale", true));
        assert_eq!(code(&monitor.on_joint_state(state(0.7, FREE), at(0.7))), "FREE");
        assert!(!warns(&monitor.on_heartbeat(at(1.2))));
    }
}

#[test]
fn before_any_positions_came_no_joint_state_has_come() {
    let mut monitor = monitor();
    let evaluation = monitor.on_joint_state(unpositioned(0.0, &["elbow", "shoulder"], &[0.0, 0.0]), at(0.0));
    assert_eq!((code(&evaluation), warns(&evaluation)), ("no_joint_state", true));
}

#[test]
fn what_other_robots_do_not_say_is_no_warning() {
    let mut monitor = monitor();
    monitor.set_settings(MonitorSettings { joint_prefix: "left_".to_owned(), ..MonitorSettings::default() });
    let evaluation = monitor.on_joint_state(unpositioned(0.0, &["right_elbow"], &[]), at(0.0));
    assert!(!warns(&evaluation));
}
