//! Tests of loading the shared robots: joints, links, meshes and link poses against published values.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use clearance::geometry::Shape;
use clearance::geometry::math::{Pose, Vector, pose_from_xyz_quaternion};
use clearance::robot::{JointKind, LinkPoses, MeshFiles, RobotModel};
use serde_json::Value;

use crate::tally::{json, shared_folder};

/// `states.json` holds poses rounded to seven decimals.
const ROUNDING: f64 = 6e-8;

fn path_of(entry: &Value, key: &str) -> PathBuf {
    shared_folder("robots").unwrap_or_default().join(entry[key].as_str().unwrap())
}

fn load(entry: &Value) -> RobotModel {
    let start = Instant::now();
    let model = RobotModel::load(
        &path_of(entry, "urdf"),
        Some(&path_of(entry, "srdf")),
        &[path_of(entry, "package_root")],
    )
    .unwrap_or_else(|e| panic!("{e}"));
    println!("{}: loaded in {:.1} ms", entry["name"], start.elapsed().as_secs_f64() * 1e3);
    model
}

fn kind_name(kind: &JointKind) -> &'static str {
    match kind {
        JointKind::Fixed => "fixed",
        JointKind::Revolute(_) => "revolute",
        JointKind::Continuous(_) => "continuous",
        JointKind::Prismatic(_) => "prismatic",
        JointKind::Floating => "floating",
        JointKind::Planar(_) => "planar",
    }
}

fn counted<'a>(names: impl Iterator<Item = &'a str>) -> Value {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    serde_json::to_value(counts).unwrap()
}

/// The facts of `robots.json` as this library sees them.
fn facts(model: &RobotModel) -> Value {
    let shapes = || model.links().iter().flat_map(|l| &l.collisions).map(|c| &c.shape);
    let triangles: usize = shapes()
        .map(|s| match s {
            Shape::Mesh(mesh) => mesh.triangles().len(),
            _ => 0,
        })
        .sum();
    serde_json::json!({
        "dof": model.degrees_of_freedom(),
        "links": model.links().len(),
        "mimic_joints": model.mimicking_joints().count(),
        "joint_types": counted(model.joints().iter().map(|j| kind_name(&j.kind))),
        "collision_geometries": counted(shapes().map(Shape::kind)),
        "triangles": triangles,
    })
}

#[test]
fn every_shared_robot_has_the_published_parts() {
    let Some(folder) = shared_folder("robots") else { return };
    for entry in json(&folder.join("robots.json")).as_array().unwrap() {
        let model = load(entry);
        for (key, value) in facts(&model).as_object().unwrap() {
            assert_eq!(value, &entry[key], "{}: {key}", entry["name"]);
        }
        for warning in model.warnings() {
            println!("  {warning}");
        }
        assert!(model.srdf().is_some());
    }
}

/// The largest difference of two poses in a coordinate (m) or a component of the quaternion.
fn difference(a: &Pose, b: &Pose) -> f64 {
    // q and -q are one rotation
    let quaternions = [1.0, -1.0].map(|sign| (a.rotation.coords - b.rotation.coords * sign).amax());
    let positions = (a.translation.vector - b.translation.vector).amax();
    positions.max(quaternions[0].min(quaternions[1]))
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|i| value[i].as_f64().unwrap())
}

#[test]
fn link_poses_agree_with_the_shared_states() {
    let Some(folder) = shared_folder("robots") else { return };
    let robots = json(&folder.join("robots.json"));
    for truth in json(&folder.join("states.json")).as_array().unwrap() {
        let name = truth["robot"].as_str().unwrap();
        let entry = robots.as_array().unwrap().iter().find(|r| r["name"] == name).unwrap();
        let model = load(entry);
        let mut poses = LinkPoses::new(&model);
        let mut compared = 0;
        let mut worst: f64 = 0.0;
        for state in truth["states"].as_array().unwrap() {
            let joints = state["joints"].as_object().unwrap();
            let named = joints.iter().map(|(n, v)| (n.as_str(), v.as_f64().unwrap()));
            let q = model.configuration_from_names(named).unwrap();
            model.forward_kinematics(&q, &mut poses);
            for (link, pose) in state["link_poses"].as_object().into_iter().flatten() {
                let expected = pose_from_xyz_quaternion(numbers(&pose[0]), numbers(&pose[1])).unwrap();
                let found = poses.pose(model.link_by_name(link).unwrap());
                let difference = difference(found, &expected);
                assert!(difference < ROUNDING, "{name} {link}: {found} instead of {expected}: {difference}");
                worst = worst.max(difference);
                compared += 1;
            }
        }
        println!("{name}: {compared} poses, worst difference {worst:.1e}");
        assert!(compared > 0);
    }
}

#[test]
fn the_truth_robots_load() {
    let Some(truth) = shared_folder("truth") else { return };
    for robot in ["ur5", "panda"] {
        let folder = truth.join(robot);
        let srdf = folder.join("robot.srdf");
        let model = RobotModel::load(&folder.join("robot.urdf"), srdf.exists().then_some(&*srdf), &[folder])
            .unwrap_or_else(|e| panic!("{e}"));
        println!("{robot}: {} warnings", model.warnings().len());
        assert!(model.degrees_of_freedom() >= 6);
    }
}

#[test]
fn the_meshes_of_the_shared_pairs_have_the_published_triangles() {
    let Some(folder) = shared_folder("cases") else { return };
    let files = MeshFiles::under(&folder);
    let truth = json(&folder.join("mesh_pairs.json"));
    for mesh in truth["pairs"].as_array().unwrap().iter().flat_map(|p| [&p["a"], &p["b"]]) {
        let scale = match &mesh["scale"] {
            Value::Array(_) => Vector::from(numbers::<3>(&mesh["scale"])),
            Value::Number(factor) => Vector::from_element(factor.as_f64().unwrap()),
            _ => Vector::from_element(1.0),
        };
        let name = mesh["file"].as_str().unwrap();
        let loaded = files.load(name, scale).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(Value::from(loaded.mesh.triangles().len()), mesh["triangles"], "{name}");
        if name.ends_with("fcl_rob.obj") {
            assert!(!loaded.remarks.is_empty(), "its first line is no OBJ");
        }
    }
}
