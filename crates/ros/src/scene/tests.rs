//! Tests of scene messages without a network: conversion to changes and back, and clouds of any layout.

use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Duration;

use clearance_geometry::math::Pose;
use clearance_geometry::{Primitive, Shape};
use clearance_monitor::{Now, Revision, Time, WorldSource};
use clearance_robot::{LinkPoses, MeshFiles, RobotModel, RobotText};
use clearance_scene::MeshModel;
use clearance_scene::Obstacle;
use clearance_scene::{Scene, SceneContext, SceneUpdate, TransformTree};
use ros2_interfaces_jazzy_serde::geometry_msgs::msg::{
    Point, Pose as PoseMessage, Quaternion, TransformStamped,
};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{
    AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneComponents as C,
};
use ros2_interfaces_jazzy_serde::octomap_msgs::msg::Octomap;
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::{PointCloud2, PointField};
use ros2_interfaces_jazzy_serde::shape_msgs::msg::{Mesh, MeshTriangle, Plane, SolidPrimitive};

use crate::parameters::parameter_set::Parameters;
use crate::scene::active_scene::ActiveScene;
use crate::scene::octomap_messages::octomap_placement;
use crate::scene::point_cloud_decoder::decode;
use crate::scene::scene_checker::checker_of;
use crate::scene::scene_message_reader::{object_change, scene_change};
use crate::scene::scene_message_writer::{SceneMessages, scene_message};
use crate::topics::monitored_scene::{self, KnownNames};

mod published_scenes;
mod world_sources;

const URDF: &str = include_str!("../../../../urdf/two_link/two_link.urdf");
const SRDF: &str = r#"<robot name="two_link">
  <group name="arm"><chain base_link="base" tip_link="tip"/></group>
  <group name="wrist"><joint name="joint2"/></group>
  <group name="empty"/>
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
  <disable_collisions link1="upper" link2="tip" reason="Adjacent"/>
</robot>"#;
/// Configurations: stretched; folded as far as it is free; tip on the base.
pub const STRETCHED: [f64; 2] = [0.0, 0.0];
pub const FOLDED: [f64; 2] = [0.0, 5.0 * PI / 6.0];
pub const ON_BASE: [f64; 2] = [0.0, PI];

fn robot() -> Arc<RobotModel> {
    let text = RobotText { urdf: URDF, urdf_name: None, srdf: Some(SRDF), srdf_name: None };
    Arc::new(RobotModel::from_text(&text, &MeshFiles::default()).unwrap())
}

/// A pose with an unset quaternion.
fn place(x: f64, y: f64, z: f64) -> PoseMessage {
    PoseMessage { position: Point { x, y, z }, orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 } }
}

pub fn at(x: f64, y: f64, z: f64) -> PoseMessage {
    PoseMessage { position: Point { x, y, z }, ..PoseMessage::default() }
}

pub fn solid(type_: u8, dimensions: &[f64]) -> SolidPrimitive {
    SolidPrimitive { type_, dimensions: dimensions.to_vec(), ..SolidPrimitive::default() }
}

pub fn ball(id: &str, pose: PoseMessage, radius: f64, frame: &str) -> CollisionObject {
    let mut message = CollisionObject { id: id.to_owned(), pose, ..CollisionObject::default() };
    frame.clone_into(&mut message.header.frame_id);
    message.primitives.push(solid(SolidPrimitive::SPHERE, &[radius]));
    message
}

/// An attached object that is inside the cube of the base when the arm is folded.
pub fn part() -> AttachedCollisionObject {
    AttachedCollisionObject {
        link_name: "tip".to_owned(),
        object: ball("part", at(1.0, 0.4, 0.0), 0.05, "tip"),
        touch_links: vec!["tip".to_owned()],
        ..AttachedCollisionObject::default()
    }
}

fn triangle() -> Mesh {
    let corner = |x, y| Point { x, y, z: 0.5 };
    Mesh {
        vertices: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)],
        triangles: vec![MeshTriangle { vertex_indices: [0, 1, 2] }],
    }
}

