//! Tests of contacts: `clearance check --contacts`, and contacts of robots with themselves and with meshes.

use std::path::Path;
use std::process::Output;
use std::sync::Arc;

use clearance::checker::{CollisionChecker, PairContacts, Question};
use clearance::geometry::math::{MatrixPose, Point, Pose};
use clearance::geometry::{Primitive, Shape, TriangleMesh};
use clearance::proximity::{CollisionBody, Scratch, distance};
use clearance::robot::{LinkPoses, MeshFiles, RobotModel};
use clearance::scene::{BodyId, Obstacle, Settings, World};
use serde_json::{Value, json};

use crate::program::{Folder, clearance};
use crate::random::Random;
use crate::streams::random_state;
use crate::tally::shared_folder;

const TWO_LINK: [&str; 2] = ["--urdf", "urdf/two_link/two_link.urdf"];
const FOLDED: [&str; 4] = ["--state", "joint2=3.141592653589793", "--format", "json"];

fn check(arguments: &[&str]) -> Output {
    clearance(&[&["check"], arguments].concat())
}

fn results(output: &Output) -> Value {
    let mut all: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {output:?}"));
    all["results"].take()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// The ball at the tip is in the middle of the cube of the base.
#[test]
fn the_program_prints_contacts() {
    let results = results(&check(&[&TWO_LINK[..], &FOLDED, &["--contacts", "3"]].concat()));
    assert_eq!(results[0]["pairs"], json!([["base", "tip"]]));
    let contacts = results[0]["contacts"].as_array().unwrap();
    assert!((1..=3).contains(&contacts.len()), "{contacts:?}");
    assert_eq!(contacts[0]["pair"], json!(["base", "tip"]));
    assert_eq!(contacts[0]["reason"], Value::Null);
    for bound in numbers(&contacts[0]["depth"]) {
        assert!((bound - 0.3).abs() < 1e-6, "{contacts:?}");
    }
    let text = check(&[&TWO_LINK[..], &FOLDED[..2], &["--contacts", "1"]].concat());
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.contains("  contact base – tip at (") && text.contains("depth 0.300000 m"), "{text}");
    let without = check(&[&TWO_LINK[..], &FOLDED, &["--query", "pairs"]].concat());
    assert!(
        serde_json::from_slice::<Value>(&without.stdout).unwrap()["results"][0].get("contacts").is_none()
    );
}

