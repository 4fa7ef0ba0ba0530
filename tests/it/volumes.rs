//! Tests that the selected kind of bounding volume does not change reports, of single states and of streams.

use std::sync::Arc;

use clearance::checker::{CollisionChecker, CollisionReport, Question, Workspace};
use clearance::geometry::VolumeKind;
use clearance::proximity::Work;
use clearance::robot::{Configuration, RobotModel};
use clearance::scene::{Settings, VolumeSelection, World};

use crate::command_line::{self, assert_bad_input, check};
use crate::program::Folder;
use crate::random::Random;
use crate::streams;
use crate::tally::{json, shared_folder};
use crate::worlds;

const QUESTIONS: [Question; 4] = [
    Question::Free,
    Question::Pairs,
    Question::SelfAndWorldDistance { limit: 0.5 },
    Question::PairDistances { limit: 0.1 },
];

/// Reports without their work, and the work.
fn reports(
    checker: &CollisionChecker,
    states: &[Configuration],
    question: Question,
    mut workspace: Workspace,
) -> (Vec<CollisionReport>, Work) {
    let mut work = Work::default();
    let report = |q| {
        let report = checker.check(q, question, &mut workspace);
        work += report.work;
        CollisionReport { work: Work::default(), ..report }
    };
    (states.iter().map(report).collect(), work)
}

/// Every kind for all bodies, and two kinds for individual links.
fn assert_same(robot: &Arc<RobotModel>, world: &World, states: &[Configuration], settings: &Settings) {
    let checker = |volumes: VolumeSelection| {
        let settings = Settings { volumes, ..settings.clone() };
        CollisionChecker::new(Arc::clone(robot), world, settings).unwrap()
    };
    let with_shapes = robot.links().iter().filter(|link| !link.collisions.is_empty());
    let names: Vec<String> = with_shapes.map(|link| link.name.clone()).collect();
    let mut mixed = VolumeSelection::of_all(VolumeKind::Rss);
    for (name, kind) in names.iter().step_by(2).zip(VolumeKind::ALL.into_iter().cycle()) {
        mixed.links.insert(name.clone(), kind);
    }
    let boxes = checker(VolumeSelection::default());
    let others = VolumeKind::ALL.into_iter().map(VolumeSelection::of_all).chain([mixed]);
    let others: Vec<(String, CollisionChecker)> =
        others.map(|volumes| (volumes.to_string(), checker(volumes))).collect();
    let mut differ = 0;
    for question in QUESTIONS {
        let (expected, cost) = reports(&boxes, states, question, boxes.workspace());
        for (volumes, other) in &others {
            let (found, work) = reports(other, states, question, other.workspace());
            assert_eq!(found, expected, "{}: {question:?} with {volumes}", robot.name());
            assert!(volumes != "obb" || work == cost, "{}: {question:?}", robot.name());
            differ += usize::from(work != cost);
            let (streamed, _) = reports(other, states, question, other.streaming_workspace());
            assert_eq!(streamed, expected, "{}: {question:?} in a stream with {volumes}", robot.name());
        }
    }
    assert!(differ > 0, "{}: no search used other volumes", robot.name());
}

#[test]
fn reports_of_the_demo_robots_do_not_depend_on_the_kind_of_volume() {
    let mut random = Random::new(90);
    for checker in streams::checkers() {
        let states = streams::walk(&checker, &mut random, 8, 6);
        assert_same(checker.robot(), checker.world(), &states, checker.settings());
    }
}

#[test]
fn reports_of_the_shared_robots_do_not_depend_on_the_kind_of_volume() {
    let Some(folder) = shared_folder("robots") else { return };
    let mut random = Random::new(91);
    for entry in json(&folder.join("robots.json")).as_array().unwrap() {
        let path = |key: &str| folder.join(entry[key].as_str().unwrap());
        let robot = RobotModel::load(&path("urdf"), Some(&path("srdf")), &[path("package_root")]).unwrap();
        let robot = Arc::new(robot);
        let mut world = World::default();
        for i in 0..6 {
            world.add(worlds::obstacle(format!("obstacle {i}"), &mut random, 1.2, 0.2)).unwrap();
        }
        let settings = Settings { padding: 0.005, ..Settings::default() };
        let states: Vec<Configuration> = (0..5).map(|_| worlds::state(&robot, &mut random)).collect();
        assert_same(&robot, &world, &states, &settings);
    }
}

#[test]
fn the_program_takes_the_kind_of_volume_and_rejects_what_does_not_exist() {
    let model = ["--urdf", "urdf/demo_arm/demo_arm.urdf", "--world", "config/demo_world.yaml"];
    let folder = Folder::new();
    let mut random = Random::new(92);
    let states: Vec<Vec<f64>> = (0..20).map(|_| (0..7).map(|_| random.within(-1.5, 1.5)).collect()).collect();
    let joints: Vec<String> = (1..=7).map(|i| format!("joint{i}")).collect();
    let text = serde_json::json!({"joints": joints, "states": states}).to_string();
    let states = folder.write("q.json", &text);
    let question = ["--query", "distance", "--format", "json", "--states", &states];
    let with = |volumes: &[&str]| check(&model, &[&question, volumes].concat());
    let boxes = command_line::json(&with(&[]))["results"].clone();
    assert_eq!(boxes.as_array().map(Vec::len), Some(20));
    for volumes in ["obb", "rss", "kdop18,link4=kios"] {
        assert_eq!(command_line::json(&with(&["--volumes", volumes]))["results"], boxes, "{volumes}");
    }
    let rejected = with(&["--volumes", "box"]);
    assert_bad_input(&rejected, &["--volumes", "'box' is no kind of bounding volume; there are obb, rss"]);
    let rejected = with(&["--volumes", "rss,nose=pss"]);
    assert_bad_input(&rejected, &["the robot has no link 'nose'", "its links with collision geometry are"]);
}