/// The scene after some messages, with the robot stretched out.
pub fn scene(messages: &[PlanningScene]) -> Scene {
    let (robot, transforms) = (robot(), TransformTree::default());
    let mut poses = LinkPoses::new(&robot);
    robot.forward_kinematics(&robot.configuration(&STRETCHED).unwrap(), &mut poses);
    let context = SceneContext::new(&robot, Some(&poses), &transforms, None, 1.0);
    let mut scene = Scene::default();
    for message in messages {
        let read = scene_change(message, false);
        assert_eq!(read.rejections, []);
        let applied = scene.apply(&SceneUpdate::Scene(Box::new(read.change)), &context);
        assert_eq!(applied.refusals, []);
    }
    scene
}

#[test]
fn names_without_end_are_rejected() {
    let robot = robot();
    let (transforms, mut poses) = (TransformTree::default(), LinkPoses::new(&robot));
    robot.forward_kinematics(&robot.configuration(&STRETCHED).unwrap(), &mut poses);
    let context = SceneContext::new(&robot, Some(&poses), &transforms, None, 1.0);
    let long = "n".repeat(2000);
    let mut held = part();
    held.object.id.clone_from(&long);
    let mut framed = difference(vec![], vec![]);
    framed
        .fixed_frame_transforms
        .push(TransformStamped { child_frame_id: long.clone(), ..TransformStamped::default() });
    for message in [
        difference(vec![ball(&long, at(5.0, 0.0, 0.0), 0.1, "")], vec![]),
        difference(vec![], vec![held]),
        framed,
    ] {
        let read = scene_change(&message, false);
        let mut scene = Scene::default();
        let applied = scene.apply(&SceneUpdate::Scene(Box::new(read.change)), &context);
        let refusals: Vec<_> = read.rejections.iter().chain(&applied.refusals).collect();
        assert_eq!(refusals.len(), 1);
        let words = refusals[0].to_string();
        assert!(
            words.contains("has 2000 bytes, more than the limit of 1024") && words.len() < 400,
            "{words}"
        );
        assert!(scene.world.is_empty());
    }
}

pub fn difference(objects: Vec<CollisionObject>, attached: Vec<AttachedCollisionObject>) -> PlanningScene {
    let mut message = PlanningScene { is_diff: true, ..PlanningScene::default() };
    message.robot_state.is_diff = true;
    message.robot_state.attached_collision_objects = attached;
    message.world.collision_objects = objects;
    message
}

pub fn in_force(scene: Scene, sources: Vec<WorldSource>) -> Arc<ActiveScene> {
    in_force_of(&robot(), scene, sources)
}

pub fn in_force_of(robot: &Arc<RobotModel>, scene: Scene, sources: Vec<WorldSource>) -> Arc<ActiveScene> {
    let parameters = Parameters::default();
    let checker = checker_of(robot, &scene, MeshModel::Surface, &parameters, None).unwrap();
    let revision = Arc::new(Revision { sources, ..Revision::new(checker, 1, 1) });
    Arc::new(ActiveScene { revision, scene, octomap: None, mesh_model: MeshModel::Surface, parameters })
}

#[test]
fn poses_of_objects_and_shapes_are_composed_as_in_moveit() {
    let mut message = ball("a", at(0.0, 0.0, 0.0), 0.1, "base");
    message.primitive_poses.push(at(1.0, 2.0, 3.0));
    message.pose = at(0.0, 0.0, 9.0);
    let change = object_change(&message).unwrap();
    assert_eq!((change.pose_fo.translation.z, change.shapes[0].pose_os.translation.z), (9.0, 3.0));
    // an unset quaternion is the identity; shapes without a pose have the pose of the object
    message.pose = place(0.0, 0.0, 0.0);
    message.primitives.push(solid(SolidPrimitive::CONE, &[0.4, 0.1]));
    let change = object_change(&message).unwrap();
    assert_eq!(change.pose_fo.translation.z, 0.0);
    assert_eq!(change.shapes.iter().map(|s| s.pose_os.translation.z).collect::<Vec<_>>(), [3.0, 0.0]);
}

