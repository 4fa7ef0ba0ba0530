//! Tests of a root that `tf` moves between two joint states, by jumps and in several transforms at once.

use clearance_geometry::math::Pose;
use clearance_scene::{ObjectChange, Operation, Transform};

use super::root_location::Room;
use super::*;

/// The root stands, and is 2 m farther in the next transform: the obstacle that it jumped over is 1 m away before and after.
#[test]
fn a_root_that_jumps_is_not_proven_to_be_free_on_the_way() {
    let motions = |jump: f64| {
        let mut room = Room::new();
        room.monitor.set_settings(MonitorSettings { stale_after: 9.0, ..MonitorSettings::default() });
        let mut motions = Vec::new();
        for step in 0..20 {
            let seconds = 0.02 * f64::from(step);
            room.send(if step < 10 { 0.0 } else { jump }, seconds);
            room.follow();
            motions.push(room.evaluated(seconds).motion_since_previous);
        }
        motions
    };
    let of_jump = motions(14.0);
    assert!(
        of_jump[9..].iter().any(|motion| motion.reason().is_some_and(|why| why.contains("root moves"))),
        "{of_jump:?}"
    );
    assert!(of_jump[10] != MotionSincePrevious::ProvenFree);
    assert!(motions(0.0)[1..].iter().all(|motion| *motion == MotionSincePrevious::ProvenFree));
}

/// Heartbeats between slow joint states, and transforms that come at once, do not hide where the root was.
#[test]
fn a_root_that_jumps_between_slow_joint_states_is_not_proven_to_be_free() {
    let proven = |places: &[f64], are_read: bool| {
        let mut room = Room::new();
        room.monitor.set_settings(MonitorSettings { stale_after: 9.0, ..MonitorSettings::default() });
        for seconds in [0.0, 0.02] {
            room.send(0.0, seconds);
            room.follow();
            room.evaluated(seconds);
        }
        for (number, x) in (1..).zip(places) {
            let seconds = 0.02 + 0.02 * f64::from(number);
            room.send(*x, seconds);
            if are_read {
                room.follow();
                room.monitor.note_transforms(&room.transforms);
                room.monitor.on_heartbeat(at(seconds));
            }
        }
        room.follow();
        room.evaluated(1.0).motion_since_previous == MotionSincePrevious::ProvenFree
    };
    let resting = |x: f64| std::iter::repeat_n(x, 20);
    let jump: Vec<f64> = std::iter::once(0.0).chain(resting(14.0)).collect();
    let back: Vec<f64> = [0.0, 14.0, 0.0].into_iter().chain(resting(0.0)).collect();
    for are_read in [true, false] {
        assert!(proven(&[0.0; 20], are_read));
        assert!(!proven(&jump, are_read), "{are_read}");
        assert!(!proven(&back, are_read), "{are_read}");
    }
}

/// Paths to two frames share a transform, several of which come between two reads.
#[test]
fn a_shared_transform_is_followed_once() {
    let mut room = Room::new();
    let hall = Transform { parent: "hall".to_owned(), pose_pf: Pose::identity(), stamp: None };
    room.transforms.insert("map", hall);
    let ball = clearance_geometry::Shape::Primitive(clearance_geometry::Primitive::sphere(0.1).unwrap());
    let shapes = vec![clearance_scene::ObstacleShape { pose_os: Pose::identity(), shape: ball }];
    let gate = ObjectChange { frame: "hall".to_owned(), ..ObjectChange::named("gate", Operation::Add) };
    room.change(ObjectChange { shapes, pose_fo: Pose::translation(0.0, 9.0, 0.0), ..gate });
    for step in 0..100_u32 {
        let seconds = 0.01 * f64::from(step);
        room.send(0.5 * seconds, seconds);
        if step % 4 == 3 {
            room.follow();
            let evaluation = room.evaluated(seconds);
            let motions = &evaluation.checked_state.as_ref().unwrap().obstacle_motions;
            assert_eq!(motions.len(), 2);
            for motion in motions.iter().filter(|_| step > 20) {
                assert!(motion.observed[0].time > 0.099, "{motion:?}");
                // 2 cm since the previous state
                assert!((motion.since_state[0].of_radius(0.0) - 0.02).abs() < 1e-9, "{motion:?}");
            }
        }
    }
}
