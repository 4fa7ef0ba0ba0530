//! Tests of obstacle states: poses and velocities of tracked obstacles.

use super::*;

fn state(id: &str, frame: &str, pose_fo: Pose, linear: [f64; 3]) -> ObstacleState {
    ObstacleState {
        id: id.to_owned(),
        frame: frame.to_owned(),
        pose_fo,
        linear_f: linear.into(),
        angular_f: Vector::zeros(),
    }
}

fn states(states: Vec<ObstacleState>) -> SceneUpdate {
    SceneUpdate::States(ObstacleStates { stamp: seconds(99.0), received: Duration::from_secs(5), states })
}

/// Names and velocities (root frame) of the obstacles that move.
fn velocities(cell: &Cell) -> Vec<(&str, [f64; 3])> {
    let rounded = |v: Vector| v.map(|x| (x * 1e9).round() / 1e9 + 0.0).into();
    let velocity = |twist: &'_ ObstacleTwist| {
        let pose_ro = cell.scene.world.obstacle_by_name(&twist.name).unwrap().pose_ro;
        rounded(pose_ro.rotation * twist.linear_o)
    };
    let moving = cell.scene.obstacle_twists().filter(|twist| twist.moves());
    moving.map(|twist| (twist.name.as_str(), velocity(twist))).collect()
}

fn turned(yaw: f64) -> Pose {
    clearance_geometry::math::pose_from_xyz_rpy([5.0, 0.0, 0.0], [0.0, 0.0, yaw])
}

#[test]
fn a_state_moves_an_obstacle_and_gives_it_a_velocity() {
    let mut cell = Cell::new();
    for id in ["a", "b", "c"] {
        cell.object(add(id, "", at(5.0, 0.0, 0.0))).unwrap();
    }
    let velocity = [1.0, 2.0, 0.0];
    let both = vec![state("a", "", at(6.0, 0.0, 0.0), velocity), state("b", "flange", turned(1.0), velocity)];
    cell.apply(&states(both)).unwrap();
    assert_eq!((cell.places("a"), cell.places("b")), (vec![[6.0, 0.0, 0.0]], vec![[5.0, 2.0, 0.0]]));
    assert_eq!(velocities(&cell), [("a", velocity), ("b", velocity)]);
    let twist = cell.scene.obstacle_twists().next().unwrap();
    assert_eq!((twist.stamp, twist.received), (seconds(99.0), Duration::from_secs(5)));
    // at rest
    cell.apply(&states(vec![state("a", "", at(7.0, 0.0, 0.0), [0.0; 3])])).unwrap();
    assert_eq!(cell.places("a"), [[7.0, 0.0, 0.0]]);
    assert_eq!(velocities(&cell), [("b", velocity)]);
    assert_eq!(cell.scene.obstacle_twists().count(), 2);
}

/// Two trackers, of which one is late; and a clock that is set back.
#[test]
fn an_older_state_does_not_replace_a_newer_one() {
    let mut cell = Cell::new();
    cell.object(add("a", "", at(5.0, 0.0, 0.0))).unwrap();
    let at_time = |x: f64, time: f64| {
        let states = vec![state("a", "", at(x, 0.0, 0.0), [0.0; 3])];
        SceneUpdate::States(ObstacleStates { stamp: seconds(time), received: Duration::ZERO, states })
    };
    cell.apply(&at_time(6.0, 99.0)).unwrap();
    cell.assert_rejected(&at_time(7.0, 98.7), Some("a"), "0.300 s older");
    cell.assert_rejected(&at_time(7.0, 30.0), Some("a"), "69.000 s older");
    assert_eq!(cell.places("a"), [[6.0, 0.0, 0.0]]);
    cell.now = seconds(31.0);
    cell.apply(&at_time(8.0, 30.0)).unwrap();
    assert_eq!(cell.places("a"), [[8.0, 0.0, 0.0]]);
    cell.object(shift("a", "", at(9.0, 0.0, 0.0))).unwrap();
    cell.apply(&at_time(7.0, 29.9)).unwrap();
    assert_eq!(cell.places("a"), [[7.0, 0.0, 0.0]]);
}

