//! Tests with scenes and paths of other projects, against independent results: path samples and MoveIt scene files.

use clearance::checker::{CollisionChecker, Question};
use clearance::geometry::math::Pose;
use clearance::geometry::{Primitive, Shape};
use clearance::robot::{MeshFiles, RobotModel};
use clearance::scene::SceneLoader;
use clearance::scene::{BodyId, Settings};
use serde_json::Value;
use std::sync::Arc;

use crate::peer_results::{
    COAL_ACCURACY, hits, pair_list, robot, scene_checker, scene_configuration, scene_files,
};
use crate::tally::{Tally, json, shared_folder};

#[test]
fn path_samples_of_the_scenes() {
    let (Some(scenes), Some(robots)) = (shared_folder("scenes"), shared_folder("robots")) else { return };
    let meshes = MeshFiles::under(&scenes);
    let mut tally = Tally::new("scenes, path_samples");
    for file in scene_files(&scenes) {
        let scene = json(&file);
        let robot = Arc::new(robot(&robots, scene["robot"].as_str().unwrap(), true));
        for problem in scene["problems"].as_array().unwrap() {
            scene_problem(&scene, problem, &robot, &meshes, &mut tally);
        }
    }
    tally.finish(500);
}

fn scene_problem(
    scene: &Value,
    problem: &Value,
    robot: &Arc<RobotModel>,
    meshes: &MeshFiles,
    tally: &mut Tally,
) {
    let checker = scene_checker(scene, problem, robot, meshes);
    let mut workspace = checker.workspace();
    for sample in problem["path_samples"].as_array().unwrap() {
        let t = sample["t"].as_f64().unwrap();
        let q = scene_configuration(problem, robot, t);
        let case = format!("{} at {t}", problem["id"].as_str().unwrap());
        tally.add(&case, &sample_disagreements(&checker, &q, sample, &mut workspace));
    }
}

/// MoveIt's own file of a scene, read against the truth of the neutral one.
#[test]
fn native_scenes_agree_with_the_truth() {
    let (Some(scenes), Some(robots)) = (shared_folder("scenes"), shared_folder("robots")) else { return };
    let robot = Arc::new(robot(&robots, "panda", true));
    let mut tally = Tally::new("scenes/native, path_samples");
    for (file, native, id) in [
        ("panda-box.json", "panda-box-scene0003.yaml", "box-0003"),
        ("panda-cage.json", "panda-cage-scene0009.yaml", "cage-0009"),
    ] {
        let scene = json(&scenes.join(file));
        let problems = scene["problems"].as_array().unwrap();
        let problem = problems.iter().find(|p| p["id"] == id).unwrap();
        let path = scenes.join("native").join(native);
        let bytes = std::fs::read(&path).unwrap();
        let mut read = SceneLoader::default();
        read.read_file(&bytes, &path, None, &robot, &MeshFiles::default()).unwrap();
        let names: Vec<_> = read.scene.world.obstacles().map(|o| o.name.clone()).collect();
        let wanted = problem["obstacles"].as_array().unwrap();
        assert!(wanted.iter().all(|o| names.contains(&o["name"].as_str().unwrap().to_owned())), "{names:?}");
        // the truth is about the SRDF's pairs
        let checker = CollisionChecker::new(robot.clone(), &read.scene.world, Settings::default()).unwrap();
        let mut workspace = checker.workspace();
        for sample in problem["path_samples"].as_array().unwrap() {
            let t = sample["t"].as_f64().unwrap();
            let q = scene_configuration(problem, &robot, t);
            tally.add(
                &format!("{native} at {t}"),
                &sample_disagreements(&checker, &q, sample, &mut workspace),
            );
        }
    }
    tally.finish(18);
}

#[test]
fn a_native_scene_text_has_the_shapes_it_says() {
    let (Some(scenes), Some(robots)) = (shared_folder("scenes/native"), shared_folder("robots")) else {
        return;
    };
    let robot = robot(&robots, "baxter", true);
    let path = scenes.join("baxter_pillar.scene");
    let mut read = SceneLoader::default();
    read.read_file(&std::fs::read(&path).unwrap(), &path, None, &robot, &MeshFiles::default()).unwrap();
    let pillar = read.scene.world.obstacle_by_name("pillar").unwrap();
    let (pose, shape) = pillar.placed_shapes().next().unwrap();
    assert!(matches!(shape, Shape::Primitive(p) if *p == Primitive::cuboid([0.2, 0.2, 1.0]).unwrap()));
    assert_eq!(pose, Pose::translation(0.6, 0.15, 0.0));
    assert_eq!((read.scene.world.len(), pillar.shapes.len()), (1, 1));
}

fn sample_disagreements(
    checker: &CollisionChecker,
    q: &clearance::Configuration,
    sample: &Value,
    workspace: &mut clearance::Workspace,
) -> Vec<String> {
    let mut wrong = vec![];
    let report = checker.check(q, Question::Pairs, workspace);
    let (world_hits, self_hits): (Vec<_>, Vec<_>) =
        report.colliding_pairs.iter().partition(|(_, b)| matches!(b, BodyId::Obstacle(_)));
    for (scope, found) in [("self", self_hits), ("world", world_hits)] {
        let found = hits(checker, &found);
        let wanted = pair_list(sample.get(format!("{scope}_hits")));
        if found != wanted {
            wrong.push(format!("{scope} hits {found:?} instead of {wanted:?}"));
        }
    }
    // each scope's least distance: the far limit keeps every pair that matters
    let wanted = ["self", "world"].map(|scope| sample[format!("{scope}_distance")].as_f64());
    let limit = wanted.iter().flatten().fold(0.0, |m: f64, d| m.max(*d)) + 1e-4;
    let near = checker.check(q, Question::PairDistances { limit }, workspace);
    for (scope, wanted) in ["self", "world"].into_iter().zip(wanted) {
        let Some(wanted) = wanted else { continue };
        let of_scope =
            near.pair_distances.iter().filter(|p| matches!(p.b, BodyId::Obstacle(_)) == (scope == "world"));
        let found = of_scope.map(|p| p.distance).fold(f64::INFINITY, f64::min);
        if (found - wanted).abs() > COAL_ACCURACY {
            wrong.push(format!("{scope} distance {found} instead of {wanted}"));
        }
    }
    wrong
}
