//! Tests of `monitored_planning_scene`: a node that applies the messages follows the published scene.

use std::collections::BTreeSet;

use clearance_scene::{AllowedCollisionMatrix, MatrixEntries};
use ros2_interfaces_jazzy_serde::moveit_msgs::msg::{LinkPadding, LinkScale};

use super::*;
use crate::scene::scene_message_reader::lacks_content;

/// A node that follows published messages.
struct Follower {
    scene: Scene,
    /// Parts of messages that it rejected.
    rejections: Vec<String>,
}

impl Follower {
    /// A follower that has this scene.
    fn of(scene: &Scene) -> Self {
        Self { scene: scene.clone(), rejections: Vec::new() }
    }

    fn receive(&mut self, message: &PlanningScene) {
        let (robot, transforms) = (robot(), TransformTree::default());
        let mut poses = LinkPoses::new(&robot);
        robot.forward_kinematics(&robot.configuration(&STRETCHED).unwrap(), &mut poses);
        let context = SceneContext::new(&robot, Some(&poses), &transforms, None, 1.0);
        let read = scene_change(message, false);
        let applied = self.scene.apply(&SceneUpdate::Scene(Box::new(read.change)), &context);
        let rejected = read.rejections.iter().chain(&applied.refusals);
        self.rejections.extend(rejected.map(ToString::to_string));
    }

    fn receive_all(&mut self, messages: &[PlanningScene]) {
        for message in messages {
            self.receive(message);
        }
    }

    fn names(&self) -> BTreeSet<String> {
        self.scene.world.obstacles().map(|object| object.name.clone()).collect()
    }

    fn matrix(&self) -> &AllowedCollisionMatrix {
        self.scene.matrix.as_ref().unwrap()
    }
}

/// All of a scene, for a follower of which nothing is known.
fn complete(scene: &ActiveScene) -> Vec<PlanningScene> {
    monitored_scene::complete(&KnownNames::default(), None, scene)
}

/// Balls whose messages do not fit into one.
fn balls(name: &str) -> Vec<CollisionObject> {
    (0..1500).map(|i| ball(&format!("{name} {i}"), at(f64::from(i), 0.0, 5.0), 0.1, "")).collect()
}

/// A mesh that does not fit into a message.
fn fine_mesh() -> Mesh {
    let vertex = |i: u32| Point { x: f64::from(i / 2) * 0.01, y: f64::from(i % 2), z: 0.0 };
    let triangles = (0..6000).map(|i| MeshTriangle { vertex_indices: [i, i + 1, i + 2] });
    Mesh { vertices: (0..6002).map(vertex).collect(), triangles: triangles.collect() }
}

fn shapes_too_large(id: &str) -> CollisionObject {
    let mut object = ball(id, at(3.0, 0.0, 0.0), 0.1, "");
    (object.meshes, object.mesh_poses) = (vec![fine_mesh()], vec![at(0.0, 0.0, 0.0)]);
    (object.planes, object.plane_poses) =
        (vec![Plane { coef: [0.0, 0.0, 1.0, 9.0] }], vec![at(0.0, 0.0, 0.0)]);
    object
}

fn allowing(names: &[&str], default_names: &[&str]) -> AllowedCollisionMatrix {
    let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<String>>();
    let entries = MatrixEntries {
        entry_names: owned(names),
        entry_values: vec![vec![true; names.len()]; names.len()],
        default_entry_names: owned(default_names),
        default_entry_values: vec![true; default_names.len()],
    };
    AllowedCollisionMatrix::from_entries(&entries).unwrap()
}

fn with_matrix(mut scene: Scene, matrix: AllowedCollisionMatrix) -> Arc<ActiveScene> {
    scene.matrix = Some(matrix);
    in_force(scene, vec![])
}

#[test]
fn a_follower_of_a_large_scene_never_has_less_than_before() {
    let first = in_force(scene(&[difference(balls("old"), vec![])]), vec![]);
    let second = in_force(scene(&[difference(balls("new"), vec![part()])]), vec![]);
    let names = |scene: &ActiveScene| -> BTreeSet<String> {
        scene.scene.world.obstacles().map(|object| object.name.clone()).collect()
    };
    let mut follower = Follower::of(&Scene::default());
    follower.receive_all(&complete(&first));
    assert_eq!(follower.names(), names(&first));

    // all of it again, although nothing has changed
    let again = monitored_scene::complete(&KnownNames::of(&first), Some(&first), &first);
    assert!(again.len() > 1);
    for message in &again {
        follower.receive(message);
        assert_eq!(follower.names(), names(&first));
    }
    // all obstacles are replaced: the old ones stay until the new ones are there
    let changes = monitored_scene::differences(&first, &second);
    let replaced = monitored_scene::complete(&KnownNames::of(&first), Some(&first), &second);
    for messages in [changes, replaced] {
        let mut follower = Follower::of(&first.scene);
        for message in &messages {
            follower.receive(message);
            let has = follower.names();
            assert!(has.is_superset(&names(&first)) || has.is_superset(&names(&second)));
        }
        assert_eq!(follower.names(), names(&second));
        assert_eq!(follower.scene.world.attached().len(), 1);
        assert_eq!(follower.rejections, [""; 0]);
    }
}

