//! Tests of whole robots against results of other software: collisions, distances, walks, worlds and point clouds.

use clearance::checker::{CollisionChecker, Question};
use clearance::geometry::Shape;
use clearance::geometry::math::Pose;
use clearance::robot::MeshFiles;
use clearance::scene::World;
use clearance::scene::{BodyId, Settings};
use rayon::prelude::*;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

use crate::cases::{pose, shape};
use crate::peer_results::{
    COAL_ACCURACY, TruthRobot, cloud_world, configurations, env_world, hits, named, names, pair_list, robot,
    truth_robot, world_of,
};
use crate::tally::{Tally, json, shared_folder};

#[test]
fn self_collisions_of_the_shared_robots() {
    let Some(robots) = shared_folder("robots") else { return };
    let mut tally = Tally::new("robots/states.json");
    for truth in json(&robots.join("states.json")).as_array().unwrap() {
        let name = truth["robot"].as_str().unwrap();
        let robot = Arc::new(robot(&robots, name, true));
        let checker = CollisionChecker::new(robot.clone(), &World::default(), Settings::default()).unwrap();
        let mut workspace = checker.workspace();
        // the file counts pairs of collision geometries
        let geometries = |l| robot.link(l).collisions.len();
        let pairs = checker.pairs().link_pairs();
        let geometry_pairs: usize = pairs.map(|(a, b)| geometries(a) * geometries(b)).sum();
        assert_eq!(Some(geometry_pairs as u64), truth["pairs_checked"].as_u64(), "{name}");
        for (i, state) in truth["states"].as_array().unwrap().iter().enumerate() {
            let q = robot.configuration_from_names(named(&state["joints"])).unwrap();
            let report = checker.check(&q, Question::Pairs, &mut workspace);
            let mut wanted = pair_list(state.get("hits"));
            wanted.extend(pair_list(state.get("adjacent_hits")));
            wanted.sort();
            let found = hits(&checker, &report.colliding_pairs);
            let mut wrong = vec![];
            if found != wanted {
                wrong.push(format!("{found:?} instead of {wanted:?}"));
            }
            if checker.is_free(&q, &mut workspace) != wanted.is_empty() {
                wrong.push("is_free".to_owned());
            }
            if let Some(least) = state["least_distance_of_free_non_adjacent_pairs"].as_f64() {
                let limit = least + 1e-3;
                let survey = checker.check(&q, Question::PairDistances { limit }, &mut workspace);
                let nearest = (survey.pair_distances.iter())
                    .filter(|p| p.distance > 0.0)
                    .filter(|p| match (p.a, p.b) {
                        (BodyId::Link(a), BodyId::Link(b)) => !robot.adjacent_rigid_bodies(a, b),
                        _ => true,
                    })
                    .map(|p| p.distance)
                    .fold(f64::INFINITY, f64::min);
                if (nearest - least).abs() > COAL_ACCURACY {
                    wrong.push(format!("least distance {nearest} instead of {least}"));
                }
            }
            tally.add(&format!("{name} state {i}"), &wrong);
        }
    }
    tally.finish(72);
}

#[test]
fn robot_cases_of_other_test_suites() {
    let Some(robots) = shared_folder("robots") else { return };
    let Some(cases) = shared_folder("cases") else { return };
    let meshes = MeshFiles::under(&cases);
    let mut tally = Tally::new("cases.json, robots and links");
    for case in json(&cases.join("cases.json")).as_array().unwrap() {
        let wrong = match case["kind"].as_str().unwrap() {
            "robot" => robot_case(case, &robots, &meshes),
            "links" => links_case(case, &robots, &meshes),
            _ => continue,
        };
        tally.add(case["id"].as_str().unwrap(), &wrong);
    }
    tally.finish(4);
}

