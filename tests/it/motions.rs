//! Tests of certified motion checks against results of other software, on edges, scenes and shape casts.

use clearance::checker::{CollisionChecker, MotionOptions, MotionOrder, MotionReport, MotionVerdict};
use clearance::geometry::math::{Point, Pose};
use clearance::motion::{MotionSegment, MovingObstacle};
use clearance::robot::{Configuration, MeshFiles, RobotModel};
use clearance::scene::Settings;
use clearance::scene::{Obstacle, World};
use clearance::verifier::Verifier;
use rayon::prelude::*;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

use crate::cases::{pose, shape};
use crate::peer_results::{
    TruthRobot, env_world, robot, scene_checker, scene_configuration, scene_files, truth_robot,
};
use crate::tally::{Tally, json, shared_folder};

/// How far (a fraction of the edge) the truth's first contact may be from the real one.
const CONTACT_TIME_ACCURACY: f64 = 1.5e-4;

/// What the truth says of an edge.
struct Edge {
    segment: MotionSegment,
    length: f64,
    ccd: u64,
    toi: f64,
}

fn edges(folder: &Path, robot: &RobotModel, order: &[String], scope: &str) -> Vec<Edge> {
    let edges = json(&folder.join("edges.json"));
    let truth = &json(&folder.join("truth_edges.json"))[scope];
    let configuration = |q: &Value| {
        let values = q.as_array().unwrap().iter().map(|v| v.as_f64().unwrap());
        robot.configuration_from_names(order.iter().map(String::as_str).zip(values)).unwrap()
    };
    (edges["edges"].as_array().unwrap().iter().enumerate())
        .map(|(i, edge)| Edge {
            segment: MotionSegment::straight(robot, &configuration(&edge["a"]), &configuration(&edge["b"])),
            length: edge["length"].as_f64().unwrap(),
            ccd: truth["ccd"][i].as_u64().unwrap(),
            toi: truth["toi"][i].as_f64().unwrap(),
        })
        .collect()
}

impl Edge {
    fn disagreements(&self, report: &MotionReport, order: MotionOrder) -> Vec<String> {
        let verdict = &report.verdict;
        let right = match (self.ccd, verdict) {
            (2, _) | (0, MotionVerdict::Free) => true,
            (1, MotionVerdict::Contact { t: [lo, hi], .. }) => {
                let slack = CONTACT_TIME_ACCURACY;
                lo - slack <= self.toi && (order == MotionOrder::Any || self.toi <= hi + slack)
            }
            _ => false,
        };
        if right { vec![] } else { vec![format!("{verdict:?}, but {} at {}", self.ccd, self.toi)] }
    }
}

#[test]
fn thousands_of_edges() {
    let Some(truth) = shared_folder("truth") else { return };
    for name in ["ur5", "panda"] {
        let folder = truth.join(name);
        let robot = truth_robot(&folder);
        for scope in ["self", "self+env_prim_100", "self+env_mesh"] {
            let world = match scope.strip_prefix("self+") {
                Some(env) => {
                    let objects = json(&folder.join(format!("{env}.json")))["objects"].clone();
                    env_world(objects.as_array().unwrap(), &folder)
                }
                None => World::default(),
            };
            let model = robot.checker.robot();
            let checker = CollisionChecker::new(model.clone(), &world, Settings::default()).unwrap();
            let edges = edges(&folder, model, &robot.joint_order, scope);
            for order in [MotionOrder::Earliest, MotionOrder::Any] {
                let options = MotionOptions { order, ..MotionOptions::default() };
                let start = std::time::Instant::now();
                let reports: Vec<MotionReport> = (edges.par_iter())
                    .map_init(
                        || checker.workspace(),
                        |workspace, edge| checker.check_motion_with(&edge.segment, &options, workspace),
                    )
                    .collect();
                let elapsed = start.elapsed().as_secs_f64() * 1e3;
                let evaluations: u64 = reports.iter().map(|r| r.evaluations).sum();
                eprintln!(
                    "{name} {scope} {order:?}: {elapsed:.1} us an edge on two, {evaluations} evaluations"
                );
                let mut tally = Tally::new(&format!("truth/{name}/truth_edges.json {scope} {order:?}"));
                for (i, (edge, report)) in edges.iter().zip(&reports).enumerate() {
                    let name = format!("edge {i} of length {}", edge.length);
                    tally.add(&name, &edge.disagreements(report, order));
                }
                tally.finish(1000);
            }
        }
    }
}

