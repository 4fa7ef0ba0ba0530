//! Tests that scene files and messages both behave like `MoveIt` 2, in cases where they once differed.

use super::*;

/// The scene of a file around the crane, whose hand is lifted by 3 m.
fn read(objects: &str) -> Result<SceneLoader, SceneError> {
    read_scene(&format!("world: {{collision_objects: [{objects}]}}"))
}

fn read_scene(fields: &str) -> Result<SceneLoader, SceneError> {
    let cell = Cell::new();
    let text =
        format!("is_diff: true\nrobot_state: {{joint_state: {{name: [lift], position: [3]}}}}\n{fields}");
    SceneLoader::from_yaml(&text, "a.yaml", &cell.robot, &MeshFiles::default())
}

const SPHERE: &str = "primitives: [{type: sphere, dimensions: [0.1]}]";

fn place_in_file(loader: &SceneLoader, id: &str) -> [f64; 3] {
    let object = loader.scene.world.obstacle_by_name(id).unwrap();
    object.placed_shapes().next().unwrap().0.translation.vector.into()
}

/// `World::setSubframesOfObject` replaces the subframes, also by an empty list.
#[test]
fn appending_replaces_the_subframes_of_an_object() {
    let mut cell = Cell::new();
    let with = |operation, subframe: &str| ObjectChange {
        operation,
        subframes: vec![(subframe.to_owned(), at(0.0, 0.0, 1.0))],
        ..add("a", "", at(1.0, 0.0, 0.0))
    };
    cell.object(with(Operation::Add, "old")).unwrap();
    cell.object(with(Operation::Append, "new")).unwrap();
    cell.refuses_object(add("p", "a/old", Pose::identity()), "unknown frame 'a/old'");
    cell.object(add("p", "a/new", Pose::identity())).unwrap();
    cell.object(ObjectChange { subframes: vec![], ..with(Operation::Append, "") }).unwrap();
    cell.refuses_object(add("p", "a/new", Pose::identity()), "unknown frame 'a/new'");

    let file = |subframe: &str| {
        read(&format!(
            "{{id: a, {SPHERE}, subframe_names: [old], subframe_poses: [{{}}]}}, {{id: a, operation: append, {SPHERE}}}, \
             {{id: p, header: {{frame_id: {subframe}}}, {SPHERE}}}"
        ))
    };
    assert!(file("a").is_ok());
    assert!(file("a/old").unwrap_err().message.contains("unknown frame 'a/old'"));
}

/// `processCollisionObjectRemove` returns false.
#[test]
fn removing_an_unknown_object_is_rejected() {
    Cell::new().refuses_object(remove("x"), "it can not be removed");
    let error = read("{id: x, operation: remove}").unwrap_err();
    assert_eq!(error.object.as_deref(), Some("x"));
    assert!(error.message.contains("it can not be removed"), "{error}");
}

/// `World::getTransform` treats any text after the name of an object and a slash as a subframe.
#[test]
fn names_of_objects_and_subframes_may_contain_slashes() {
    let shelf = |id: &str, subframe: &str, x: f64| ObjectChange {
        subframes: vec![(subframe.to_owned(), at(0.0, 0.0, 1.0))],
        ..add(id, "", at(x, 0.0, 0.0))
    };
    let mut cell = Cell::new();
    cell.object(shelf("shelf", "top/left", 1.0)).unwrap();
    cell.object(shelf("hall/shelf", "top", 2.0)).unwrap();
    cell.attach(hold("flange", shelf("tray", "rim/front", 0.5))).unwrap();
    for (frame, place) in [
        ("shelf/top/left", [1.0, 0.0, 1.0]),
        ("hall/shelf", [2.0, 0.0, 0.0]),
        ("hall/shelf/top", [2.0, 0.0, 1.0]),
        ("tray/rim/front", [0.5, 0.0, 1.0]),
    ] {
        cell.object(add("probe", frame, Pose::identity())).unwrap();
        assert_eq!(cell.places("probe"), [place], "{frame}");
    }
    let file = read(&format!(
        "{{id: shelf, {SPHERE}, subframe_names: [top/left], subframe_poses: [{{position: [0, 0, 1]}}]}}, \
         {{id: p, header: {{frame_id: shelf/top/left}}, {SPHERE}}}"
    ));
    assert_eq!(place_in_file(&file.unwrap(), "p"), [0.0, 0.0, 1.0]);
}

/// `RobotState::getFrameInfo` looks for the model frame first.
#[test]
fn the_planning_frame_comes_before_an_object_of_its_name() {
    let mut cell = Cell::new();
    cell.object(add("map", "", at(5.0, 0.0, 0.0))).unwrap();
    cell.object(add("probe", "map", at(0.0, 1.0, 0.0))).unwrap();
    assert_eq!(cell.places("probe"), [[0.0, 1.0, 0.0]]);
    let file = read(&format!(
        "{{id: map, pose: {{position: [5, 0, 0]}}, {SPHERE}}}, {{id: p, header: {{frame_id: map}}, {SPHERE}}}"
    ));
    assert_eq!(place_in_file(&file.unwrap(), "p"), [0.0; 3]);
}

