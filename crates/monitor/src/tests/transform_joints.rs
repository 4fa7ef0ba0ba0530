//! Tests of a mobile base whose pose comes from tf.

use clearance_scene::{Transform, TransformTree};

use super::*;

/// A base that drives in a plane, with an arm of one joint; or one that floats.
fn base_on(kind: &str) -> Arc<Revision> {
    let text = format!(
        r#"<robot name="rover">
  <link name="odom"/>
  <link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="arm"/>
  <joint name="drive" type="{kind}">
    <parent link="odom"/><child link="base"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="lift" type="prismatic">
    <parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>"#
    );
    let robot = RobotModel::from_urdf(&text, &MeshFiles::default()).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    Arc::new(Revision::new(checker, 1, 0))
}

/// `tf` from odom to base through an intermediate frame, stamped `seconds` after the start.
fn tree(seconds: f64, pose: clearance_geometry::math::Pose) -> TransformTree {
    let mut tree = TransformTree::default();
    let fixed = Transform {
        parent: "odom".to_owned(),
        pose_pf: clearance_geometry::math::Pose::identity(),
        stamp: None,
    };
    assert!(tree.insert("between", fixed));
    let moving =
        Transform { parent: "between".to_owned(), pose_pf: pose, stamp: Some(time(START + seconds)) };
    assert!(tree.insert("base", moving));
    tree
}

fn rover(kind: &str) -> Monitor {
    let transform_joints = vec!["drive".to_owned()];
    let settings = MonitorSettings { transform_joints, ..MonitorSettings::default() };
    let mut monitor = Monitor::new(settings, stopwatch);
    monitor.set_checker(base_on(kind));
    monitor
}

fn pose(xyz: [f64; 3], rpy: [f64; 3]) -> clearance_geometry::math::Pose {
    clearance_geometry::math::pose_from_xyz_rpy(xyz, rpy)
}

#[test]
fn a_base_stands_where_tf_places_it() {
    for (kind, there) in [
        ("planar", pose([3.0, 2.0, 0.0], [0.0, 0.0, 2.5])),
        ("planar", pose([3.0, 2.0, 0.0], [0.0, 0.0, -3.1])),
        ("floating", pose([3.0, 2.0, -1.0], [0.4, 1.0, -2.5])),
    ] {
        let mut monitor = rover(kind);
        let lift = || input(0.0, &[("lift", 0.5)]);
        let evaluation = monitor.on_joint_state(lift(), at(0.0));
        let reason = evaluation.status.reason().unwrap().to_string();
        assert_eq!(code(&evaluation), "partial", "without a word of tf: {reason}");
        monitor.note_transforms(&TransformTree::default());
        let evaluation = monitor.on_joint_state(lift(), at(0.0));
        let reason = evaluation.status.reason().unwrap().to_string();
        assert_eq!(code(&evaluation), "no_transform");
        assert!(reason.contains("'odom' to 'base'") && reason.contains("'drive'"), "{reason}");

        monitor.note_transforms(&tree(0.0, there));
        let evaluation = monitor.on_heartbeat(at(0.0));
        assert_eq!(code(&evaluation), "FREE");
        let checked_state = evaluation.checked_state.unwrap();
        let base = evaluation.revision.unwrap().checker.robot().link_by_name("base").unwrap();
        let apart = checked_state.poses.pose(base).inv_mul(&there);
        assert!(apart.translation.vector.norm() < 1e-9 && apart.rotation.angle() < 1e-9, "{kind}: {apart}");
    }
}

#[test]
fn a_transform_that_is_old_or_leaves_the_plane_places_nothing() {
    let lift = |seconds| input(seconds, &[("lift", 0.5), ("drive/x", f64::NAN)]);
    let mut monitor = rover("planar");
    monitor.note_transforms(&tree(0.0, pose([3.0, 0.0, 0.0], [0.0; 3])));
    assert_eq!(
        code(&monitor.on_joint_state(lift(0.0), at(0.0))),
        "FREE",
        "joint states say nothing about it"
    );
    assert_eq!(code(&monitor.on_joint_state(lift(1.0), at(1.0))), "FREE");
    let due = monitor.time_to_heartbeat(at(1.0));
    assert!(due < Duration::from_millis(2), "{due:?}");
    let evaluation = monitor.on_heartbeat(at(1.01));
    assert!(evaluation.robot_state.is_none() && code(&evaluation) == "no_transform");
    assert!(evaluation.status.reason().unwrap().to_string().contains("1.010 s old"));
    monitor.note_transforms(&tree(1.1, pose([3.0, 0.0, 0.0], [0.0; 3])));
    assert_eq!(code(&monitor.on_heartbeat(at(1.1))), "FREE");

    for (there, why) in [
        (tree(1.2, pose([3.0, 0.0, 0.01], [0.0; 3])), "leaves the joint's plane by 0.0100"),
        (tree(1.2, pose([3.0, 0.0, 0.0], [0.01, 0.0, 0.0])), "leaves the joint's plane by 0.0100"),
        (tree(9.0, pose([3.0, 0.0, 0.0], [0.0; 3])), "in the future"),
    ] {
        monitor.note_transforms(&there);
        let evaluation = monitor.on_joint_state(lift(1.2), at(1.2));
        let reason = evaluation.status.reason().unwrap().to_string();
        assert!(code(&evaluation) == "no_transform" && reason.contains(why), "{reason}");
    }
}

#[test]
fn a_wish_for_transforms_that_cannot_be_fulfilled_is_reported() {
    let transform_joints = vec!["drive".to_owned(), "lift".to_owned(), "wing".to_owned()];
    let mut monitor = rover("floating");
    monitor.set_settings(MonitorSettings { transform_joints, ..MonitorSettings::default() });
    monitor.note_transforms(&tree(0.0, pose([3.0, 0.0, 0.0], [0.0; 3])));
    let evaluation = monitor.on_joint_state(input(0.0, &[("lift", 0.5)]), at(0.0));
    assert_eq!(code(&evaluation), "FREE");
    assert_eq!(evaluation.warnings.len(), 2);
    assert!(evaluation.warnings[0].contains("'lift'") && evaluation.warnings[1].contains("'wing'"));
}