#[test]
fn edges_of_the_scenes() {
    let (Some(scenes), Some(robots)) = (shared_folder("scenes"), shared_folder("robots")) else { return };
    let meshes = MeshFiles::under(&scenes);
    let mut tally = Tally::new("scenes, edges");
    for file in scene_files(&scenes) {
        let scene = json(&file);
        let robot = Arc::new(robot(&robots, scene["robot"].as_str().unwrap(), true));
        for problem in scene["problems"].as_array().unwrap() {
            let checker = scene_checker(&scene, problem, &robot, &meshes);
            for edge in problem["edges"].as_array().into_iter().flatten() {
                let ends = ["from_t", "to_t"]
                    .map(|end| scene_configuration(problem, &robot, edge[end].as_f64().unwrap()));
                let report = checker.check_motion(&ends[0], &ends[1], &mut checker.workspace());
                let right = match (edge["verdict"].as_str().unwrap(), &report.verdict) {
                    ("graze", _) | ("free", MotionVerdict::Free) => true,
                    ("hit", MotionVerdict::Contact { t: [lo, _], .. }) => {
                        *lo <= edge["t"].as_f64().unwrap() + 1e-6
                    }
                    _ => false,
                };
                let wrong = if right { vec![] } else { vec![format!("{:?}, but {edge}", report.verdict)] };
                tally.add(problem["id"].as_str().unwrap(), &wrong);
            }
        }
    }
    tally.finish(100);
}

/// A robot that is one shape on a floating joint, and an obstacle of another shape that moves.
#[test]
fn casts_of_other_test_suites() {
    let Some(cases) = shared_folder("cases") else { return };
    let meshes = MeshFiles::under(&cases);
    let mut tally = Tally::new("cases.json, casts");
    for case in json(&cases.join("cases.json")).as_array().unwrap() {
        if case["kind"] == "cast" {
            tally.add(case["id"].as_str().unwrap(), &cast_disagreements(case, &meshes));
        }
    }
    tally.finish(7);
}

fn cast_disagreements(case: &Value, meshes: &MeshFiles) -> Vec<String> {
    let (a, b) = (&case["a"], &case["b"]);
    let robot = Arc::new(floating_shape(&a["shape"]));
    let mut world = World::default();
    world.add(Obstacle::of_shape("b", Pose::identity(), shape(&b["shape"], meshes))).unwrap();
    let checker = CollisionChecker::new(robot.clone(), &world, Settings::default()).unwrap();
    let configuration = |value: &Value| {
        let Pose { rotation, translation } = pose(value);
        let positions: Vec<f64> = translation.vector.iter().chain(rotation.coords.iter()).copied().collect();
        robot.configuration(&positions).unwrap()
    };
    let [from, to] = ["pose_start", "pose_end"].map(|end| configuration(&a[end]));
    let mover = MovingObstacle::between("b", Point::origin(), &pose(&b["pose_start"]), &pose(&b["pose_end"]));
    let segment = MotionSegment::straight(&robot, &from, &to).with_obstacles(&world, vec![mover]).unwrap();
    let report = checker.check_motion_with(&segment, &MotionOptions::default(), &mut checker.workspace());
    let expect = &case["expect"];
    let right = match &report.verdict {
        MotionVerdict::Free => expect["collide"] == Value::Bool(false),
        MotionVerdict::Contact { t: [lo, hi], .. } => {
            let at = expect["time_of_impact"].as_f64();
            expect["collide"] == Value::Bool(true)
                && at.is_none_or(|at| *lo <= at + 1e-6 && at <= hi + 1e-6 && hi - lo < 1e-3)
        }
        MotionVerdict::Undecided { .. } => false,
    };
    if right { vec![] } else { vec![format!("{report:?}, but {expect}")] }
}

