//! Test helper: loaders of the shared results of other software: robots, states, worlds and scenes.

use clearance::checker::CollisionChecker;
use clearance::geometry::math::Vector;
use clearance::geometry::{PointCloud, Primitive, Shape};
use clearance::robot::{MeshFiles, RobotModel};
use clearance::scene::AllowedCollisionMatrix;
use clearance::scene::{BodyId, Settings};
use clearance::scene::{Obstacle, World};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

use crate::cases::{numbers, pose, shape};
use crate::tally::json;

/// How far (m) the distances of Coal, rounded to 1e-6 and with a GJK tolerance of 1e-6, may be from the truth.
pub const COAL_ACCURACY: f64 = 1.6e-6;

/// A robot of the shared folder.
pub fn robot(robots: &Path, name: &str, use_srdf: bool) -> RobotModel {
    let list = json(&robots.join("robots.json"));
    let entry = (list.as_array().unwrap().iter()).find(|r| r["name"] == name).unwrap();
    let path = |field: &str| robots.join(entry[field].as_str().unwrap());
    let srdf = path("srdf");
    RobotModel::load(&path("urdf"), use_srdf.then_some(srdf.as_path()), &[path("package_root")])
        .unwrap_or_else(|e| panic!("{name}: {e}"))
}

pub fn named(value: &Value) -> Vec<(&str, f64)> {
    let joints = value.as_object().unwrap();
    joints.iter().map(|(j, v)| (j.as_str(), v.as_f64().unwrap())).collect()
}

/// Names of a pair, sorted.
pub fn names(checker: &CollisionChecker, a: BodyId, b: BodyId) -> (String, String) {
    let mut names = [a, b].map(|body| checker.body_name(body).to_owned());
    names.sort();
    let [a, b] = names;
    (a, b)
}

pub fn pair_list(value: Option<&Value>) -> Vec<(String, String)> {
    let mut pairs: Vec<_> = (value.and_then(Value::as_array).into_iter().flatten())
        .map(|pair| {
            let mut names = [0, 1].map(|i| pair[i].as_str().unwrap().to_owned());
            names.sort();
            let [a, b] = names;
            (a, b)
        })
        .collect();
    pairs.sort();
    pairs
}

pub fn hits(checker: &CollisionChecker, pairs: &[(BodyId, BodyId)]) -> Vec<(String, String)> {
    let mut found: Vec<_> = pairs.iter().map(|&(a, b)| names(checker, a, b)).collect();
    found.sort();
    found
}

pub fn world_of(objects: &[Value], meshes: &MeshFiles) -> World {
    let mut world = World::default();
    for object in objects {
        let (name, shape) = (object["name"].as_str().unwrap(), shape(&object["shape"], meshes));
        world.add(Obstacle::of_shape(name, pose(&object["pose"]), shape)).unwrap();
    }
    world
}

/// A robot of the truth folder and its pairs in the truth's order.
pub struct TruthRobot {
    pub checker: CollisionChecker,
    pub joint_order: Vec<String>,
    pub link_pairs: Vec<(String, String)>,
}

pub fn truth_robot(folder: &Path) -> TruthRobot {
    let srdf = folder.join("robot.srdf");
    let robot = RobotModel::load(&folder.join("robot.urdf"), Some(&srdf), &[]).unwrap();
    let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
    let strings = |v: &Value| -> Vec<String> {
        v.as_array().unwrap().iter().map(|s| s.as_str().unwrap().to_owned()).collect()
    };
    let pairs = json(&folder.join("pairs.json"));
    let link_pairs: Vec<_> = (pairs["link_pairs"].as_array().unwrap().iter())
        .map(|p| {
            let mut pair = strings(p);
            pair.sort();
            (pair[0].clone(), pair[1].clone())
        })
        .collect();
    let mut ours: Vec<_> =
        (checker.pairs().self_pairs().iter()).map(|&(a, b)| names(&checker, a, b)).collect();
    let mut theirs = link_pairs.clone();
    ours.sort();
    theirs.sort();
    assert_eq!(ours, theirs, "the pairs that the SRDF leaves");
    TruthRobot {
        joint_order: strings(&json(&folder.join("states.json"))["joint_order"]),
        checker,
        link_pairs,
    }
}

