//! Tests that streams, batches, threads and instruction sets give the reports of single states.

use clearance::checker::{CollisionChecker, CollisionReport, Question, Workspace};
use clearance::proximity::Work;
use clearance::robot::{Configuration, MeshFiles, RobotModel};
use clearance::scene::Settings;
use clearance::scene::{SceneLoader, World};
use std::path::Path;
use std::sync::Arc;

use crate::random::Random;
use crate::random_world;
use crate::tally::{json, shared_folder};

const QUESTIONS: [Question; 8] = [
    Question::Free,
    Question::Pairs,
    Question::Distance { limit: 0.1 },
    Question::Distance { limit: f64::INFINITY },
    Question::SelfAndWorldDistance { limit: 0.3 },
    Question::SelfAndWorldDistance { limit: f64::INFINITY },
    Question::PairDistances { limit: 0.2 },
    Question::Survey { influence_distance: 0.05, limit: 1.0 },
];

/// The demo arm in its world, with padding; and the dual arm among planes, cones, points and voxels.
pub fn checkers() -> [CollisionChecker; 2] {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let load = |name: &str| {
        let path = |kind: &str| root.join(format!("urdf/{name}/{name}.{kind}"));
        Arc::new(RobotModel::load(&path("urdf"), Some(&path("srdf")), &[]).unwrap())
    };
    let arm = load("demo_arm");
    let text = std::fs::read_to_string(root.join("config/demo_world.yaml")).unwrap();
    let scene = SceneLoader::from_yaml(&text, "demo_world", &arm, &MeshFiles::default()).unwrap();
    let others = random_world::world(&mut Random::new(59), 1.2);
    let padded = Settings { padding: 0.01, pad_self: true, ..Settings::default() };
    [
        CollisionChecker::new(arm, &scene.scene.world, padded).unwrap(),
        CollisionChecker::new(load("dual_arm"), &others, Settings::default()).unwrap(),
    ]
}

pub fn random_state(checker: &CollisionChecker, random: &mut Random) -> Configuration {
    let robot = checker.robot();
    let positions: Vec<f64> = (robot.joint_ids())
        .filter(|j| robot.first_position(*j).is_some())
        .map(|j| robot.joint(j).limits.map_or(0.0, |l| random.within(l.lower, l.upper)))
        .collect();
    robot.configuration(&positions).unwrap()
}

/// Small steps from random states, and a jump now and then.
pub fn walk(
    checker: &CollisionChecker,
    random: &mut Random,
    jumps: usize,
    steps: usize,
) -> Vec<Configuration> {
    let mut states = Vec::new();
    for _ in 0..jumps {
        let mut state = random_state(checker, random);
        for _ in 0..steps {
            let moved: Vec<f64> =
                state.positions().iter().map(|q| q + random.within(-0.002, 0.002)).collect();
            state = checker.robot().configuration(&moved).unwrap();
            states.push(state.clone());
        }
    }
    states
}

fn without_work(report: CollisionReport) -> CollisionReport {
    CollisionReport { work: Work::default(), ..report }
}

fn ask(
    checker: &CollisionChecker,
    states: &[Configuration],
    question: Question,
    mut workspace: Workspace,
) -> (Vec<CollisionReport>, Work) {
    let mut work = Work::default();
    let mut answer = |q| {
        let report = checker.check(q, question, &mut workspace);
        work += report.work;
        without_work(report)
    };
    (states.iter().map(&mut answer).collect(), work)
}

#[test]
fn a_stream_has_the_reports_of_single_states_for_less_work() {
    let mut random = Random::new(60);
    for checker in checkers() {
        let states = walk(&checker, &mut random, 12, 60);
        for question in QUESTIONS {
            let (single, cost) = ask(&checker, &states, question, checker.workspace());
            let (streamed, less) = ask(&checker, &states, question, checker.streaming_workspace());
            for (i, (one, other)) in single.iter().zip(&streamed).enumerate() {
                assert_eq!(one, other, "{}: {question:?} of state {i}", checker.robot().name());
            }
            let distances = !matches!(question, Question::Free | Question::Pairs);
            assert!(
                !distances || less.volume_tests < cost.volume_tests,
                "{}: {question:?}: {less:?} streamed, {cost:?} one by one",
                checker.robot().name()
            );
        }
    }
}