fn robot_case(case: &Value, robots: &Path, meshes: &MeshFiles) -> Vec<String> {
    let robot = robot(robots, case["robot"].as_str().unwrap(), case["use_srdf"] == Value::Bool(true));
    let world = world_of(case["world"].as_array().unwrap(), meshes);
    let mut settings = Settings::default();
    if let Some(padding) = case.get("padding") {
        settings.link_padding = named(padding).iter().map(|(l, p)| ((*l).to_owned(), *p)).collect();
    }
    let checker = CollisionChecker::new(Arc::new(robot), &world, settings).unwrap();
    let q = checker.robot().configuration_from_names(named(&case["joints"])).unwrap();
    let limit = f64::INFINITY;
    let report = checker.check(&q, Question::Distance { limit }, &mut checker.workspace());
    let expect = &case["expect"];
    let mut wrong = vec![];
    for (field, found) in [("self_collide", report.self_collision), ("world_collide", report.world_collision)]
    {
        if expect[field].as_bool().is_some_and(|wanted| wanted != found) {
            wrong.push(format!("{field} {found}"));
        }
    }
    if let Some(wanted) = expect["self_distance"].as_f64() {
        let found = report.nearest.unwrap().distance;
        if (found - wanted).abs() > expect["tolerance"].as_f64().unwrap() {
            wrong.push(format!("self distance {found} instead of {wanted}"));
        }
    }
    wrong
}

/// A link against a link or a shape: a robot whose one link is that link, against a world of the other.
fn links_case(case: &Value, robots: &Path, meshes: &MeshFiles) -> Vec<String> {
    let robot = robot(robots, case["robot"].as_str().unwrap(), false);
    let body = |side: &Value| {
        let shapes: Vec<(Pose, Shape)> = match side["link"].as_str() {
            Some(link) => {
                let link = robot.link(robot.link_by_name(link).unwrap());
                link.collisions.iter().map(|c| (c.pose_ls, c.shape.clone())).collect()
            }
            None => vec![(Pose::identity(), shape(&side["shape"], meshes))],
        };
        clearance::proximity::CollisionBody::new(shapes.iter().map(|(p, s)| (p, s))).unwrap()
    };
    let (a, b) = (&case["a"], &case["b"]);
    let pose_ab = pose(&a["pose"]).inv_mul(&pose(&b["pose"]));
    let mut scratch = clearance::proximity::Scratch::default();
    let hit = clearance::proximity::collide(&body(a), &body(b), &pose_ab, &mut scratch).is_some();
    if hit == case["expect"]["collide"].as_bool().unwrap() { vec![] } else { vec![format!("collide {hit}")] }
}

#[test]
fn thousands_of_states_and_walks() {
    let Some(truth) = shared_folder("truth") else { return };
    for name in ["ur5", "panda"] {
        let folder = truth.join(name);
        let robot = truth_robot(&folder);
        for (states, answers, count) in [
            ("states.json", "truth_states.json", 2000),
            ("states_free.json", "truth_states_free.json", 1000),
            ("walks.json", "truth_walks.json", 10_000),
        ] {
            let answers = json(&folder.join(answers));
            let qs = configurations(&robot, &folder.join(states));
            let wrong: Vec<_> = (qs.par_iter().enumerate())
                .map_init(
                    || robot.checker.workspace(),
                    |workspace, (i, q)| state_disagreements(&robot, q, i, &answers, workspace),
                )
                .collect();
            let mut tally = Tally::new(&format!("truth/{name}/{states}"));
            for (i, wrong) in wrong.iter().enumerate() {
                tally.add(&format!("state {i}"), wrong);
            }
            tally.finish(count);
        }
    }
}

fn state_disagreements(
    robot: &TruthRobot,
    q: &clearance::Configuration,
    i: usize,
    answers: &Value,
    workspace: &mut clearance::Workspace,
) -> Vec<String> {
    let checker = &robot.checker;
    let mut wrong = vec![];
    let hit = answers["hit"][i].as_u64().unwrap() == 1;
    if checker.is_free(q, workspace) == hit {
        wrong.push(format!("hit should be {hit}"));
    }
    let found = checker.check(q, Question::Distance { limit: f64::INFINITY }, workspace).nearest.unwrap();
    let wanted = answers["min_distance"][i].as_f64().unwrap();
    if (found.distance - wanted).abs() > 2e-9 {
        wrong.push(format!("distance {} instead of {wanted}", found.distance));
    }
    if let Some(pairs) = answers.get("colliding_pairs") {
        let report = checker.check(q, Question::Pairs, workspace);
        let mut wanted: Vec<_> = (pairs[i].as_array().unwrap().iter())
            .map(|k| robot.link_pairs[usize::try_from(k.as_u64().unwrap()).unwrap()].clone())
            .collect();
        wanted.sort();
        if hits(checker, &report.colliding_pairs) != wanted {
            wrong.push("colliding pairs".to_owned());
        }
    }
    wrong
}