#[test]
fn broken_objects_are_rejected_by_name_and_field() {
    type Break = fn(&mut CollisionObject);
    let broken: [(Break, &str); 13] = [
        (|o| o.operation = 9, "operation is 9"),
        (|o| o.pose.position.x = f64::NAN, "pose: "),
        (|o| o.pose.orientation.x = f64::INFINITY, "pose: "),
        (|o| o.primitives[0].dimensions = vec![0.1, 0.1], "primitive[0]: dimensions: sphere takes one"),
        (|o| o.primitives[0].dimensions = vec![-0.1], "radius is -0.1"),
        (|o| o.primitives[0].dimensions = vec![f64::NAN], "radius is NaN"),
        (|o| o.primitives[0].type_ = SolidPrimitive::PRISM, "type '5'"),
        (|o| o.primitive_poses = vec![PoseMessage::default(); 2], "primitive_poses: 2 poses for 1 shapes"),
        (|o| o.primitive_poses = vec![place(f64::INFINITY, 0.0, 0.0)], "primitive_poses[0]"),
        (|o| o.meshes.push(Mesh::default()), "mesh[0]"),
        (
            |o| {
                o.meshes
                    .push(Mesh { triangles: vec![MeshTriangle { vertex_indices: [0, 1, 9] }], ..triangle() });
            },
            "mesh[0]",
        ),
        (|o| o.planes.push(Plane { coef: [0.0, 0.0, 0.0, 1.0] }), "plane[0]: coef"),
        (|o| o.subframe_names.push("top".to_owned()), "subframe_poses: 0 poses for 1"),
    ];
    for (break_it, named) in broken {
        let mut message = ball("thing", at(1.0, 0.0, 0.0), 0.1, "base");
        break_it(&mut message);
        let refusal = object_change(&message).unwrap_err();
        assert_eq!(refusal.object.as_deref(), Some("thing"));
        assert!(refusal.message.contains(named), "'{named}' is not in: {refusal}");
    }
}

#[test]
fn a_published_scene_makes_the_same_scene() {
    let mut thing = ball("thing", at(3.0, 1.0, 0.0), 0.25, "base");
    thing.type_.key = "crate".to_owned();
    thing.primitives.extend([
        solid(SolidPrimitive::BOX, &[0.1, 0.2, 0.3]),
        solid(SolidPrimitive::CYLINDER, &[0.4, 0.1]),
        solid(SolidPrimitive::CONE, &[0.4, 0.1]),
    ]);
    thing.primitive_poses = [0.0, 1.0, 2.0, 3.0].map(|x| at(x, 0.0, 0.0)).to_vec();
    (thing.meshes, thing.mesh_poses) = (vec![triangle()], vec![at(0.0, 0.0, 0.5)]);
    (thing.planes, thing.plane_poses) =
        (vec![Plane { coef: [-1.0, 0.0, 0.0, 9.0] }], vec![at(0.0, 0.0, 0.0)]);
    (thing.subframe_names, thing.subframe_poses) = (vec!["hook".to_owned()], vec![at(0.0, 0.5, 0.0)]);
    let before = scene(&[difference(vec![thing.clone()], vec![part()])]);
    let robot = robot();
    let configuration = robot.configuration(&FOLDED).unwrap();
    let told = |scene| SceneMessages {
        robot: &robot,
        scene,
        padding: 0.01,
        configuration: Some(&configuration),
        octomap: None,
    };
    let message = scene_message(&told(&before), 0);
    assert_eq!(message.world.collision_objects, [thing]);
    assert_eq!(message.robot_state.joint_state.position, FOLDED);
    assert_eq!(message.robot_state.attached_collision_objects[0].touch_links, ["tip"]);
    assert_eq!(message.link_padding[0].padding, 0.01);
    let matrix = &message.allowed_collision_matrix;
    assert_eq!(matrix.entry_names, ["base", "tip", "upper"]);
    assert!(matrix.entry_values[0].enabled[2] && !matrix.entry_values[0].enabled[1]);
    let after = scene(&[difference(vec![ball("other", at(9.0, 0.0, 0.0), 1.0, "")], vec![]), message]);
    let (before, after) = (scene_message(&told(&before), 0), scene_message(&told(&after), 0));
    assert_eq!((before.world, before.robot_state), (after.world, after.robot_state));
}

