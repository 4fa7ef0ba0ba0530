//! Tests of the status while another robot model is described and built.

use super::*;

#[test]
fn nothing_is_known_until_another_model_is_there_or_rejected() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    monitor.note_model_swap();
    assert_eq!(code(&monitor.on_heartbeat(at(0.0))), "model_swap");
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.1))), "model_swap");
    monitor.set_checker(revision(2));
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "FREE");

    monitor.note_model_swap();
    monitor.note_model_fault("not XML".to_owned());
    let evaluation = monitor.on_heartbeat(at(0.2));
    assert_eq!(code(&evaluation), "FREE");
    assert!(evaluation.warnings[0].contains("not XML"), "{:?}", evaluation.warnings);

    // the rejection remains while the world changes, and ends with the next model
    monitor.set_checker(Arc::new(Revision { world: 1, ..Arc::into_inner(revision(2)).unwrap() }));
    assert!(monitor.on_heartbeat(at(0.3)).warnings[0].contains("not XML"));
    monitor.set_checker(revision(3));
    assert!(monitor.on_heartbeat(at(0.4)).warnings.is_empty());
}

#[test]
fn nothing_is_known_while_a_description_waits_for_what_is_being_built() {
    let mut monitor = monitor();
    monitor.on_joint_state(state(0.0, FREE), at(0.0));
    monitor.note_description();
    assert_eq!(code(&monitor.on_joint_state(state(0.1, FREE), at(0.1))), "model_swap");
    // the finished build was another world for the previous robot
    monitor.set_checker(Arc::new(Revision { world: 1, ..Arc::into_inner(revision(1)).unwrap() }));
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "model_swap");
    monitor.note_description();
    monitor.note_processed_descriptions(1);
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "model_swap");
    monitor.note_model_swap();
    monitor.note_processed_descriptions(2);
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "model_swap");
    monitor.set_checker(revision(2));
    assert_eq!(code(&monitor.on_heartbeat(at(0.1))), "FREE");
}