/// `Transforms::setTransforms`: the child frame is the planning frame, and the header names the frame that is placed in it.
#[test]
fn fixed_frames_are_given_as_moveit_gives_them() {
    let frame = |name: &str, parent: &str| FixedFrame {
        name: name.to_owned(),
        parent: parent.to_owned(),
        pose_pf: at(0.0, 0.0, 2.0),
    };
    let mut cell = Cell::new();
    let unnamed = FixedFrame { pose_pf: Pose::identity(), ..frame("map", "") };
    let itself = FixedFrame { pose_pf: Pose::identity(), ..frame("map", "map") };
    let frames = vec![unnamed, itself, frame("map", "camera"), frame("tf", "camera")];
    cell.scene(SceneChange { fixed_frames: frames, ..difference(vec![], vec![]) }).unwrap();
    for (name, z) in [("map", 0.0), ("camera", 2.0), ("tf", 4.0)] {
        cell.object(add("probe", name, Pose::identity())).unwrap();
        assert_eq!(cell.places("probe"), [[0.0, 0.0, z]], "{name}");
    }
    // in MoveIt, too, the root link is not the planning frame of a robot with a virtual joint
    for (frame, why) in [
        (frame("base", "lidar"), "it is a link of the robot"),
        (frame("hand", "map"), "it is a link of the robot"),
        (frame("map", "base"), "it is a link of the robot"),
        (frame("tf", "tf"), "it is placed in itself"),
        (frame("map", "map"), "it is placed in itself"),
    ] {
        let change = SceneChange { fixed_frames: vec![frame], ..difference(vec![], vec![]) };
        let rejection = cell.scene(change).unwrap_err();
        assert!(rejection.message.contains(why), "{rejection}");
    }
    let file = read_scene(&format!(
        "fixed_frame_transforms: [{{header: {{frame_id: camera}}, child_frame_id: map, transform: {{translation: [0, 0, 2]}}}}]\n\
         world: {{collision_objects: [{{id: p, header: {{frame_id: camera}}, {SPHERE}}}]}}"
    ));
    assert_eq!(place_in_file(&file.unwrap(), "p"), [0.0, 0.0, 2.0]);
}

/// `Transforms::setTransforms` adds to the existing frames; rejected frames are removed.
#[test]
fn fixed_frames_are_added_to_those_that_are_known() {
    let frame = |name: &str, parent: &str| FixedFrame {
        name: name.to_owned(),
        parent: parent.to_owned(),
        pose_pf: at(0.0, 0.0, 2.0),
    };
    let with = |frames| SceneChange { fixed_frames: frames, ..difference(vec![], vec![]) };
    let mut cell = Cell::new();
    cell.scene(with(vec![frame("a", "base"), frame("b", "base")])).unwrap();
    cell.scene(with(vec![frame("c", "base")])).unwrap();
    cell.scene(with(vec![frame("b", "nowhere")])).unwrap_err();
    let unreadable_frames = vec!["c".to_owned()];
    cell.scene(SceneChange { unreadable_frames, ..with(vec![]) }).unwrap();
    cell.object(add("probe", "a", Pose::identity())).unwrap();
    for gone in ["b", "c"] {
        cell.refuses_object(add("probe", gone, Pose::identity()), "unknown frame");
    }
}

/// `Transforms::setTransform` ignores such an entry with an error in the log.
#[test]
fn a_frame_in_itself_at_zero_removes_the_frame() {
    let frame = |name: &str, parent: &str, z| FixedFrame {
        name: name.to_owned(),
        parent: parent.to_owned(),
        pose_pf: at(0.0, 0.0, z),
    };
    let with = |frames| SceneChange { fixed_frames: frames, ..difference(vec![], vec![]) };
    let mut cell = Cell::new();
    cell.scene(with(vec![frame("a", "base", 2.0), frame("b", "base", 2.0)])).unwrap();
    cell.scene(with(vec![frame("a", "a", 0.0), frame("c", "c", 0.0)])).unwrap();
    cell.refuses_object(add("probe", "a", Pose::identity()), "unknown frame 'a'");
    cell.object(add("probe", "b", Pose::identity())).unwrap();
}

/// `Transforms::setTransform` accepts only frames in the planning frame: a frame that moves with the robot is not fixed.
#[test]
fn a_fixed_frame_does_not_move_with_the_robot() {
    let error =
        read_scene("fixed_frame_transforms: [{header: {frame_id: hand}, child_frame_id: camera}]\nworld: {}");
    assert!(error.unwrap_err().message.contains("its parent 'hand' moves with the robot"));
}