#[test]
fn only_the_components_that_are_asked_for_are_reported() {
    let scene = scene(&[difference(vec![ball("a", at(2.5, 0.0, 0.0), 0.1, "")], vec![part()])]);
    let robot = robot();
    let told =
        SceneMessages { robot: &robot, scene: &scene, padding: 0.0, configuration: None, octomap: None };
    let get = |components| scene_message(&told, components);
    let named = get(C::WORLD_OBJECT_NAMES);
    assert_eq!(
        (named.world.collision_objects[0].id.as_str(), named.world.collision_objects[0].primitives.len()),
        ("a", 0)
    );
    assert_eq!((named.robot_model_name.as_str(), named.link_padding.len()), ("", 0));
    assert_eq!(get(C::SCENE_SETTINGS).robot_model_name, "two_link");
    assert!(get(C::ROBOT_STATE).robot_state.attached_collision_objects.is_empty());
    assert_eq!(get(C::ROBOT_STATE_ATTACHED_OBJECTS).robot_state.attached_collision_objects.len(), 1);
    assert_eq!(get(C::TRANSFORMS).fixed_frame_transforms[0].child_frame_id, "base");
    assert_eq!(get(C::OCTOMAP), PlanningScene::default());
}

#[test]
fn differences_of_scenes_lead_from_one_to_the_other() {
    let first = difference(
        vec![ball("a", at(2.5, 0.0, 0.0), 0.1, ""), ball("b", at(2.5, 1.0, 0.0), 0.1, "")],
        vec![part()],
    );
    let mut second = difference(vec![ball("c", at(3.5, 0.0, 0.0), 0.1, "")], vec![]);
    let gone = CollisionObject {
        id: "a".to_owned(),
        operation: CollisionObject::REMOVE,
        ..CollisionObject::default()
    };
    second.world.collision_objects.push(gone.clone());
    second.robot_state.attached_collision_objects = vec![AttachedCollisionObject {
        object: CollisionObject { id: "part".to_owned(), ..gone },
        ..AttachedCollisionObject::default()
    }];
    let (before, after) = (scene(std::slice::from_ref(&first)), scene(&[first.clone(), second]));
    // the same objects, shared in memory
    let mut shared = before.clone();
    let [before, after] = [before, after].map(|scene| in_force(scene, vec![]));
    let told = monitored_scene::differences(&before, &after);
    assert!(told.iter().all(|message| message.is_diff));
    let (robot, transforms) = (robot(), TransformTree::default());
    let mut poses = LinkPoses::new(&robot);
    robot.forward_kinematics(&robot.configuration(&STRETCHED).unwrap(), &mut poses);
    let context = SceneContext::new(&robot, Some(&poses), &transforms, None, 1.0);
    for message in &told {
        let change = scene_change(message, false).change;
        let applied = shared.apply(&SceneUpdate::Scene(Box::new(change)), &context);
        assert_eq!(applied.refusals, []);
    }
    let names = |scene: &Scene| {
        let mut names: Vec<String> = scene.world.obstacles().map(|o| o.name.clone()).collect();
        names.sort();
        (names, scene.world.attached().len())
    };
    assert_eq!(names(&shared), names(&after.scene));
    assert!(monitored_scene::differences(&after, &after).is_empty());

    // objects that do not fit into one message follow in others
    let many = (0..2000).map(|i| ball(&format!("thing {i}"), at(f64::from(i), 0.0, 5.0), 0.1, "")).collect();
    let many = in_force(scene(&[difference(many, vec![])]), vec![]);
    let complete = monitored_scene::complete(&KnownNames::default(), None, &many);
    assert!(complete.len() > 1 && complete.iter().all(|message| message.is_diff));
    assert_eq!(complete.iter().map(|message| message.world.collision_objects.len()).sum::<usize>(), 2000);
}