#[test]
fn any_other_pose_ends_a_velocity() {
    type Change = fn(&mut Cell);
    let set = |cell: &mut Cell| {
        cell.object(add("a", "", at(5.0, 0.0, 0.0))).unwrap();
        cell.apply(&states(vec![state("a", "", at(5.0, 0.0, 0.0), [1.0, 0.0, 0.0])])).unwrap();
        assert_eq!(velocities(cell).len(), 1);
    };
    let changes: [Change; 7] = [
        |cell| drop(cell.object(add("a", "", at(5.0, 0.0, 0.0))).unwrap()),
        |cell| drop(cell.object(shift("a", "", at(6.0, 0.0, 0.0))).unwrap()),
        |cell| drop(cell.object(remove("a")).unwrap()),
        |cell| drop(cell.object(remove("")).unwrap()),
        |cell| drop(cell.apply(&SceneUpdate::World(Box::default())).unwrap()),
        |cell| drop(cell.scene(SceneChange::default()).unwrap()),
        |cell| {
            cell.attach(hold("flange", ObjectChange::named("a", Operation::Add))).unwrap();
            cell.attach(hold("", remove("a"))).unwrap();
            assert_eq!(cell.names(), ["a"]);
        },
    ];
    for (i, change) in changes.into_iter().enumerate() {
        let mut cell = Cell::new();
        set(&mut cell);
        change(&mut cell);
        assert_eq!(velocities(&cell), [], "change {i}");
        // an object with this name that comes later rests
        if cell.names().is_empty() {
            cell.object(add("a", "", at(5.0, 0.0, 0.0))).unwrap();
        }
        assert_eq!(velocities(&cell), [], "change {i}");
    }
    let mut cell = Cell::new();
    set(&mut cell);
    let append = ObjectChange { operation: Operation::Append, ..add("a", "", Pose::identity()) };
    cell.object(append).unwrap();
    assert_eq!(velocities(&cell).len(), 1, "its pose is the same");
}

/// The root turns under an obstacle: its velocity in the room stays the same.
#[test]
fn a_velocity_stays_the_same_in_the_room() {
    let mut cell = Cell::new();
    let turn = |cell: &mut Cell, yaw: f64| {
        let pose_pf = clearance_geometry::math::pose_from_xyz_rpy([0.0; 3], [0.0, 0.0, yaw]);
        let stamp = Some(seconds(99.9 + 1e-3 * yaw));
        cell.transforms.insert("base", Transform { parent: "map".to_owned(), pose_pf, stamp });
        let context = SceneContext::new(&cell.robot, None, &cell.transforms, Some(seconds(100.0)), 1.0);
        cell.scene.follow_anchor_frames(&context)
    };
    turn(&mut cell, 0.0);
    cell.object(add("a", "map", at(5.0, 0.0, 0.0))).unwrap();
    cell.apply(&states(vec![state("a", "map", turned(0.7), [1.0, 0.0, 0.0])])).unwrap();
    assert!(turn(&mut cell, std::f64::consts::FRAC_PI_2));
    assert_eq!(velocities(&cell), [("a", [0.0, -1.0, 0.0])]);
}

#[test]
fn states_of_nothing_are_rejected_by_name() {
    let mut cell = Cell::new();
    cell.object(add("a", "", at(5.0, 0.0, 0.0))).unwrap();
    cell.attach(hold("flange", add("held", "flange", at(0.0, 0.0, 0.0)))).unwrap();
    let one = |id: &str, frame: &str| states(vec![state(id, frame, Pose::identity(), [1.0, 0.0, 0.0])]);
    for (id, frame, named) in [
        ("b", "", "the world has no such obstacle"),
        ("held", "", "it is attached to link 'flange'"),
        ("hand", "", "the world has no such obstacle"),
        ("a", "nowhere", "header.frame_id"),
        ("a", "hand", "header.frame_id: 'hand' moves with the robot"),
    ] {
        cell.assert_rejected(&one(id, frame), Some(id), named);
    }
    cell.assert_rejected(&one("", ""), None, "id is empty");
    let twice =
        vec![state("a", "", at(6.0, 0.0, 0.0), [0.0; 3]), state("a", "", at(7.0, 0.0, 0.0), [0.0; 3])];
    let refusal = cell.apply(&states(twice)).unwrap_err();
    assert!(refusal.message.contains("twice"), "{refusal}");
    assert_eq!(cell.places("a"), [[6.0, 0.0, 0.0]]);
}