fn floating_shape(shape: &Value) -> RobotModel {
    let geometry = match shape["type"].as_str().unwrap() {
        "sphere" => format!("<sphere radius='{}'/>", shape["radius"]),
        "box" => {
            let size = shape["size"].as_array().unwrap();
            format!("<box size='{} {} {}'/>", size[0], size[1], size[2])
        }
        other => panic!("unknown shape {other}"),
    };
    let urdf = format!(
        "<robot name='cast'><link name='root'/>
        <link name='a'><collision><geometry>{geometry}</geometry></collision></link>
        <joint name='free' type='floating'><parent link='root'/><child link='a'/></joint></robot>"
    );
    RobotModel::from_urdf(&urdf, &MeshFiles::default()).unwrap()
}

/// Every edge that is proven free has a certificate that holds, and none of another motion does.
#[test]
fn certificates_of_the_truth_are_verified() {
    let Some(truth) = shared_folder("truth") else { return };
    for name in ["ur5", "panda"] {
        let folder = truth.join(name);
        let robot = truth_robot(&folder);
        let model = robot.checker.robot();
        for scope in ["self", "self+env_prim_100"] {
            let world = match scope.strip_prefix("self+") {
                Some(env) => {
                    let objects = json(&folder.join(format!("{env}.json")))["objects"].clone();
                    env_world(objects.as_array().unwrap(), &folder)
                }
                None => World::default(),
            };
            let settings = Settings::default();
            let checker = CollisionChecker::new(model.clone(), &world, settings.clone()).unwrap();
            let verifier = Verifier::new(model, &world, &settings, None).unwrap();
            let step = if scope == "self" { 1 } else { 10 };
            let edges: Vec<Edge> =
                edges(&folder, model, &robot.joint_order, scope).into_iter().step_by(step).collect();
            let wrong: Vec<String> = (edges.par_iter().enumerate())
                .map_init(
                    || checker.workspace(),
                    |workspace, (i, edge)| {
                        let options = MotionOptions::default();
                        let (report, certificate) =
                            checker.certify_motion(&edge.segment, &options, workspace);
                        let mut wrong = edge.disagreements(&report, MotionOrder::Earliest);
                        if let Some(certificate) = certificate
                            && let Err(refusal) = verifier.verify(&certificate)
                        {
                            wrong.push(format!("{refusal}"));
                        }
                        (!wrong.is_empty()).then(|| format!("edge {i}: {}", wrong.join("; ")))
                    },
                )
                .flatten()
                .collect();
            let mut tally = Tally::new(&format!("truth/{name}/truth_edges.json {scope}, certificates"));
            tally.add_all(edges.len(), wrong);
            tally.finish(1000 / step);
        }
    }
}

/// Both ends are free, and so are the poses that most samplings look at.
#[test]
fn the_panda_hits_itself_on_the_way() {
    let Some(truth) = shared_folder("truth") else { return };
    let TruthRobot { checker, .. } = truth_robot(&truth.join("panda"));
    let robot = checker.robot();
    let at = |j5: f64| -> Configuration {
        let joints =
            [("panda_joint2", 0.15), ("panda_joint4", -3.0), ("panda_joint5", j5), ("panda_joint7", -0.785)];
        robot.configuration_from_names(joints).unwrap()
    };
    let mut workspace = checker.workspace();
    assert!(checker.is_free(&at(-0.8), &mut workspace) && checker.is_free(&at(0.8), &mut workspace));
    let report = checker.check_motion(&at(-0.8), &at(0.8), &mut workspace);
    let MotionVerdict::Contact { t: [lo, hi], .. } = report.verdict else { panic!("{report:?}") };
    let at_t = |t: f64| at(-0.8 + 1.6 * t);
    assert!(checker.is_free(&at_t(lo), &mut workspace) && !checker.is_free(&at_t(hi), &mut workspace));
}