pub fn configurations(robot: &TruthRobot, file: &Path) -> Vec<clearance::Configuration> {
    let states = json(file);
    (states["q"].as_array().unwrap().iter())
        .map(|q| {
            let values = q.as_array().unwrap().iter().map(|v| v.as_f64().unwrap());
            let order = robot.joint_order.iter().map(String::as_str);
            robot.checker.robot().configuration_from_names(order.zip(values)).unwrap()
        })
        .collect()
}

/// A cloud of raw little-endian numbers, beside the robot's folder.
pub fn cloud_world(object: &Value, radius: f64, folder: &Path) -> World {
    let bytes = std::fs::read(folder.join(object["file"].as_str().unwrap())).unwrap();
    let number = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    let points: Vec<[f32; 3]> =
        bytes.chunks_exact(12).map(|p| [0, 4, 8].map(|i| number(&p[i..i + 4]))).collect();
    assert_eq!(points.len() as u64, object["count"].as_u64().unwrap());
    let shape = Shape::Points(PointCloud::new(points, radius).unwrap().into());
    let mut world = World::default();
    world.add(Obstacle::of_shape(object["id"].as_str().unwrap(), pose(&object["pose"]), shape)).unwrap();
    world
}

pub fn env_world(objects: &[Value], folder: &Path) -> World {
    // the mesh lies beside the robot's folder, which is outside the robot's own roots
    let meshes = MeshFiles::under(folder.parent().unwrap());
    let mut world = World::default();
    for object in objects {
        let shape = if object["type"] == "mesh" {
            let file = object["file"].as_str().unwrap().trim_start_matches("../");
            let scale = Vector::from(numbers::<3>(&object["scale"]));
            Shape::Mesh(meshes.load(file, scale).unwrap().mesh)
        } else {
            shape(object, &meshes)
        };
        assert!(!matches!(shape, Shape::Primitive(Primitive::Capsule { .. })));
        let name = object["id"].as_str().unwrap();
        world.add(Obstacle::of_shape(name, pose(&object["pose"]), shape)).unwrap();
    }
    world
}

/// A robot among a problem's obstacles.
pub fn scene_checker(
    scene: &Value,
    problem: &Value,
    robot: &Arc<RobotModel>,
    meshes: &MeshFiles,
) -> CollisionChecker {
    let list = |v: Option<&Value>| v.and_then(Value::as_array).cloned().unwrap_or_default();
    let mut obstacles = list(scene.get("shared_obstacles"));
    obstacles.extend(list(problem.get("obstacles")));
    let world = world_of(&obstacles, meshes);
    let mut allowed = AllowedCollisionMatrix::from_srdf(robot);
    for pair in list(problem.get("allowed_pairs")) {
        allowed.set(pair[0].as_str().unwrap(), pair[1].as_str().unwrap(), true);
    }
    CollisionChecker::with_matrix(robot.clone(), &world, Settings::default(), Some(&allowed)).unwrap()
}

/// Where a problem's straight line from start to goal is at t.
pub fn scene_configuration(problem: &Value, robot: &RobotModel, t: f64) -> clearance::Configuration {
    let others = named(&problem["other_joints"]);
    let (start, goal) = (named(&problem["start"]), &problem["goal"]);
    let between = start.iter().map(|&(j, s)| (j, s + t * (goal[j].as_f64().unwrap() - s)));
    let own: Vec<_> = between.chain(others.into_iter().filter(|(j, _)| goal.get(j).is_none())).collect();
    robot.configuration_from_names(own).unwrap()
}

/// The files of the shared scenes, in order.
pub fn scene_files(scenes: &Path) -> Vec<std::path::PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(scenes).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "json"));
    files.sort();
    files
}