#[test]
fn an_object_that_a_link_held_and_that_is_gone_is_removed_by_subscribers() {
    let before = scene(&[difference(vec![], vec![part()])]);
    let mut follower = before.clone();
    let [before, after] = [before, Scene::default()].map(|scene| in_force(scene, vec![]));
    let told = monitored_scene::differences(&before, &after);
    let [message] = &told[..] else { panic!("{told:?}") };
    let [removal] = &message.world.collision_objects[..] else { panic!("{message:?}") };
    assert_eq!((removal.id.as_str(), removal.operation), ("part", CollisionObject::REMOVE));
    assert_eq!(message.robot_state.attached_collision_objects[0].object.operation, CollisionObject::REMOVE);

    let (robot, transforms) = (robot(), TransformTree::default());
    let mut poses = LinkPoses::new(&robot);
    robot.forward_kinematics(&robot.configuration(&STRETCHED).unwrap(), &mut poses);
    let context = SceneContext::new(&robot, Some(&poses), &transforms, None, 1.0);
    let change = scene_change(message, false).change;
    assert_eq!(follower.apply(&SceneUpdate::Scene(Box::new(change)), &context).refusals, []);
    assert!(follower.world.is_empty());
}

#[test]
fn an_object_that_only_moves_is_published_without_its_shapes() {
    let still = scene(&[difference(vec![ball("a", at(2.5, 0.0, 0.0), 0.1, "")], vec![])]);
    let mut moved = still.clone();
    let mut to = ball("a", at(2.5, 2.0, 0.0), 0.1, "");
    to.operation = CollisionObject::MOVE;
    to.primitives.clear();
    let (robot, transforms) = (robot(), TransformTree::default());
    let context = SceneContext::new(&robot, None, &transforms, None, 1.0);
    let change = scene_change(&difference(vec![to.clone()], vec![]), false).change;
    assert_eq!(moved.apply(&SceneUpdate::Scene(Box::new(change)), &context).refusals, []);

    let told = monitored_scene::differences(&in_force(still, vec![]), &in_force(moved, vec![]));
    let [message] = &told[..] else { panic!("{told:?}") };
    let [told] = &message.world.collision_objects[..] else { panic!("{message:?}") };
    assert_eq!((told.operation, told.primitives.len()), (CollisionObject::MOVE, 0));
    assert_eq!((&told.pose.position, &*told.header.frame_id), (&to.pose.position, "base"));
}

fn field(name: &str, offset: u32, datatype: u8) -> PointField {
    PointField { name: name.to_owned(), offset, datatype, count: 1 }
}

/// Two rows of two points with 4 bytes after each row; x as big-endian doubles, y and z as floats.
fn cloud() -> PointCloud2 {
    let points = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, f32::NAN, 9.0], [10.0, 11.0, 12.0_f32]];
    let mut data = Vec::new();
    for (i, [x, y, z]) in points.into_iter().enumerate() {
        data.push(0xaa);
        data.extend(z.to_be_bytes());
        data.extend(f64::from(x).to_be_bytes());
        data.extend(y.to_be_bytes());
        if i % 2 == 1 {
            data.extend([0xbb; 4]);
        }
    }
    PointCloud2 {
        height: 2,
        width: 2,
        fields: vec![field("z", 1, 7), field("x", 5, 8), field("intensity", 0, 2), field("y", 13, 7)],
        is_bigendian: true,
        point_step: 17,
        row_step: 38,
        data,
        ..PointCloud2::default()
    }
}

#[test]
fn clouds_of_any_layout_are_read() {
    let points = decode(&cloud()).unwrap();
    assert_eq!(points.points, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [10.0, 11.0, 12.0]]);
    assert_eq!(points.dropped, 1);
    // the last row needs no padding
    let mut short = cloud();
    short.data.truncate(38 + 34);
    assert_eq!(decode(&short).unwrap(), points);
    assert!(decode(&PointCloud2 { width: 0, data: vec![], ..cloud() }).unwrap().points.is_empty());
}

/// A cloud of floats.
fn cloud_of(points: &[[f32; 3]]) -> PointCloud2 {
    let width = u32::try_from(points.len()).unwrap();
    PointCloud2 {
        height: 1,
        width,
        fields: vec![field("x", 0, 7), field("y", 4, 7), field("z", 8, 7)],
        point_step: 12,
        row_step: 12 * width,
        data: points.iter().flatten().flat_map(|coordinate| coordinate.to_le_bytes()).collect(),
        ..PointCloud2::default()
    }
}

