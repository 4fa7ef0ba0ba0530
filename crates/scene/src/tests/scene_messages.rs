//! Tests of scene messages: scene differences, robot states and whole scenes.

use super::*;

#[test]
fn a_difference_changes_what_it_names() {
    let mut cell = Cell::new();
    cell.object(add("a", "", Pose::identity())).unwrap();
    cell.object(add("b", "", Pose::identity())).unwrap();
    // as MoveIt's tutorials attach: the same message removes the object from the world
    let attach = hold("hand", ObjectChange::named("a", Operation::Add));
    let warnings = cell.scene(difference(vec![remove("a")], vec![attach])).unwrap();
    assert!(warnings[0].contains("'a' is attached"), "{warnings:?}");
    assert_eq!((cell.names(), cell.held()), (vec!["b"], vec!["a"]));
    // and as they detach: the object is detached and added again
    let change = difference(vec![add("a", "", at(7.0, 0.0, 0.0))], vec![hold("hand", remove("a"))]);
    cell.scene(change).unwrap();
    assert_eq!((cell.places("a"), cell.held().len()), (vec![[7.0, 0.0, 0.0]], 0));

    // valid parts of a message with an error are applied
    let change = difference(
        vec![add("c", "", Pose::identity()), remove("x")],
        vec![hold("hand", add("d", "hand", Pose::identity()))],
    );
    assert_eq!(cell.scene(change).unwrap_err().object.as_deref(), Some("x"));
    assert_eq!((cell.names(), cell.held()), (vec!["a", "b", "c"], vec!["d"]));
}

#[test]
fn a_robot_state_that_is_no_difference_lets_go_of_everything_if_it_says_something() {
    let attached = || vec![hold("hand", add("new", "hand", Pose::identity()))];
    let state = |is_diff, names_joints, attached| RobotStateChange {
        is_diff,
        names_joints,
        attached,
        ..RobotStateChange::default()
    };
    for (change, held) in [
        (state(false, false, vec![]), &["old"][..]),
        (state(true, true, vec![]), &["old"]),
        (state(false, true, vec![]), &[]),
        (state(false, false, attached()), &["old", "new"]),
        (state(false, true, attached()), &["new"]),
    ] {
        let mut cell = Cell::new();
        cell.attach(hold("hand", add("old", "hand", Pose::identity()))).unwrap();
        let change = SceneChange { robot_state: change, ..difference(vec![], vec![]) };
        cell.scene(change).unwrap();
        assert_eq!((cell.held(), cell.names().len()), (held.to_vec(), 0));
    }
    let mut cell = Cell::new();
    let change = state(false, true, vec![hold("hand", remove("old"))]);
    let change = SceneChange { robot_state: change, ..difference(vec![], vec![]) };
    cell.assert_rejected(&SceneUpdate::Scene(Box::new(change)), Some("old"), "only ADD is possible");
}

/// As in `MoveIt`, which applies the robot state before it looks up the frames of objects.
#[test]
fn the_robot_state_of_a_scene_places_the_frames_of_links() {
    let with = |positions: &[(&str, f64)], is_diff| {
        let single = positions.iter().map(|(name, q)| ((*name).to_owned(), *q)).collect();
        let positions = StatedPositions { single, ..StatedPositions::default() };
        let attached = vec![hold("hand", add("held", "base", Pose::identity()))];
        let robot_state = RobotStateChange { is_diff, names_joints: true, positions, attached };
        let objects = vec![add("a", "hand", at(0.0, 0.0, 1.0)), add("b", "flange", Pose::identity())];
        let change = SceneChange { is_diff, robot_state, ..difference(objects, vec![]) };
        let mut cell = Cell::new();
        let result = cell.scene(change);
        (cell, result)
    };
    for is_diff in [true, false] {
        for (positions, z) in [(&[][..], LIFTED), (&[("lift", 5.0)][..], 5.0)] {
            let (cell, result) = with(positions, is_diff);
            result.unwrap();
            assert_eq!(cell.places("a"), [[1.0, 0.0, z + 1.0]]);
            assert_eq!(cell.places("b"), [[0.0, 2.0, 0.0]]);
            let held = cell.scene.world.attached_by_name("held").unwrap();
            assert_eq!(held.pose_lo.translation.vector, Vector::new(-1.0, 0.0, -z));
        }
        for (name, position) in [("lif", 5.0), ("lift", f64::NAN)] {
            let (cell, result) = with(&[(name, position)], is_diff);
            assert!(result.unwrap_err().message.contains("'hand' moves"));
            assert_eq!((cell.names(), cell.held().len()), (vec!["b"], 0));
        }
    }
    for positions in [
        StatedPositions { fault: Some("2 positions for 1 names".to_owned()), ..StatedPositions::default() },
        StatedPositions { with_transforms: vec!["lift".to_owned()], ..StatedPositions::default() },
    ] {
        let robot_state = RobotStateChange { is_diff: true, positions, ..RobotStateChange::default() };
        let objects = vec![add("a", "hand", Pose::identity()), add("b", "flange", Pose::identity())];
        let mut cell = Cell::new();
        let refused = cell.scene(SceneChange { robot_state, ..difference(objects, vec![]) }).unwrap_err();
        assert!(refused.message.contains("'hand' moves, and the robot_state of the message is wrong"));
        assert_eq!(cell.names(), ["b"]);
    }
}

