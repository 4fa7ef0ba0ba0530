//! Tests of anchors: obstacles, clouds and frames stay fixed in the world while the robot's root drives.

use super::*;

/// The robot's root drives along x relative to the `tf` frame `map`, or below `map` relative to `odom`.
fn drive(cell: &mut Cell, x: f64) -> bool {
    let transform = |parent: &str, x| Transform {
        parent: parent.to_owned(),
        pose_pf: at(x, 0.0, 0.0),
        stamp: Some(seconds(99.9 + 1e-3 * x)),
    };
    cell.transforms.insert("base", transform("odom", x));
    cell.transforms.insert("odom", Transform { stamp: None, ..transform("map", 0.0) });
    let is_due = cell.scene.anchor_frames(&cell.robot).are_elsewhere(&cell.transforms);
    let context = SceneContext::new(&cell.robot, None, &cell.transforms, Some(seconds(100.0)), 1.0);
    let moved = cell.scene.follow_anchor_frames(&context);
    assert!(is_due || !moved);
    assert!(!cell.scene.anchor_frames(&cell.robot).are_elsewhere(&cell.transforms));
    moved
}

#[test]
fn obstacles_stay_where_they_are_while_the_robot_drives() {
    let mut cell = Cell::new();
    // before any tf transform, poses in the parent of the virtual joint are those of a robot at zero
    cell.object(add("early", "map", at(5.0, 0.0, 0.0))).unwrap();
    cell.object(add("beside", "", at(7.0, 0.0, 0.0))).unwrap();
    assert!(drive(&mut cell, 1.0));
    assert_eq!(cell.places("early"), [[4.0, 0.0, 0.0]]);
    assert_eq!(cell.places("beside"), [[7.0, 0.0, 0.0]], "nobody knows where the root was before");
    cell.object(add("table", "odom", at(5.0, 0.0, 0.0))).unwrap();
    cell.object(add("crate", "base", at(2.0, 0.0, 0.0))).unwrap();
    cell.attach(hold("flange", add("part", "base", at(3.0, 0.0, 0.0)))).unwrap();
    assert!(!drive(&mut cell, 1.0 + 1e-6));
    assert!(drive(&mut cell, 2.0));
    let xs = |cell: &Cell| ["early", "beside", "table", "crate"].map(|name| cell.places(name)[0][0]);
    assert_eq!(xs(&cell), [3.0, 6.0, 3.0, 1.0]);
    // an attached object moves with its link, and stays in place after it is detached
    cell.attach(hold("", ObjectChange::named("part", Operation::Remove))).unwrap();
    assert_eq!(cell.places("part"), [[3.0, 0.0, 0.0]]);
    assert!(drive(&mut cell, 3.0));
    assert_eq!((xs(&cell), cell.places("part")[0][0]), ([2.0, 5.0, 2.0, 0.0], 2.0));
    // a moved obstacle stays at its new pose
    cell.object(shift("table", "hand", at(0.0, 0.0, 0.0))).unwrap();
    cell.object(remove("crate")).unwrap();
    assert!(drive(&mut cell, 4.0));
    assert_eq!(cell.places("table"), [[0.0, 0.0, 3.0]]);
    cell.object(remove("")).unwrap();
    assert!(!drive(&mut cell, 5.0));
}

/// The crane, below a frame relative to which its root may move.
fn on_wheels() -> Cell {
    let mut cell = Cell::new();
    let srdf = SRDF.replace("fixed", "planar");
    let text = RobotText { urdf: URDF, urdf_name: None, srdf: Some(&srdf), srdf_name: None };
    cell.robot = RobotModel::from_text(&text, &MeshFiles::default()).unwrap();
    cell
}

fn transform(parent: &str, x: f64, stamp: Option<f64>) -> Transform {
    Transform { parent: parent.to_owned(), pose_pf: at(x, 0.0, 0.0), stamp: stamp.map(seconds) }
}

fn is_lost(cell: &Cell) -> bool {
    cell.scene.anchor_frames(&cell.robot).root_pose_loss(&cell.transforms).is_some()
}

#[test]
fn what_stands_below_the_planning_frame_waits_for_the_root_to_be_found_there() {
    let mut cell = on_wheels();
    cell.transforms.insert("shelf", transform("map", 4.0, None));
    cell.object(add("box", "shelf", at(1.0, 0.0, 0.0))).unwrap();
    cell.object(add("lid", "box", at(0.0, 0.0, 1.0))).unwrap();
    assert_eq!(cell.places("lid"), [[5.0, 0.0, 1.0]]);
    assert!(!is_lost(&cell), "tf says nothing of the root");
    assert!(drive(&mut cell, 2.0));
    assert_eq!(cell.places("box"), [[3.0, 0.0, 0.0]]);
    assert_eq!(cell.places("lid"), [[3.0, 0.0, 1.0]]);
}