#[test]
fn every_pair_distance_of_a_hundred_states() {
    let Some(truth) = shared_folder("truth") else { return };
    for name in ["ur5", "panda"] {
        let folder = truth.join(name);
        let robot = truth_robot(&folder);
        let checker = &robot.checker;
        let answers = json(&folder.join("truth_pair_distances.json"));
        let qs = configurations(&robot, &folder.join("states.json"));
        let wrong: Vec<Vec<String>> = (qs[..100].par_iter().enumerate())
            .map_init(
                || checker.workspace(),
                |workspace, (i, q)| {
                    let limit = f64::INFINITY;
                    let report = checker.check(q, Question::PairDistances { limit }, workspace);
                    assert_eq!(report.pair_distances.len(), robot.link_pairs.len());
                    let off = |p: &clearance::checker::PairDistance| {
                        let pair = names(checker, p.a, p.b);
                        let k = robot.link_pairs.iter().position(|x| *x == pair).unwrap();
                        let wanted = answers["distance"][i][k].as_f64().unwrap();
                        ((p.distance - wanted).abs() > 2e-9)
                            .then(|| format!("{pair:?} {} instead of {wanted}", p.distance))
                    };
                    report.pair_distances.iter().filter_map(off).collect()
                },
            )
            .collect();
        let mut tally = Tally::new(&format!("truth/{name}/truth_pair_distances.json"));
        for (i, wrong) in wrong.iter().enumerate() {
            tally.add(&format!("state {i}"), wrong);
        }
        tally.finish(100);
    }
}

#[test]
fn robots_against_primitives_a_mesh_world_and_a_cloud() {
    let Some(truth) = shared_folder("truth") else { return };
    for name in ["ur5", "panda"] {
        let folder = truth.join(name);
        let robot = truth_robot(&folder);
        let qs = configurations(&robot, &folder.join("states.json"));
        for (env, states) in
            [("prim_10", 2000), ("prim_100", 300), ("prim_1000", 100), ("mesh", 200), ("cloud", 2000)]
        {
            let answers = json(&folder.join(format!("truth_env_{env}.json")));
            let env_file = json(&folder.join(format!("env_{env}.json")));
            let objects = env_file["objects"].as_array().unwrap();
            let settings = Settings { check_self: false, ..Settings::default() };
            let world = match env_file["radius"].as_f64() {
                Some(radius) => cloud_world(&objects[0], radius, &folder),
                None => env_world(objects, &folder),
            };
            let checker = CollisionChecker::new(robot.checker.robot().clone(), &world, settings).unwrap();
            let wrong: Vec<Vec<String>> = (qs[..states].par_iter().enumerate())
                .map_init(
                    || checker.workspace(),
                    |workspace, (i, q)| {
                        let mut wrong = vec![];
                        let hit = answers["hit"][i].as_u64().unwrap() == 1;
                        if checker.is_free(q, workspace) == hit {
                            wrong.push(format!("hit should be {hit}"));
                        }
                        let report = checker.check(q, Question::Distance { limit: f64::INFINITY }, workspace);
                        let found = report.nearest.unwrap().distance;
                        // of clouds the file has the distance from the points themselves
                        let reach = env_file["radius"].as_f64().unwrap_or(0.0);
                        let wanted = (answers["min_distance"][i].as_f64().unwrap() - reach).max(0.0);
                        if (found - wanted).abs() > 5e-9 {
                            wrong.push(format!("distance {found} instead of {wanted}"));
                        }
                        wrong
                    },
                )
                .collect();
            let mut tally = Tally::new(&format!("truth/{name}/truth_env_{env}.json"));
            for (i, wrong) in wrong.iter().enumerate() {
                tally.add(&format!("state {i}"), wrong);
            }
            tally.finish(states);
        }
    }
}
