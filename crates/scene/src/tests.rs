//! Tests of scene updates: changes of objects, frames, link sizes and rejections, without a network; test helpers.

mod anchor_updates;
mod attached;
mod matrices;
mod moveit;
mod obstacle_states;
mod scene_messages;
mod transform_tree;

use std::sync::Arc;
use std::time::Duration;

use clearance_geometry::math::{Pose, Vector};
use clearance_geometry::{Primitive, Shape};
use clearance_robot::{LinkPoses, MeshFiles, RobotModel, RobotText};

use super::*;

/// A crane: the joint `lift` lifts the hand, 1 m beside the root; the flange never moves.
const URDF: &str = r#"<robot name="crane">
  <link name="base"/><link name="flange"/>
  <link name="hand"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="mount" type="fixed"><parent link="base"/><child link="flange"/><origin xyz="0 2 0"/></joint>
  <joint name="lift" type="prismatic">
    <parent link="base"/><child link="hand"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="9" effort="1" velocity="1"/>
  </joint>
</robot>"#;
const SRDF: &str = r#"<robot name="crane">
  <virtual_joint name="stand" type="fixed" parent_frame="map" child_link="base"/>
</robot>"#;

/// Position (m) of the joint `lift`.
const LIFTED: f64 = 3.0;

/// A robot whose hand is lifted by [`LIFTED`], a scene around it, and transforms.
struct Cell {
    robot: RobotModel,
    poses: Option<LinkPoses>,
    transforms: TransformTree,
    now: Time,
    scene: Scene,
}

impl Cell {
    fn new() -> Self {
        let text = RobotText { urdf: URDF, urdf_name: None, srdf: Some(SRDF), srdf_name: None };
        let robot = RobotModel::from_text(&text, &MeshFiles::default()).unwrap();
        let mut poses = LinkPoses::new(&robot);
        robot.forward_kinematics(&robot.configuration(&[LIFTED]).unwrap(), &mut poses);
        let (poses, scene) = (Some(poses), Scene::default());
        Self { robot, poses, transforms: TransformTree::default(), now: seconds(100.0), scene }
    }

    fn apply(&mut self, update: &SceneUpdate) -> Result<Vec<String>, SceneRejection> {
        let (poses, now) = (self.poses.as_ref(), Some(self.now));
        let lifted = self.robot.configuration(&[LIFTED]).unwrap();
        let context = SceneContext::new(&self.robot, poses, &self.transforms, now, 1.0)
            .at_configuration(poses.map(|_| &lifted));
        let applied = self.scene.apply(update, &context);
        match applied.refusals.into_iter().next() {
            None => Ok(applied.ineffective.into_iter().chain(applied.warnings).collect()),
            Some(refusal) => Err(refusal),
        }
    }

    fn object(&mut self, change: ObjectChange) -> Result<Vec<String>, SceneRejection> {
        self.apply(&SceneUpdate::Object(Box::new(change)))
    }

    fn attach(&mut self, change: AttachedChange) -> Result<Vec<String>, SceneRejection> {
        self.apply(&SceneUpdate::Attached(Box::new(change)))
    }

    fn scene(&mut self, change: SceneChange) -> Result<Vec<String>, SceneRejection> {
        self.apply(&SceneUpdate::Scene(Box::new(change)))
    }

    /// A rejected message names its error and changes nothing.
    fn assert_rejected(&mut self, update: &SceneUpdate, object: Option<&str>, named: &str) {
        let before = format!("{:?}", self.scene);
        let refusal = self.apply(update).unwrap_err();
        assert_eq!(refusal.object.as_deref(), object, "{refusal}");
        assert!(refusal.message.contains(named), "'{named}' is not in: {refusal}");
        assert_eq!(format!("{:?}", self.scene), before);
    }

    fn refuses_object(&mut self, change: ObjectChange, named: &str) {
        let id = Some(change.id.clone()).filter(|id| !id.is_empty());
        self.assert_rejected(&SceneUpdate::Object(Box::new(change)), id.as_deref(), named);
    }

    fn refuses_attached(&mut self, change: AttachedChange, named: &str) {
        let id = Some(change.object.id.clone()).filter(|id| !id.is_empty());
        self.assert_rejected(&SceneUpdate::Attached(Box::new(change)), id.as_deref(), named);
    }