#[test]
fn frames_of_an_earlier_scene_stay_where_they_are() {
    let mut cell = Cell::new();
    drive(&mut cell, 1.0);
    let station =
        FixedFrame { name: "station".to_owned(), parent: "map".to_owned(), pose_pf: at(6.0, 0.0, 0.0) };
    cell.scene(SceneChange { fixed_frames: vec![station], ..difference(Vec::new(), Vec::new()) }).unwrap();
    cell.object(add("before", "station", at(0.0, 0.0, 0.0))).unwrap();
    assert!(drive(&mut cell, 3.0));
    cell.object(add("after", "station", at(0.0, 0.0, 0.0))).unwrap();
    assert_eq!(cell.places("before"), [[3.0, 0.0, 0.0]]);
    assert_eq!(cell.places("after"), [[3.0, 0.0, 0.0]]);
    // another scene does not contain them
    cell.scene(SceneChange::default()).unwrap();
    assert!(!drive(&mut cell, 5.0));
}

#[test]
fn clouds_stay_in_the_room_until_the_next_one() {
    let mut cell = Cell::new();
    drive(&mut cell, 1.0);
    let see = |cell: &mut Cell, x| {
        let cloud = Obstacle::of_shape("points".to_owned(), at(x, 0.0, 0.0), ball());
        cell.scene.set_sensed("points", Some(cloud)).unwrap();
        let context = SceneContext::new(&cell.robot, None, &cell.transforms, Some(seconds(100.0)), 1.0);
        cell.scene.anchor("points", "hand", &context);
    };
    see(&mut cell, 5.0);
    assert!(drive(&mut cell, 2.0));
    assert_eq!(cell.places("points"), [[4.0, 0.0, 0.0]]);
    see(&mut cell, 5.0);
    assert!(!drive(&mut cell, 2.0));
    assert_eq!(cell.places("points"), [[5.0, 0.0, 0.0]]);
    cell.scene.remove_sensed("points");
    assert!(!drive(&mut cell, 3.0));
    assert!(cell.scene.anchor_frames(&cell.robot).is_empty());
}

#[test]
fn a_world_that_goes_takes_its_frames_along() {
    let mut cell = Cell::new();
    drive(&mut cell, 1.0);
    cell.object(add("table", "map", at(5.0, 0.0, 0.0))).unwrap();
    assert!(!cell.scene.anchor_frames(&cell.robot).is_empty());
    cell.object(remove("table")).unwrap();
    assert!(cell.scene.anchor_frames(&cell.robot).is_empty());
    cell.object(add("table", "", at(5.0, 0.0, 0.0))).unwrap();
    cell.apply(&SceneUpdate::World(Box::default())).unwrap();
    assert!(cell.scene.anchor_frames(&cell.robot).is_empty());
}

#[test]
fn a_frame_that_tf_connects_with_the_root_no_more_is_lost() {
    let mut cell = Cell::new();
    drive(&mut cell, 1.0);
    cell.object(add("table", "map", at(5.0, 0.0, 0.0))).unwrap();
    assert!(!is_lost(&cell));
    cell.transforms.insert("odom", transform("elsewhere", 0.0, None));
    assert!(is_lost(&cell));
}

#[test]
fn a_root_that_tf_knows_elsewhere_only_is_lost_unless_it_never_moves() {
    for (mut cell, expected) in [(on_wheels(), true), (Cell::new(), false)] {
        cell.object(add("table", "map", at(5.0, 0.0, 0.0))).unwrap();
        assert!(!is_lost(&cell), "without tf the root is at zero");
        cell.transforms.insert("base", transform("odom", 1.0, Some(99.9)));
        assert_eq!(is_lost(&cell), expected);
        assert_eq!(cell.places("table"), [[5.0, 0.0, 0.0]]);
    }
}

/// A rotation of the root moves the origin of a distant frame by much, and points near the root by little.
#[test]
fn a_root_has_moved_by_as_much_as_it_moved_itself() {
    let mut cell = Cell::new();
    drive(&mut cell, 1e6);
    cell.object(add("table", "map", at(1e6 + 1.0, 0.0, 0.0))).unwrap();
    let mut turn = |angle| {
        let pose_pf = clearance_geometry::math::pose_from_xyz_rpy([1e6, 0.0, 0.0], [0.0, 0.0, angle]);
        cell.transforms.insert("base", Transform { parent: "odom".to_owned(), pose_pf, stamp: None });
        cell.scene.anchor_frames(&cell.robot).are_elsewhere(&cell.transforms)
    };
    assert!(!turn(1e-5));
    assert!(turn(1e-3));
}