#[test]
fn contacts_need_all_pairs() {
    for arguments in [&["--contacts", "0"][..], &["--contacts", "2", "--query", "free"]] {
        let output = check(&[&TWO_LINK[..], &FOLDED, arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(output.stdout.is_empty());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(message.contains("--contacts"), "{message}");
    }
}

/// A mesh on an arm in a mesh and a box of the world: each contact of the program is in both bodies, and its normal points from the
/// first named body to the second.
#[test]
fn an_arm_with_meshes_has_contacts_in_a_world() {
    let folder = Folder::of(
        "<robot name='zebra'><link name='zebra'/><link name='arm'>\
         <collision><origin xyz='0 0 1'/><geometry><box size='0.4 0.2 0.1'/></geometry></collision></link>\
         <joint name='lift' type='prismatic'><parent link='zebra'/><child link='arm'/><axis xyz='0 0 1'/>\
         <limit lower='-2' upper='2' effort='1' velocity='1'/></joint></robot>",
        "world: {collision_objects: [{id: table, header: {frame_id: zebra}, pose: {position: {x: 0, y: 0, z: 0.4}, \
         orientation: {w: 1.0}}, primitives: [{type: 1, dimensions: [2.0, 2.0, 0.2]}], \
         primitive_poses: [{position: {x: 0, y: 0, z: 0}, orientation: {w: 1.0}}]}]}",
    );
    let of = |name: &str| folder.path(name).display().to_string();
    let (robot, world) = (of("r.urdf"), of("w.yaml"));
    let arguments = ["--urdf", &robot, "--world", &world, "--state", "lift=-0.452", "--format", "json"];
    let one = results(&check(&[&arguments[..], &["--contacts", "5"]].concat()));
    let contacts = one[0]["contacts"].as_array().unwrap();
    // 2 mm deep: its four corners and the deepest
    assert!((4..=5).contains(&contacts.len()), "{contacts:?}");
    for contact in contacts {
        assert_eq!(contact["pair"], json!(["arm", "table"]));
        assert!((numbers(&contact["normal"])[2] + 1.0).abs() < 1e-9, "{contact}");
        assert!(numbers(&contact["depth"]).iter().all(|depth| (depth - 0.002).abs() < 1e-6), "{contact}");
        let position = numbers(&contact["position"]);
        assert!((position[2] - 0.499).abs() < 1e-6, "{contact}");
    }
    for (x, y) in [(-0.2, -0.1), (0.2, -0.1), (-0.2, 0.1), (0.2, 0.1)] {
        let is_there = |contact: &Value| {
            let p = numbers(&contact["position"]);
            (p[0] - x).abs() < 1e-6 && (p[1] - y).abs() < 1e-6
        };
        assert!(contacts.iter().any(is_there), "{contacts:?}");
    }
}

/// A body of the robot or the world as a solid in the root frame, for distances of points.
fn solid(checker: &CollisionChecker, body: BodyId, poses: &LinkPoses) -> CollisionBody {
    let shapes: Vec<(Pose, Shape)> = match body {
        BodyId::Link(link) => {
            let collisions = checker.robot().link(link).collisions.iter();
            collisions.map(|c| (poses.pose(link) * c.pose_ls, c.shape.clone())).collect()
        }
        BodyId::Obstacle(id) => {
            let obstacle = checker.world().obstacle(id);
            obstacle.shapes.iter().map(|s| (obstacle.pose_ro * s.pose_os, s.shape.clone())).collect()
        }
        BodyId::Attached(_) => unreachable!("nothing is attached"),
    };
    CollisionBody::with_solid_meshes(shapes.iter().map(|(pose, shape)| (pose, shape))).unwrap()
}

fn distance_of_point(body: &CollisionBody, p: &Point, scratch: &mut Scratch) -> f64 {
    let point = Shape::Primitive(Primitive::Sphere { radius: 0.0 });
    let point = CollisionBody::with_solid_meshes([(&Pose::from(p.coords), &point)]).unwrap();
    distance(body, &point, MatrixPose::identity(), f64::INFINITY, scratch).unwrap().distance
}

/// Positions are in both bodies, normals have length one, and moving the second body along the first normal by its depth separates.
fn verify_contacts(checker: &CollisionChecker, states: u32, seed: u64) -> usize {
    let (mut random, mut scratch, mut workspace) =
        (Random::new(seed), Scratch::default(), checker.workspace());
    let robot = Arc::clone(checker.robot());
    let mut poses = LinkPoses::new(&robot);
    let mut number = 0;
    for _ in 0..states {
        let q = random_state(checker, &mut random);
        robot.forward_kinematics(&q, &mut poses);
        let report = checker.check(&q, Question::Pairs, &mut workspace);
        for &(a, b) in report.colliding_pairs.iter().take(20) {
            let PairContacts { deepest, others } = checker.contacts(&q, (a, b), 6, &mut workspace).unwrap();
            assert!(others.len() <= 5);
            let bodies = [a, b].map(|body| solid(checker, body, &poses));
            let names = format!("{} – {}", checker.body_name(a), checker.body_name(b));
            for point in others.iter().map(|contact| contact.point).chain([deepest.point]) {
                for body in &bodies {
                    let off = distance_of_point(body, &point, &mut scratch);
                    assert!(off <= 2e-8, "{names}: {off} {point:?} {deepest:?} {others:?}");
                }
            }
            assert!(others.iter().all(|contact| (contact.normal.norm() - 1.0).abs() < 1e-9), "{names}");
            assert_eq!(checker.contacts(&q, (a, b), 6, &mut checker.workspace()).unwrap().others, others);
            if let (Some(normal), Some(depth)) = (deepest.normal, deepest.depth) {
                let moved = MatrixPose { translation: normal * depth, ..MatrixPose::identity() };
                let apart = distance(&bodies[0], &bodies[1], moved, f64::INFINITY, &mut scratch).unwrap();
                assert!(apart.distance > 0.0, "{names}: {deepest:?}");
            }
            number += 1 + others.len();
        }
    }
    number
}

/// A closed mesh with a rough surface, as obstacles from sensors are.
fn rough_obstacle(random: &mut Random) -> TriangleMesh {
    random.blob(12, 0.4)
}

#[test]
fn the_demo_arm_has_contacts_with_itself_and_a_mesh() {
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/demo_arm/demo_arm.urdf");
    let robot = Arc::new(RobotModel::load(&urdf, None, &[]).unwrap());
    let mut world = World::default();
    let mesh = Shape::Mesh(Arc::new(rough_obstacle(&mut Random::new(31))));
    world.add(Obstacle::of_shape("rock", Pose::translation(0.4, 0.1, 0.4), mesh)).unwrap();
    let floor = Shape::Primitive(Primitive::Box { half_extents: [2.0, 2.0, 0.1] });
    world.add(Obstacle::of_shape("floor", Pose::translation(0.0, 0.0, -0.08), floor)).unwrap();
    let checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
    let number = verify_contacts(&checker, 15, 32);
    assert!(number > 100, "{number}");
}

#[test]
fn a_real_robot_has_contacts_with_itself_and_a_mesh() {
    let Some(robots) = shared_folder("robots") else { return };
    let robot = Arc::new(crate::peer_results::robot(&robots, "ur5e", true));
    let mut world = World::default();
    let mesh = Shape::Mesh(Arc::new(rough_obstacle(&mut Random::new(33))));
    world.add(Obstacle::of_shape("rock", Pose::translation(0.3, 0.3, 0.5), mesh)).unwrap();
    let checker = CollisionChecker::new(robot, &world, Settings::default()).unwrap();
    let number = verify_contacts(&checker, 10, 34);
    assert!(number > 50, "{number}");
}

/// A ball that enters a closed mesh, which is a surface for collisions: the depth grows with the way, on both sides of the wall.
#[test]
fn padded_bodies_just_inside_a_closed_mesh_leave_it_outward() {
    let urdf = "<robot name='r'><link name='base'/><link name='ball'><collision><geometry><sphere radius='0.02'/></geometry></collision></link>
        <joint name='x' type='prismatic'><parent link='base'/><child link='ball'/><axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>";
    let robot = Arc::new(RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap());
    let at = |i: usize, k: usize| if i >> k & 1 == 0 { -0.1 } else { 0.1 };
    let vertices = (0..8).map(|i| Point::new(at(i, 0), at(i, 1), at(i, 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let mesh = Shape::Mesh(Arc::new(TriangleMesh::new(vertices, faces).unwrap()));
    let mut world = World::default();
    world.add(Obstacle::of_shape("box", Pose::identity(), mesh)).unwrap();
    let settings = Settings { padding: 0.015, ..Settings::default() };
    let checker = CollisionChecker::new(robot, &world, settings).unwrap();
    let mut workspace = checker.workspace();
    for x in [0.14, 0.121, 0.119, 0.1, 0.0801, 0.0799, 0.075, 0.07, 0.066] {
        let q = checker.robot().configuration(&[x]).unwrap();
        let signed = x - 0.1 - 0.02 - 0.015;
        let clearance = checker.clearance(&q, 1.0, &mut workspace);
        let [pair] = &clearance.pairs[..] else { panic!("{clearance:?}") };
        assert!((pair.upper - signed).abs() < 1e-6 && (pair.lower - signed).abs() < 1e-6, "{x}: {pair:?}");
        assert!(pair.normal.unwrap().x < -0.999 && clearance.gradient[0] > 0.999, "{x}: {clearance:?}");
        let contact = checker.contact(&q, (pair.a, pair.b), &mut workspace);
        assert_eq!(contact.is_some(), signed < 0.0, "{x}");
        if let Some(contact) = contact {
            assert!((contact.depth.unwrap() + signed).abs() < 1e-6, "{x}: {contact:?}");
            assert!(contact.normal.unwrap().x < -0.999, "{x}: {contact:?}");
        }
    }
}