#[test]
fn a_whole_scene_takes_the_place_of_everything_but_what_sensors_see() {
    let mut cell = Cell::new();
    cell.object(add("a", "", Pose::identity())).unwrap();
    cell.attach(hold("hand", add("held", "hand", Pose::identity()))).unwrap();
    cell.scene.set_sensed("/cloud", Some(Obstacle::of_shape("/cloud", Pose::identity(), ball()))).unwrap();
    let (pose_fo, shape) = (at(0.0, 0.0, 1.0), Some(ball()));
    let octomap = OctomapPlacement { frame: "flange".to_owned(), pose_fo, shape, is_blank: false };
    cell.apply(&SceneUpdate::Octomap(Some(octomap.clone()))).unwrap();
    assert_eq!(cell.places(OCTOMAP), [[0.0, 2.0, 1.0]]);
    let change = SceneChange {
        link_padding: vec![("hand".to_owned(), 0.1)],
        link_scale: vec![("hand".to_owned(), 1.1)],
        matrix: entries(&["hand", "a"], true),
        fixed_frames: vec![FixedFrame { name: "f".into(), parent: "base".into(), pose_pf: Pose::identity() }],
        ..difference(vec![], vec![])
    };
    cell.scene(change).unwrap();
    cell.object(remove("")).unwrap();
    assert_eq!(cell.names(), ["/cloud", OCTOMAP]);

    let world = WorldChange { objects: vec![add("b", "f", Pose::identity())], octomap: None };
    cell.apply(&SceneUpdate::World(Box::new(WorldChange { octomap: Some(octomap), ..world }))).unwrap();
    assert_eq!((cell.names(), cell.held()), (vec!["/cloud", OCTOMAP, "b"], vec!["held"]));
    let warnings = cell.scene(SceneChange { robot_model_name: "other".to_owned(), ..SceneChange::default() });
    assert!(warnings.unwrap()[0].contains("'other'"));
    assert_eq!((cell.names(), cell.held().len()), (vec!["/cloud"], 0));
    assert!(cell.scene.matrix.is_none() && cell.scene.fixed_frames.is_empty());
    assert!(cell.scene.link_padding.is_empty() && cell.scene.link_scale.is_empty());
    cell.scene.remove_sensed("/cloud");
    assert!(cell.scene.world.is_empty());
}

#[test]
fn the_octree_of_a_file_is_known_until_a_message_takes_its_place() {
    let mut loader = SceneLoader::default();
    let octree = Octomap::from_binary(0.1, &[0x80, 0]).unwrap();
    loader.add_octomap(&octree, "a.bt", &Cell::new().robot).unwrap();
    let map = OctomapPlacement::of(&octree, String::new(), Pose::identity(), false).unwrap();
    let whole = SceneChange { keeps_octomap: true, ..SceneChange::default() };
    for (update, is_known) in [
        (SceneUpdate::Object(Box::new(add("a", "", Pose::identity()))), true),
        (SceneUpdate::Object(Box::new(remove(""))), true),
        (SceneUpdate::Scene(Box::new(whole)), true),
        (SceneUpdate::Scene(Box::default()), false),
        (SceneUpdate::World(Box::default()), false),
        (SceneUpdate::Octomap(Some(map)), false),
        (SceneUpdate::Octomap(None), false),
    ] {
        let mut cell = Cell { scene: loader.scene.clone(), ..Cell::new() };
        let known = cell.scene.file_octree().unwrap().clone();
        assert_eq!((known.resolution, known.data.as_slice()), (0.1, &[0x80, 0][..]));
        cell.apply(&update).unwrap();
        assert_eq!(cell.scene.file_octree(), Some(&known).filter(|_| is_known), "{update:?}");
    }
}