/// Answers about one question do not spoil those about another, nor another checker's.
#[test]
fn a_stream_may_ask_anything_and_change_its_checker() {
    let mut random = Random::new(61);
    let checkers = checkers();
    let [twin, _] = self::checkers();
    let mut streaming = checkers[0].streaming_workspace();
    for (i, q) in walk(&checkers[0], &mut random, 6, 40).iter().enumerate() {
        let question = QUESTIONS[random.below(8) as usize];
        let single = checkers[0].check(q, question, &mut checkers[0].workspace());
        let asked = if i % 7 == 0 { &twin } else { &checkers[0] };
        let streamed = asked.check(q, question, &mut streaming);
        assert_eq!(without_work(single), without_work(streamed), "{question:?} of state {i}");
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let mut random = Random::new(62);
    for checker in checkers() {
        let states: Vec<_> = (0..60).map(|_| random_state(&checker, &mut random)).collect();
        for question in QUESTIONS {
            let best = ask(&checker, &states, question, checker.workspace());
            let portable = ask(&checker, &states, question, checker.portable_workspace());
            assert_eq!(best, portable, "{}: {question:?}", checker.robot().name());
        }
    }
}

#[test]
fn batches_are_the_same_for_any_number_of_threads() {
    let mut random = Random::new(63);
    for checker in checkers() {
        let states: Vec<_> = (0..1003).map(|_| random_state(&checker, &mut random)).collect();
        let mut workspace = checker.workspace();
        let free: Vec<bool> = states.iter().map(|q| checker.is_free(q, &mut workspace)).collect();
        assert!(free.contains(&true) && free.contains(&false));
        let question = Question::Distance { limit: 0.3 };
        let few = &states[..100];
        let reports: Vec<_> = few.iter().map(|q| checker.check(q, question, &mut workspace)).collect();
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| checker.are_free(&states)), free, "{threads} threads");
            assert_eq!(pool.install(|| checker.check_states(few, question)), reports, "{threads} threads");
        }
        let mut portable = vec![false; states.len()];
        checker.are_free_with(&states, &mut checker.portable_workspace(), &mut portable);
        assert_eq!(portable, free);
    }
}

/// The truth's walks, as a monitor would hear them: the same reports for a fraction of the work.
#[test]
fn streams_of_the_shared_walks() {
    let Some(truth) = shared_folder("truth") else { return };
    for name in ["ur5", "panda"] {
        let folder = truth.join(name);
        let robot =
            RobotModel::load(&folder.join("robot.urdf"), Some(&folder.join("robot.srdf")), &[]).unwrap();
        let checker = CollisionChecker::new(Arc::new(robot), &World::default(), Settings::default()).unwrap();
        let walks = json(&folder.join("walks.json"));
        let joints: Vec<_> =
            walks["joint_order"].as_array().unwrap().iter().map(|j| j.as_str().unwrap()).collect();
        let state = |q: &serde_json::Value| {
            let values = q.as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
            checker.robot().configuration_from_names(joints.iter().copied().zip(values)).unwrap()
        };
        let states: Vec<_> = walks["q"].as_array().unwrap().iter().take(2_500).map(state).collect();
        let question = Question::Distance { limit: 0.1 };
        let (single, cost) = ask(&checker, &states, question, checker.workspace());
        let (streamed, less) = ask(&checker, &states, question, checker.streaming_workspace());
        assert_eq!(single, streamed);
        eprintln!("{name}: {cost:?} one by one, {less:?} streamed");
        assert!(4 * less.volume_tests < 3 * cost.volume_tests);
    }
}

/// A workspace serves whatever checker it is given to: one of fewer pairs, of more, of another robot.
#[test]
fn a_workspace_suits_every_checker() {
    let mut random = Random::new(64);
    let [arm, dual] = checkers();
    let settings = Settings { check_world: false, ..arm.settings().clone() };
    let alone = CollisionChecker::new(arm.robot().clone(), arm.world(), settings).unwrap();
    let all = [&alone, &arm, &dual];
    let mut workspaces = [alone.workspace(), alone.streaming_workspace(), dual.workspace()];
    for i in 0..300 {
        let checker = all[random.below(3) as usize];
        let q = random_state(checker, &mut random);
        let workspace = &mut workspaces[i % 3];
        assert_eq!(checker.is_free(&q, workspace), checker.is_free(&q, &mut checker.workspace()));
        let question = QUESTIONS[random.below(8) as usize];
        let fresh = checker.check(&q, question, &mut checker.workspace());
        assert_eq!(without_work(checker.check(&q, question, workspace)), without_work(fresh));
    }
}