#[test]
fn what_files_placed_stays_in_the_room_when_they_are_read_again() {
    let from_file = || {
        let mut cell = on_wheels();
        cell.object(add("table", "map", at(5.0, 0.0, 0.0))).unwrap();
        cell
    };
    let mut cell = from_file();
    drive(&mut cell, 1.0);
    assert!(drive(&mut cell, 4.0));
    let mut again = from_file().scene;
    let context = SceneContext::new(&cell.robot, None, &cell.transforms, Some(seconds(100.0)), 1.0);
    again.keep_anchors_of(&cell.scene, &context);
    cell.scene = again;
    drive(&mut cell, 4.0);
    assert_eq!(cell.places("table"), [[1.0, 0.0, 0.0]]);
    drive(&mut cell, 5.0);
    assert_eq!(cell.places("table"), [[0.0, 0.0, 0.0]]);
    // for a root that tf only connects to other frames, it stays where the file places it
    let mut elsewhere = from_file();
    elsewhere.transforms.insert("base", transform("yard", 1.0, Some(99.9)));
    let context = SceneContext::new(&cell.robot, None, &elsewhere.transforms, Some(seconds(100.0)), 1.0);
    let mut again = from_file().scene;
    again.keep_anchors_of(&cell.scene, &context);
    assert_eq!(again.anchor_frames(&cell.robot), elsewhere.scene.anchor_frames(&cell.robot));
}

#[test]
fn whether_a_frame_is_lost_is_decided_by_its_best_known_object() {
    let mut cell = Cell::new();
    drive(&mut cell, 1.0);
    cell.object(add("z", "map", at(5.0, 0.0, 0.0))).unwrap();
    cell.transforms.insert("odom", transform("elsewhere", 0.0, None));
    assert!(is_lost(&cell));
    cell.object(add("a", "map", at(5.0, 0.0, 0.0))).unwrap();
    assert!(is_lost(&cell), "where z is, nobody knows");
}

#[test]
fn frames_of_a_scene_before_hold_nothing_back() {
    let mut cell = on_wheels();
    let told = |name: &str| {
        let frame =
            FixedFrame { name: name.to_owned(), parent: "map".to_owned(), pose_pf: at(6.0, 0.0, 0.0) };
        SceneChange { fixed_frames: vec![frame], ..difference(Vec::new(), Vec::new()) }
    };
    cell.scene(told("station")).unwrap();
    cell.scene(told("another")).unwrap();
    cell.transforms.insert("base", transform("yard", 1.0, Some(99.9)));
    cell.transforms.insert("station", transform("yard", 3.0, Some(99.9)));
    cell.object(add("box", "station", at(0.0, 0.0, 0.0))).unwrap();
    assert!(!is_lost(&cell), "it stands in what tf tells of");
}

/// A chain of frames above the root, each received twice, and an obstacle beside the robot.
fn below_a_chain(frames: usize) -> Cell {
    let mut cell = Cell::new();
    cell.object(add("box", "", at(5.0, 0.0, 0.0))).unwrap();
    let name = |i| if i == 0 { "base".to_owned() } else { format!("f{i}") };
    for stamp in [99.8, 99.9] {
        for i in 0..frames {
            cell.transforms.insert(&name(i), transform(&name(i + 1), 1.0, Some(stamp)));
        }
    }
    cell
}

#[test]
fn a_chain_of_frames_is_followed_so_far_and_no_farther() {
    for (frames, found) in [(1, true), (250, true), (300, false), (9_000, false)] {
        let mut cell = below_a_chain(frames);
        assert!(drive_on(&mut cell), "the box stands in the topmost frame that is looked at");
        assert!(!drive_on(&mut cell));
        let anchor_frames = cell.scene.anchor_frames(&cell.robot);
        assert_eq!(
            anchor_frames.root_pose_loss(&cell.transforms),
            (!found).then_some(RootPoseLoss::Endless),
            "{frames} frames"
        );
        let told: Vec<TrackedFrame> = anchor_frames.tracked_frames(&cell.transforms).collect();
        let links = told.iter().flat_map(|told| told.path.live_links()).count();
        assert_eq!(links, frames.min(256));
    }
}

/// Far from the root, rounding of a pose exceeds the motion threshold.
#[test]
fn what_stands_far_away_is_put_once() {
    let mut cell = Cell::new();
    let up = Pose::new(Vector::new(1e8, -7e7, 3e7), Vector::new(0.3, 0.7, 0.2));
    for i in 0..100 {
        let link = Transform { parent: format!("f{}", i + 1), pose_pf: up, stamp: None };
        cell.transforms.insert(&format!("f{i}"), link);
    }
    cell.transforms.insert("base", transform("f0", 1.0, None));
    cell.object(add("box", "", at(5.0, 0.0, 0.0))).unwrap();
    assert!(!drive_on(&mut cell), "it stands where it was put");
    cell.transforms.insert("base", transform("f0", 2.0, None));
    assert!(drive_on(&mut cell));
    assert!(!drive_on(&mut cell));
    assert!((cell.places("box")[0][0] - 4.0).abs() < 0.1, "as exactly as the way tells");
}