#[test]
fn small_scenes_are_published_whole() {
    let scene = scene(&[difference(vec![ball("a", at(2.5, 0.0, 0.0), 0.1, "")], vec![part()])]);
    let [message] = &complete(&in_force(scene, vec![]))[..] else { panic!("several messages") };
    assert!(!message.is_diff && message.robot_model_name == "two_link");
}

#[test]
fn an_object_is_released_before_it_is_added_again_and_removed_last() {
    let mut held = part();
    held.object.id = "other".to_owned();
    let first = in_force(scene(&[difference(balls("old"), vec![part(), held])]), vec![]);
    let mut objects = balls("new");
    objects.push(ball("part", at(0.0, 4.0, 0.0), 0.05, ""));
    let second = in_force(scene(&[difference(objects, vec![])]), vec![]);
    let mut follower = Follower::of(&first.scene);
    let messages = monitored_scene::differences(&first, &second);
    follower.receive(&messages[0]);
    let part = follower.scene.world.obstacle_by_name("part").unwrap();
    assert!(part.pose_ro.translation.y == 4.0 && follower.names().contains("other"));
    follower.receive_all(&messages[1..]);
    assert_eq!((follower.names().len(), follower.names().contains("other")), (1501, false));
    assert_eq!(follower.rejections, [""; 0]);
}

#[test]
fn content_that_is_too_large_is_rejected_as_a_whole() {
    let small = || ball("a", at(5.0, 0.0, 0.0), 0.1, "");
    let [large, without] = [vec![shapes_too_large("cell"), small()], vec![small()]]
        .map(|objects| in_force(scene(&[difference(objects, vec![])]), vec![]));
    for messages in [complete(&large), monitored_scene::differences(&without, &large)] {
        let mut follower = Follower::of(&without.scene);
        assert!(messages.iter().all(|message| message.is_diff) && messages.iter().any(lacks_content));
        follower.receive_all(&messages);
        let [rejection] = &follower.rejections[..] else { panic!("{:?}", follower.rejections) };
        assert!(rejection.contains("'cell'") && rejection.contains("no shapes"), "{rejection}");
        assert_eq!(follower.names(), BTreeSet::from(["a".to_owned()]));
    }
    // a follower that has it from the service keeps it
    let mut follower = Follower::of(&large.scene);
    let again = monitored_scene::complete(&KnownNames::of(&large), Some(&large), &large);
    assert!(again.iter().all(|message| message.is_diff) && !again.iter().any(lacks_content));
    follower.receive_all(&again);
    assert_eq!(follower.rejections, [""; 0]);
    assert_eq!(follower.scene.world.obstacle_by_name("cell").unwrap().shapes.len(), 3);
}

#[test]
fn a_held_object_that_is_too_large_is_not_taken_from_the_world() {
    let free = scene(&[difference(vec![ball("part", at(5.0, 0.0, 0.0), 0.1, "")], vec![])]);
    let mut held = part();
    held.object = shapes_too_large("part");
    held.object.header.frame_id = "tip".to_owned();
    let [free, held] = [free, scene(&[difference(vec![], vec![held])])].map(|scene| in_force(scene, vec![]));
    let messages = monitored_scene::differences(&free, &held);
    assert!(messages.iter().any(lacks_content));
    let mut follower = Follower::of(&free.scene);
    follower.receive_all(&messages);
    let [rejection] = &follower.rejections[..] else { panic!("{:?}", follower.rejections) };
    assert!(rejection.contains("'part'") && rejection.contains("no shapes are given"), "{rejection}");
    assert_eq!((follower.names().len(), follower.scene.world.attached().len()), (1, 0));
    // a follower that has it from the service keeps it
    let mut follower = Follower::of(&held.scene);
    let again = monitored_scene::complete(&KnownNames::of(&held), Some(&held), &held);
    assert!(!again.iter().any(lacks_content));
    follower.receive_all(&again);
    assert_eq!((follower.rejections.len(), follower.scene.world.attached().len()), (0, 1));
}