/// `processAttachedCollisionObjectMsg`: only ADD without shapes removes the object from the world.
#[test]
fn appending_leaves_an_object_where_it_is_and_says_so() {
    let appended = |place: &str| {
        format!(
            "{{id: a, header: {{frame_id: base}}, pose: {{position: [1, 0, 0]}}, {SPHERE}}}, {{id: a, operation: append, {place} {SPHERE}}}"
        )
    };
    for (place, is_told) in [
        ("", false),
        ("header: {frame_id: base}, pose: {position: [1, 0, 0]},", false),
        ("header: {frame_id: base},", true),
        ("pose: {position: [5, 0, 0]},", true),
    ] {
        let warnings = read(&appended(place)).unwrap().warnings;
        assert_eq!(
            warnings.iter().any(|text| text.contains("'a' stays where it is")),
            is_told,
            "{place}: {warnings:?}"
        );
    }
    assert!(read(&appended("header: {frame_id: nowhere},")).unwrap_err().message.contains("nowhere"));
}

#[test]
fn appending_to_nothing_takes_no_object_from_the_world() {
    let mut cell = Cell::new();
    cell.object(add("a", "", Pose::identity())).unwrap();
    cell.refuses_attached(hold("hand", ObjectChange::named("a", Operation::Append)), "no shapes are given");
    let error = read_scene(&format!(
        "robot_state: {{attached_collision_objects: [{{link_name: hand, object: {{id: a, operation: append}}}}]}}\n\
         world: {{collision_objects: [{{id: a, {SPHERE}}}]}}"
    ));
    assert!(error.is_err());
}

/// `processOctomapMsg` accepts trees of type `OcTree`; an id without data removes the octomap.
#[test]
fn octomaps_of_messages_and_files_are_the_same() {
    let message = |id, data| OctomapMessage { id, binary: true, resolution: 0.1, data };
    assert!(
        message("ColorOcTree", &[1, 0])
            .placed(String::new(), Pose::identity(), false)
            .unwrap_err()
            .contains("'ColorOcTree'")
    );
    assert!(message("OcTree", &[]).placed(String::new(), Pose::identity(), false).unwrap().shape.is_none());
    let octomap = |id: &str| {
        read_scene(&format!(
            "octomap: {{octomap: {{binary: true, id: {id}, resolution: 0.1, data: [-128, 0]}}}}"
        ))
    };
    assert!(octomap("OcTree").unwrap().scene.world.id(OCTOMAP).is_some());
    assert!(octomap("ColorOcTree").unwrap_err().message.contains("'ColorOcTree'"));
    let mut loader = octomap("OcTree").unwrap();
    let gone = "is_diff: true\noctomap: {octomap: {id: OcTree}}";
    loader.read_yaml(gone, "b.yaml", &Cell::new().robot, &MeshFiles::default()).unwrap();
    assert!(loader.scene.world.id(OCTOMAP).is_none());
}

/// In `MoveIt` the last one takes precedence, although the intended one is not known.
#[test]
fn what_is_given_twice_has_to_agree() {
    let mut cell = Cell::new();
    let sizes = |values: &[f64]| values.iter().map(|value| ("hand".to_owned(), *value)).collect::<Vec<_>>();
    cell.scene(SceneChange { link_padding: sizes(&[0.2, 0.2]), ..difference(vec![], vec![]) }).unwrap();
    let twice = SceneChange { link_padding: sizes(&[4.0, 0.1]), ..difference(vec![], vec![]) };
    assert!(cell.scene(twice).unwrap_err().message.contains("as 4.0 and as 0.1"));
    let frame = |z| FixedFrame { name: "f".into(), parent: "base".into(), pose_pf: at(0.0, 0.0, z) };
    let twice = SceneChange { fixed_frames: vec![frame(1.0), frame(2.0)], ..difference(vec![], vec![]) };
    assert!(cell.scene(twice).unwrap_err().message.contains("at two places"));
    cell.refuses_object(add("x", "f", Pose::identity()), "unknown frame 'f'");
    let mut defaults = entries(&["hand"], true);
    (defaults.default_entry_names, defaults.default_entry_values) = (vec!["a".into(); 2], vec![false, true]);
    let twice = SceneChange { matrix: defaults, ..difference(vec![], vec![]) };
    assert!(cell.scene(twice).unwrap_err().message.contains("'a' twice"));
}

#[test]
fn subframes_given_twice_have_to_agree() {
    let mut cell = Cell::new();
    let with = |poses: [Pose; 2]| ObjectChange {
        subframes: poses.map(|pose| ("grip".to_owned(), pose)).into(),
        ..add("a", "", Pose::identity())
    };
    cell.refuses_object(with([at(1.0, 0.0, 0.0), at(2.0, 0.0, 0.0)]), "'grip' is given twice, at two places");
    cell.refuses_attached(
        hold("hand", with([at(1.0, 0.0, 0.0), at(2.0, 0.0, 0.0)])),
        "'grip' is given twice",
    );
    cell.object(with([at(1.0, 0.0, 0.0); 2])).unwrap();
}