#[test]
fn zeros_that_stand_for_no_return_are_no_places_but_the_only_cell_of_a_map_there_is() {
    let decoded = |points: &[[f32; 3]]| {
        let points = decode(&cloud_of(points)).unwrap();
        (points.points, points.dropped)
    };
    let (place, near) = ([1.0, 0.0, 0.0], [0.0, 2e-6, 0.0]);
    assert_eq!(decoded(&[[0.0; 3], place, [0.0, -0.0, 1e-6], near]), (vec![place, near], 2));
    assert_eq!(decoded(&[[0.0; 3]; 1000]), (vec![], 1000));
    assert_eq!(decoded(&[[0.0; 3], place]), (vec![[0.0; 3], place], 0));
}

#[test]
fn broken_clouds_are_rejected_by_field() {
    type Break = fn(&mut PointCloud2);
    let broken: [(Break, &str); 9] = [
        (|c| c.fields.truncate(3), "no field 'y'"),
        (|c| c.fields[2].name = "x".to_owned(), "field 'x' is there twice"),
        (|c| c.fields[0].datatype = PointField::INT32, "field 'z' has datatype 5"),
        (|c| c.fields[3].offset = 14, "field 'y' at offset 14"),
        (|c| c.fields[3].offset = u32::MAX, "field 'y' at offset"),
        (|c| c.point_step = 0, "point_step"),
        (|c| c.row_step = 33, "row_step is 33"),
        (|c| c.width = u32::MAX, "row_step is 38"),
        (|c| c.data.truncate(60), "data has 60 bytes"),
    ];
    for (break_it, named) in broken {
        let mut message = cloud();
        break_it(&mut message);
        let fault = decode(&message).unwrap_err();
        assert!(fault.contains(named), "'{named}' is not in: {fault}");
    }
    assert!(decode(&PointCloud2 { width: u32::MAX, ..cloud() }).unwrap_err().contains("row_step"));
    assert!(decode(&PointCloud2 { height: u32::MAX, ..cloud() }).unwrap_err().contains("data has"));
}

#[test]
fn octomaps_are_trees_of_one_kind() {
    let map = |id: &str, data: Vec<i8>| Octomap {
        id: id.to_owned(),
        binary: true,
        resolution: 0.1,
        data,
        ..Octomap::default()
    };
    // the first child of the root is occupied
    let placed = octomap_placement(&map("OcTree", vec![0b10, 0]), false).unwrap();
    assert!(placed.shape.is_some());
    assert!(octomap_placement(&map("OcTree", vec![]), false).unwrap().shape.is_none());
    for (broken, named) in [
        (map("", vec![]), "type ''"),
        (map("ColorOcTree", vec![0b10, 0]), "'ColorOcTree'"),
        (map("OcTree", vec![0b01]), "byte"),
        (Octomap { resolution: 0.0, ..map("OcTree", vec![0b10, 0]) }, "resolution"),
    ] {
        let refusal = octomap_placement(&broken, false).unwrap_err();
        assert!(refusal.message.starts_with("octomap: ") && refusal.message.contains(named), "{refusal}");
    }
}

pub fn now() -> Now {
    Now { ros: Some(Time::from_nanoseconds(5)), steady: Duration::ZERO }
}

#[test]
fn a_robot_state_brings_the_positions_of_its_joints() {
    use crate::scene::scene_message_reader::{Converted, robot_state_change};
    let mut message = ros2_interfaces_jazzy_serde::moveit_msgs::msg::RobotState::default();
    message.joint_state.name = vec!["a".to_owned(), "b".to_owned()];
    message.joint_state.position = vec![1.0, 2.0];
    let Converted { change, rejections } = robot_state_change(&message);
    assert!(rejections.is_empty() && change.positions.fault.is_none());
    assert_eq!(change.positions.single, [("a".to_owned(), 1.0), ("b".to_owned(), 2.0)]);
    for count in [0, 1, 3] {
        message.joint_state.position = vec![1.0; count];
        let Converted { change, rejections } = robot_state_change(&message);
        assert!(rejections[0].message.contains("positions for 2 names") && change.positions.fault.is_some());
    }
}