    /// Poses of the shapes of an obstacle.
    fn places(&self, id: &str) -> Vec<[f64; 3]> {
        let object = self.scene.world.obstacle_by_name(id).unwrap();
        object.placed_shapes().map(|(pose, _)| pose.translation.vector.into()).collect()
    }

    fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.scene.world.obstacles().map(|o| o.name.as_str()).collect();
        names.sort_unstable();
        names
    }

    fn held(&self) -> Vec<&str> {
        self.scene.world.attached().iter().map(|o| o.name.as_str()).collect()
    }
}

fn seconds(seconds: f64) -> Time {
    #[expect(clippy::cast_possible_truncation, reason = "tests take minutes")]
    Time::from_nanoseconds((seconds * 1e9) as i64)
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

fn ball() -> Shape {
    Shape::Primitive(Primitive::sphere(0.1).unwrap())
}

fn placed(pose_os: Pose) -> ObstacleShape {
    ObstacleShape { pose_os, shape: ball() }
}

/// A ball at a place in a frame.
fn add(id: &str, frame: &str, pose_fo: Pose) -> ObjectChange {
    let shapes = vec![placed(Pose::identity())];
    ObjectChange { frame: frame.to_owned(), pose_fo, shapes, ..ObjectChange::named(id, Operation::Add) }
}

fn shift(id: &str, frame: &str, pose_fo: Pose) -> ObjectChange {
    ObjectChange { frame: frame.to_owned(), pose_fo, ..ObjectChange::named(id, Operation::Move) }
}

fn remove(id: &str) -> ObjectChange {
    ObjectChange::named(id, Operation::Remove)
}

fn hold(link: &str, object: ObjectChange) -> AttachedChange {
    AttachedChange { link: link.to_owned(), object, touch_links: Vec::new() }
}

fn difference(objects: Vec<ObjectChange>, attached: Vec<AttachedChange>) -> SceneChange {
    SceneChange {
        is_diff: true,
        robot_state: RobotStateChange { is_diff: true, attached, ..RobotStateChange::default() },
        world: WorldChange { objects, octomap: None },
        ..SceneChange::default()
    }
}

fn entries(names: &[&str], allowed: bool) -> MatrixEntries {
    MatrixEntries {
        entry_names: names.iter().map(|n| (*n).to_owned()).collect(),
        entry_values: vec![vec![allowed; names.len()]; names.len()],
        ..MatrixEntries::default()
    }
}

#[test]
fn objects_are_added_replaced_moved_and_removed() {
    let mut cell = Cell::new();
    cell.object(add("a", "", at(1.0, 0.0, 0.0))).unwrap();
    cell.object(add("b", "/base", at(2.0, 0.0, 0.0))).unwrap();
    assert_eq!(cell.names(), ["a", "b"]);
    let two = vec![placed(at(0.0, 1.0, 0.0)), placed(at(0.0, 2.0, 0.0))];
    cell.object(ObjectChange { shapes: two, ..add("a", "", at(5.0, 0.0, 0.0)) }).unwrap();
    assert_eq!(cell.places("a"), [[5.0, 1.0, 0.0], [5.0, 2.0, 0.0]]);
    cell.object(shift("a", "flange", at(0.0, 0.0, 1.0))).unwrap();
    assert_eq!(cell.places("a"), [[0.0, 3.0, 1.0], [0.0, 4.0, 1.0]]);
    let warned = cell.object(ObjectChange { operation: Operation::Move, ..add("a", "", at(0.0, 0.0, 0.0)) });
    assert!(warned.unwrap()[0].contains("'a'"));

    cell.object(remove("a")).unwrap();
    assert_eq!(cell.names(), ["b"]);
    cell.object(add("c", "", at(0.0, 0.0, 0.0))).unwrap();
    cell.object(remove("")).unwrap();
    assert!(cell.scene.world.is_empty());
}

/// As in `MoveIt`.
#[test]
fn an_only_shape_lends_a_new_object_its_pose() {
    let mut cell = Cell::new();
    for operation in [Operation::Add, Operation::Append] {
        let id = format!("{operation:?}");
        let shapes = vec![placed(at(0.0, 3.0, 0.0))];
        cell.object(ObjectChange { operation, shapes, ..add(&id, "", Pose::identity()) }).unwrap();
        let object = cell.scene.world.obstacle_by_name(&id).unwrap();
        assert_eq!((object.pose_ro, object.shapes[0].pose_os), (at(0.0, 3.0, 0.0), Pose::identity()));
    }
    // an existing object keeps its pose, and the shape its own
    let shapes = vec![placed(at(0.0, 4.0, 0.0))];
    let append = ObjectChange { shapes, operation: Operation::Append, ..add("Add", "", Pose::identity()) };
    cell.object(append).unwrap();
    assert_eq!(cell.places("Add"), [[0.0, 3.0, 0.0], [0.0, 7.0, 0.0]]);
}

/// As in `MoveIt`: the pose in the message has no effect.
#[test]
fn appended_shapes_are_in_the_frame_of_the_object() {
    let mut cell = Cell::new();
    let append = |id, pose_fo| ObjectChange { operation: Operation::Append, ..add(id, "", pose_fo) };
    cell.object(append("a", at(1.0, 0.0, 0.0))).unwrap();
    let more = ObjectChange {
        shapes: vec![placed(at(0.0, 7.0, 0.0))],
        subframes: vec![("top".to_owned(), at(0.0, 0.0, 2.0))],
        ..append("a", at(0.0, 0.0, 9.0))
    };
    cell.object(more).unwrap();
    assert_eq!(cell.places("a"), [[1.0, 0.0, 0.0], [1.0, 7.0, 0.0]]);
    cell.object(shift("a", "", at(2.0, 0.0, 0.0))).unwrap();
    assert_eq!(cell.places("a"), [[2.0, 0.0, 0.0], [2.0, 7.0, 0.0]]);
    cell.object(add("on_top", "a/top", at(0.0, 0.0, 0.0))).unwrap();
    assert_eq!(cell.places("on_top"), [[2.0, 0.0, 2.0]]);
}

#[test]
fn a_move_may_say_where_shapes_are() {
    let mut cell = Cell::new();
    let two = vec![placed(at(0.0, 1.0, 0.0)), placed(at(0.0, 2.0, 0.0))];
    cell.object(ObjectChange { shapes: two, ..add("a", "", at(5.0, 0.0, 0.0)) }).unwrap();
    let shape_poses = vec![at(0.0, 0.0, 1.0), at(0.0, 0.0, 2.0)];
    cell.object(ObjectChange { shape_poses, ..shift("a", "", at(6.0, 0.0, 0.0)) }).unwrap();
    assert_eq!(cell.places("a"), [[6.0, 0.0, 1.0], [6.0, 0.0, 2.0]]);
    let one = ObjectChange { shape_poses: vec![at(0.0, 0.0, 0.0)], ..shift("a", "", at(0.0, 0.0, 0.0)) };
    cell.refuses_object(one, "1 poses of shapes are given, but the object has 2 shapes");
}

#[test]
fn broken_object_changes_are_rejected_by_name() {
    let mut cell = Cell::new();
    cell.object(add("a", "", at(1.0, 0.0, 0.0))).unwrap();
    cell.scene.set_sensed("/cloud", Some(Obstacle::of_shape("/cloud", Pose::identity(), ball()))).unwrap();
    let bare = |id: &str, operation| ObjectChange::named(id, operation);
    for (change, named) in [
        (bare("x", Operation::Add), "no shapes"),
        (bare("a", Operation::Append), "no shapes"),
        (add("", "", at(0.0, 0.0, 0.0)), "id is empty"),
        (bare("", Operation::Move), "id is empty"),
        (add("hand", "", at(0.0, 0.0, 0.0)), "id: the robot has a link"),
        (add(OCTOMAP, "", at(0.0, 0.0, 0.0)), "belongs to what sensors see"),
        (add("/cloud", "", at(0.0, 0.0, 0.0)), "belongs to what sensors see"),
        (remove("/cloud"), "operation"),
        (remove(OCTOMAP), "clear_octomap"),
        (remove("x"), "operation: it can not be removed"),
        (shift("x", "", at(0.0, 0.0, 0.0)), "operation: it can not be moved"),
        (add("x", "nowhere", at(0.0, 0.0, 0.0)), "header.frame_id: unknown frame 'nowhere'"),
        (shift("a", "a/top", at(0.0, 0.0, 0.0)), "header.frame_id: unknown frame 'a/top'"),
    ] {
        cell.refuses_object(change, named);
    }
    cell.poses = None;
    cell.refuses_object(add("x", "hand", at(0.0, 0.0, 0.0)), "header.frame_id: link 'hand' moves");
    cell.object(add("x", "flange", at(0.0, 0.0, 0.0))).unwrap();
}

#[test]
fn frames_are_links_objects_fixed_frames_and_those_of_tf() {
    let mut cell = Cell::new();
    let fixed = |name: &str, parent: &str| FixedFrame {
        name: name.to_owned(),
        parent: parent.to_owned(),
        pose_pf: at(0.0, 0.0, 10.0),
    };
    let base = FixedFrame { pose_pf: Pose::identity(), ..fixed("base", "base") };
    let frames = vec![base, fixed("cell", "map"), fixed("shelf", "cell")];
    cell.scene(SceneChange { fixed_frames: frames, ..difference(vec![], vec![]) }).unwrap();
    let stamp = Some(seconds(99.5));
    for (frame, parent, stamp) in [
        ("camera", "hand", stamp),
        ("/optical", "/camera", None),
        ("map2", "shelf", None),
        ("base", "odom", stamp),
        ("odom", "world", stamp),
        ("tower", "world", None),
    ] {
        let transform = Transform { parent: parent.to_owned(), pose_pf: at(0.0, 1.0, 0.0), stamp };
        assert!(cell.transforms.insert(frame, transform));
    }
    cell.object(add("table", "base", at(4.0, 0.0, 0.0))).unwrap();
    for (frame, place) in [
        ("hand", [1.0, 0.0, 3.0]),
        ("map", [0.0, 0.0, 0.0]),
        ("cell", [0.0, 0.0, 10.0]),
        ("shelf", [0.0, 0.0, 20.0]),
        ("table", [4.0, 0.0, 0.0]),
        ("optical", [1.0, 2.0, 3.0]),
        ("map2", [0.0, 1.0, 20.0]),
        ("odom", [0.0, -1.0, 0.0]),
        ("tower", [0.0, -1.0, 0.0]),
    ] {
        cell.object(add("probe", frame, Pose::identity())).unwrap();
        assert_eq!(cell.places("probe"), [place], "{frame}");
    }
    // without a joint state the pose of the camera is only known from tf, relative to the hand
    cell.poses = None;
    cell.refuses_object(add("probe", "optical", Pose::identity()), "unknown frame 'optical'");
    let transform = Transform { parent: "flange".to_owned(), pose_pf: at(0.0, 0.0, 0.5), stamp };
    cell.transforms.insert("hand", transform);
    cell.object(add("probe", "optical", Pose::identity())).unwrap();
    assert_eq!(cell.places("probe"), [[0.0, 4.0, 0.5]]);
    // a present tf transform takes precedence over an earlier one from a scene
    let transform = Transform { parent: "odom".to_owned(), pose_pf: at(7.0, 0.0, 0.0), stamp };
    cell.transforms.insert("shelf", transform);
    cell.object(add("probe", "shelf", Pose::identity())).unwrap();
    assert_eq!(cell.places("probe"), [[7.0, -1.0, 0.0]]);
}

#[test]
fn old_transforms_say_nothing() {
    let mut cell = Cell::new();
    let transform = |stamp| Transform { parent: "base".to_owned(), pose_pf: at(0.0, 0.0, 1.0), stamp };
    cell.transforms.insert("old", transform(Some(seconds(98.0))));
    cell.refuses_object(add("x", "old", Pose::identity()), "transform of frame 'old' on tf is 2.000 s old");
    // a late transform does not replace a newer one
    cell.transforms.insert("old", transform(Some(seconds(99.5))));
    let late = Transform { pose_pf: at(9.0, 9.0, 9.0), ..transform(Some(seconds(99.4))) };
    cell.transforms.insert("old", late);
    cell.object(add("x", "old", Pose::identity())).unwrap();
    assert_eq!(cell.places("x"), [[0.0, 0.0, 1.0]]);
    // the stamp of another clock never becomes old
    for (lead, is_used) in [(0.5, true), (3600.0, false)] {
        let ahead = transform(Some(seconds(100.0 + lead)));
        cell.transforms.insert_received("ahead", ahead, Some(seconds(100.0)));
        if is_used {
            cell.object(add("x", "ahead", Pose::identity())).unwrap();
        } else {
            cell.refuses_object(add("x", "ahead", Pose::identity()), "3600.000 s in the future");
        }
    }
    // the search ends in a circle of frames
    for (frame, parent) in [("p", "q"), ("q", "p"), ("r", "r")] {
        cell.transforms.insert(frame, Transform { parent: parent.to_owned(), ..transform(None) });
        cell.refuses_object(add("y", frame, Pose::identity()), "unknown frame");
    }
}

#[test]
fn what_a_sensor_sees_takes_the_place_of_no_object() {
    let mut cell = Cell::new();
    cell.object(add("points", "", at(1.0, 0.0, 0.0))).unwrap();
    cell.attach(hold("hand", add("held", "hand", Pose::identity()))).unwrap();
    let seen = |name: &str| Some(Obstacle::of_shape(name, at(5.0, 0.0, 0.0), ball()));
    for name in ["points", "held"] {
        let refused = cell.scene.set_sensed(name, seen(name)).unwrap_err();
        assert!(refused.contains("name of this topic"), "{refused}");
        assert!(cell.scene.set_sensed(name, None).is_err());
        cell.scene.remove_sensed(name);
    }
    assert_eq!((cell.places("points"), cell.held()), (vec![[1.0, 0.0, 0.0]], vec!["held"]));
    cell.object(remove("points")).unwrap();
    cell.scene.set_sensed("points", seen("points")).unwrap();
    assert_eq!(cell.places("points"), [[5.0, 0.0, 0.0]]);
}

#[test]
fn sizes_of_links_and_fixed_frames_are_checked() {
    let mut cell = Cell::new();
    let sized = |link: &str, padding, scale| SceneChange {
        link_padding: vec![(link.to_owned(), padding)],
        link_scale: vec![(link.to_owned(), scale)],
        ..difference(vec![], vec![])
    };
    cell.scene(sized("hand", 0.02, 1.5)).unwrap();
    assert_eq!((cell.scene.link_padding["hand"], cell.scene.link_scale["hand"]), (0.02, 1.5));
    for (change, named) in [
        (sized("thumb", 0.1, 1.0), "link_padding: the robot has no link 'thumb'"),
        (sized("hand", -0.1, 1.5), "link_padding of 'hand' is -0.1"),
        (sized("hand", f64::NAN, 1.5), "link_padding of 'hand' is NaN"),
        (sized("hand", 0.02, 0.0), "link_scale of 'hand' is 0"),
        (sized("hand", 0.02, f64::INFINITY), "link_scale of 'hand' is inf"),
        (sized("hand", 0.02, 1e308), "link_scale of 'hand' is 1e308"),
    ] {
        cell.assert_rejected(&SceneUpdate::Scene(Box::new(change)), None, named);
    }
    for (name, parent, named) in [
        ("f", "hand", "its parent 'hand' moves with the robot"),
        ("f", "nowhere", "unknown frame 'nowhere'"),
        ("", "flange", "its name is empty"),
    ] {
        let frame = FixedFrame { name: name.into(), parent: parent.into(), pose_pf: Pose::identity() };
        let change = SceneChange { fixed_frames: vec![frame], ..difference(vec![], vec![]) };
        cell.assert_rejected(&SceneUpdate::Scene(Box::new(change)), None, named);
    }
}

#[test]
fn another_robot_keeps_what_it_can() {
    let mut cell = Cell::new();
    cell.object(add("thumb", "", Pose::identity())).unwrap();
    cell.attach(hold("hand", add("a", "hand", Pose::identity()))).unwrap();
    cell.attach(hold("flange", add("b", "flange", Pose::identity()))).unwrap();
    let sized = SceneChange {
        link_padding: vec![("hand".to_owned(), 0.1), ("flange".to_owned(), 0.2)],
        ..difference(vec![], vec![])
    };
    cell.scene(sized).unwrap();
    let other = RobotModel::from_urdf(&URDF.replace("\"hand\"", "\"thumb\""), &MeshFiles::default()).unwrap();
    let unfit = cell.scene.adapt_to_robot(&other);
    assert_eq!((unfit.dropped.len(), unfit.warnings.len()), (1, 2), "{unfit:?}");
    assert_eq!((cell.held(), cell.names()), (vec!["b"], vec!["thumb"]));
    assert!(unfit.warnings[0].starts_with("link_padding of 'hand' has no effect"), "{unfit:?}");
    // the padding holds again for a robot with this link
    assert_eq!((cell.scene.link_padding["hand"], cell.scene.link_padding["flange"]), (0.1, 0.2));
    assert!(cell.scene.adapt_to_robot(&cell.robot).warnings.is_empty());
    cell.scene(SceneChange::default()).unwrap();
    assert!(cell.scene.link_padding.is_empty());
}