#[test]
fn a_circle_of_frames_above_the_root_places_nothing() {
    let mut cell = Cell::new();
    cell.transforms.insert("base", transform("p", 1.0, None));
    cell.transforms.insert("p", transform("q", 1.0, None));
    cell.transforms.insert("q", transform("p", 1.0, None));
    assert!(!is_lost(&cell), "nothing stands anywhere");
    cell.object(add("box", "", at(5.0, 0.0, 0.0))).unwrap();
    assert!(is_lost(&cell));
    assert!(!drive_on(&mut cell) && is_lost(&cell));
    cell.transforms.insert("q", transform("map", 1.0, None));
    assert!(!is_lost(&cell));
}

/// Updates all anchored poses; returns true if an update was needed.
fn drive_on(cell: &mut Cell) -> bool {
    let is_due = cell.scene.anchor_frames(&cell.robot).are_elsewhere(&cell.transforms);
    let context = SceneContext::new(&cell.robot, None, &cell.transforms, Some(seconds(100.0)), 1.0);
    assert_eq!(cell.scene.follow_anchor_frames(&context), is_due);
    is_due
}

#[test]
fn a_planning_frame_far_below_the_root_does_not_count_as_where_the_root_is() {
    let mut cell = Cell::new();
    cell.object(add("early", "map", at(5.0, 0.0, 0.0))).unwrap();
    let name = |i| if i == 0 { "map".to_owned() } else { format!("f{i}") };
    for i in 0..300 {
        let parent = if i == 299 { "base".to_owned() } else { name(i + 1) };
        cell.transforms.insert(&name(i), transform(&parent, 1.0, None));
    }
    assert!(is_lost(&cell));
    cell.refuses_object(add("late", "map", at(5.0, 0.0, 0.0)), "unknown frame 'map'");
}

#[test]
fn a_frame_in_itself_places_nothing() {
    let mut cell = Cell::new();
    cell.object(add("box", "", at(5.0, 0.0, 0.0))).unwrap();
    cell.transforms.insert("/base", transform("base", 1.0, None));
    assert!(!is_lost(&cell));
}

/// The element that places a frame determines the motion of obstacles in it, also for a name with slashes, or a tf frame below a fixed
/// frame.
#[test]
fn obstacles_follow_what_places_their_frame() {
    let mut cell = Cell::new();
    drive(&mut cell, 1.0);
    let shelf = ObjectChange {
        subframes: vec![("top/left".to_owned(), at(0.0, 0.0, 1.0))],
        ..add("hall/shelf", "map", at(5.0, 0.0, 0.0))
    };
    cell.object(shelf).unwrap();
    let station =
        FixedFrame { name: "station".to_owned(), parent: "map".to_owned(), pose_pf: at(6.0, 0.0, 0.0) };
    cell.scene(SceneChange { fixed_frames: vec![station], ..difference(Vec::new(), Vec::new()) }).unwrap();
    cell.transforms.insert("camera", transform("station", 1.0, None));
    cell.object(add("on_top", "hall/shelf/top/left", Pose::identity())).unwrap();
    cell.object(add("seen", "camera", Pose::identity())).unwrap();
    let xs = |cell: &Cell| ["hall/shelf", "on_top", "seen"].map(|name| cell.places(name)[0][0]);
    assert_eq!(xs(&cell), [4.0, 4.0, 6.0]);
    assert!(drive(&mut cell, 3.0));
    assert_eq!(xs(&cell), [2.0, 2.0, 4.0]);
}

/// A fixed frame whose parent is below a moving link in tf moves with the robot, too.
#[test]
fn a_fixed_frame_below_a_link_that_moves_is_rejected_through_tf_too() {
    let mut cell = Cell::new();
    for (name, parent) in [("camera", "hand"), ("optical", "camera"), ("plate", "flange")] {
        cell.transforms.insert(name, transform(parent, 1.0, None));
    }
    let mut fix = |parent: &str| {
        let frame = FixedFrame { name: "f".to_owned(), parent: parent.to_owned(), pose_pf: Pose::identity() };
        cell.scene(SceneChange { fixed_frames: vec![frame], ..difference(Vec::new(), Vec::new()) })
    };
    for parent in ["hand", "camera", "/optical"] {
        assert!(fix(parent).unwrap_err().message.contains("moves with the robot"), "{parent}");
    }
    fix("plate").unwrap();
}