#[test]
fn a_matrix_that_is_too_large_is_rejected() {
    let names: Vec<String> = (0..500).map(|i| format!("object {i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let [before, after] =
        [&["base", "tip"][..], &names[..]].map(|names| with_matrix(Scene::default(), allowing(names, &[])));
    let messages = monitored_scene::differences(&before, &after);
    let mut follower = Follower::of(&before.scene);
    follower.receive_all(&messages);
    assert!(messages.iter().any(lacks_content));
    let [rejection] = &follower.rejections[..] else { panic!("{:?}", follower.rejections) };
    assert!(rejection.contains("rows of entry_values"), "{rejection}");
    let again = monitored_scene::complete(&KnownNames::of(&after), Some(&after), &after);
    assert!(!again.iter().any(lacks_content));
}

#[test]
fn entries_of_objects_that_a_whole_scene_leaves_out_stay_with_followers() {
    let scene_with = |names: &[&str]| {
        scene(&[difference(names.iter().map(|id| ball(id, at(5.0, 0.0, 0.0), 0.1, "")).collect(), vec![])])
    };
    let matrix = || allowing(&["tip", "a"], &["a"]);
    let before = with_matrix(scene_with(&["a", "b"]), matrix());
    let after = with_matrix(scene_with(&["b"]), matrix());
    let mut follower = Follower::of(&before.scene);
    follower.receive_all(&monitored_scene::differences(&before, &after));
    assert_eq!(follower.names(), BTreeSet::from(["b".to_owned()]));
    assert!(follower.matrix().allows("tip", "a") && follower.matrix().allows_by_default("a"));
    // an object whose entries went with it
    let after = with_matrix(scene_with(&["b"]), allowing(&["tip", "base"], &[]));
    let messages = monitored_scene::differences(&before, &after);
    assert_eq!(messages.len(), 1);
    let mut follower = Follower::of(&before.scene);
    follower.receive_all(&messages);
    assert!(!follower.matrix().mentions("a"));
}

#[test]
fn a_matrix_without_entries_reaches_followers() {
    let allowed = with_matrix(Scene::default(), allowing(&["base", "tip"], &[]));
    for (matrix, allows_tip) in [(AllowedCollisionMatrix::default(), false), (allowing(&[], &["tip"]), true)]
    {
        let after = with_matrix(Scene::default(), matrix);
        for messages in [complete(&after), monitored_scene::differences(&allowed, &after)] {
            let mut follower = Follower::of(&allowed.scene);
            follower.receive_all(&messages);
            // the pairs of the SRDF are checked, too
            for (a, b, allows) in [("base", "tip", allows_tip), ("base", "upper", false)] {
                assert_eq!(follower.matrix().allows(a, b), allows, "{a} {b}");
            }
        }
    }
}

#[test]
fn paddings_and_scales_of_all_links_are_published() {
    // links without geometry may hold objects
    let tool = "<link name='tool0'/>
        <joint name='tool' type='fixed'><parent link='tip'/><child link='tool0'/></joint>";
    let urdf = URDF.replace("</robot>", &format!("{tool}</robot>"));
    let text = RobotText { urdf: &urdf, urdf_name: None, srdf: Some(SRDF), srdf_name: None };
    let robot = RobotModel::from_text(&text, &MeshFiles::default()).unwrap();
    let mut scene = Scene::default();
    let given = [("tool0", 0.1), ("tip", 0.0), ("base", 0.01)];
    scene.link_padding.extend(given.map(|(link, padding)| (link.to_owned(), padding)));
    scene.link_scale.insert("tool0".to_owned(), 2.0);
    let told =
        SceneMessages { robot: &robot, scene: &scene, padding: 0.02, configuration: None, octomap: None };
    let message = scene_message(&told, C::LINK_PADDING_AND_SCALING);
    let padding = |link_name: &str| {
        let of_link = |entry: &&LinkPadding| entry.link_name == link_name;
        message.link_padding.iter().find(of_link).unwrap().padding
    };
    // the parameter is the least padding of all links
    assert_eq!(["tool0", "tip", "base", "upper"].map(padding), [0.1, 0.02, 0.02, 0.02]);
    assert!(message.link_scale.contains(&LinkScale { link_name: "tool0".to_owned(), scale: 2.0 }));
    assert_eq!(message.link_scale.len(), robot.links().len());
}

#[test]
fn followers_lose_fixed_frames_that_a_whole_scene_removes() {
    let framed = |names: &[&str]| {
        let poses = names.iter().map(|name| ((*name).to_owned(), Pose::translation(0.0, 0.0, 1.0)));
        let mut scene = Scene::default();
        scene.fixed_frames.extend(poses);
        in_force(scene, vec![])
    };
    let (before, after) = (framed(&["cell", "shelf"]), framed(&["shelf"]));
    let mut follower = Follower::of(&before.scene);
    follower.receive_all(&monitored_scene::differences(&before, &after));
    assert_eq!(follower.scene.fixed_frames, after.scene.fixed_frames);
    assert_eq!(follower.rejections, [""; 0]);
}

#[test]
fn scenes_without_content_are_those_with_empty_objects_or_rows() {
    let empty = |operation| CollisionObject { id: "a".to_owned(), operation, ..CollisionObject::default() };
    let held = |operation| {
        let object = empty(operation);
        difference(vec![], vec![AttachedCollisionObject { object, ..AttachedCollisionObject::default() }])
    };
    let mut rows = difference(vec![], vec![]);
    rows.allowed_collision_matrix.entry_names.push("a".to_owned());
    for (message, expected) in [
        (difference(vec![empty(CollisionObject::ADD)], vec![]), true),
        (held(CollisionObject::APPEND), true),
        (rows, true),
        (difference(vec![empty(CollisionObject::MOVE), empty(CollisionObject::REMOVE)], vec![]), false),
        // an object is attached by its name
        (held(CollisionObject::ADD), false),
        (difference(vec![ball("a", at(0.0, 0.0, 0.0), 0.1, "")], vec![]), false),
    ] {
        assert_eq!(lacks_content(&message), expected, "{message:?}");
    }
}
