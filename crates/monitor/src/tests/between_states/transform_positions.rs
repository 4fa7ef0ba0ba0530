//! Tests of the check between two states whose joint positions come from `tf`.

use clearance_scene::{Transform, TransformTree};

use super::*;

/// A planar base that `tf` moves, its rotation the short way; and a floating one.
#[test]
fn joints_from_tf_are_checked_like_others() {
    for kind in ["planar", "floating"] {
        let text = format!(
            r#"<robot name="rover">
  <link name="odom"/>
  <link name="base"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="drive" type="{kind}"><parent link="odom"/><child link="base"/><axis xyz="0 0 1"/></joint>
</robot>"#
        );
        let robot = Arc::new(RobotModel::from_urdf(&text, &MeshFiles::default()).unwrap());
        let mut world = World::default();
        world.add(wall("wall", [-1.0, 0.0, 0.0])).unwrap();
        let checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
        let transform_joints = vec!["drive".to_owned()];
        // a floating joint has no tube
        let mut monitor = sweeper(MonitorSettings { transform_joints, joint_noise: 1e-4, ..settings() });
        monitor.set_checker(Arc::new(Revision::new(checker, 1, 1)));
        for (step, yaw, expected) in [(0, 2.9, None), (1, 3.0, None), (2, -3.0, names("base", "wall"))] {
            let seconds = 0.02 * f64::from(step);
            let pose_pf = clearance_geometry::math::pose_from_xyz_rpy([0.0; 3], [0.0, 0.0, yaw]);
            let mut tree = TransformTree::default();
            let stamp = Some(time(START + seconds));
            assert!(tree.insert("base", Transform { parent: "odom".to_owned(), pose_pf, stamp }));
            monitor.note_transforms(&tree);
            let evaluation = monitor.on_heartbeat(at(seconds));
            assert_eq!(pair(&evaluation), expected, "{kind}: {}", why(&evaluation));
            assert_eq!(is_proven(&evaluation), expected.is_some());
            assert_eq!(code(&evaluation), if expected.is_some() { "COLLIDING" } else { "FREE" });
        }
    }
}

/// A planar base that `tf` moves, with a joint of joint states, before a wall at its left.
fn rover(settings: MonitorSettings) -> Monitor {
    let text = r#"<robot name="rover">
  <link name="odom"/>
  <link name="base"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="flag"/>
  <joint name="drive" type="planar"><parent link="odom"/><child link="base"/><axis xyz="0 0 1"/></joint>
  <joint name="wave" type="continuous"><parent link="base"/><child link="flag"/></joint>
</robot>"#;
    let robot = Arc::new(RobotModel::from_urdf(text, &MeshFiles::default()).unwrap());
    let mut world = World::default();
    world.add(wall("wall", [-1.0, 0.0, 0.0])).unwrap();
    let checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
    let mut monitor = sweeper(MonitorSettings { transform_joints: vec!["drive".to_owned()], ..settings });
    monitor.set_checker(Arc::new(Revision::new(checker, 1, 1)));
    monitor
}

/// The base has turned by `yaw` (rad) at this time (s), as `tf` says.
fn turn_base(monitor: &mut Monitor, seconds: f64, yaw: f64) {
    let pose_pf = clearance_geometry::math::pose_from_xyz_rpy([0.0; 3], [0.0, 0.0, yaw]);
    let stamp = Some(time(START + seconds));
    let mut tree = TransformTree::default();
    assert!(tree.insert("base", Transform { parent: "odom".to_owned(), pose_pf, stamp }));
    monitor.note_transforms(&tree);
}

fn wave(monitor: &mut Monitor, seconds: f64) -> Evaluation {
    let input = JointStateInput {
        stamp: time(START + seconds),
        names: vec!["wave".to_owned()],
        positions: vec![0.1 * seconds],
        ..JointStateInput::default()
    };
    monitor.on_joint_state(input, at(seconds))
}

/// `tf` comes at 20 Hz, joint states at 1 kHz: the base had 50 ms to deviate by 100 rad/s² * (50 ms)² / 8 = 0.03 rad.
#[test]
fn positions_from_tf_deviate_for_as_long_as_their_transforms_are_apart() {
    for (acceleration, is_free) in [(100.0, false), (10.0, true)] {
        let mut monitor = rover(MonitorSettings { between_states_acceleration: acceleration, ..settings() });
        let yaw = std::f64::consts::PI - 0.03;
        turn_base(&mut monitor, 0.0, yaw - 0.001);
        for millisecond in 0..50 {
            wave(&mut monitor, 1e-3 * f64::from(millisecond));
        }
        turn_base(&mut monitor, 0.05, yaw);
        let evaluation = wave(&mut monitor, 0.05);
        assert_eq!(code(&evaluation), "FREE");
        let is_proven_free = evaluation.motion_since_previous == MotionSincePrevious::ProvenFree;
        assert_eq!(is_proven_free, is_free, "{acceleration}: {}", why(&evaluation));
    }
}

/// The base rests for a second; each transform is evaluated.
#[test]
fn the_first_motion_after_a_rest_is_checked() {
    let mut monitor = rover(settings());
    for step in 0..20 {
        let seconds = 0.05 * f64::from(step);
        turn_base(&mut monitor, seconds, 3.0);
        monitor.on_heartbeat(at(seconds));
        wave(&mut monitor, seconds);
    }
    turn_base(&mut monitor, 1.0, -3.0);
    let evaluation = wave(&mut monitor, 1.0);
    assert_eq!((code(&evaluation), pair(&evaluation)), ("COLLIDING", names("base", "wall")));
}
