//! Test helper: results of the Rust library as text, for comparison with those of a C++ program.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use clearance::checker::PairKind;
use clearance::scene::BodyId;
use clearance::{
    CollisionChecker, MotionVerdict, PairDistance, Question, RobotModel, SceneLoader, Settings, Workspace,
};

use crate::root;

const STATES: usize = 200;
const EDGES: usize = 60;
/// Length of the edges relative to the way to another random state.
const SHARE: f64 = 0.2;

/// Random states of the arm and motions between them, and what the library says about them: as `truth.cpp` reads it.
pub fn text() -> String {
    let (checker, robot) = checker();
    let mut workspace = checker.workspace();
    let mut random = fastrand::Rng::with_seed(11);
    let n = 7;
    let mut text = format!("{n} {STATES} {EDGES}\n");
    let mut rows = Vec::new();
    for _ in 0..STATES {
        let sampled = robot.random_configuration(&mut random);
        // the fingers stay at their default
        let mut row = robot.default_configuration().positions().to_vec();
        row[..n].copy_from_slice(&sampled.positions()[..n]);
        add_state(&mut text, &checker, &row, n, &mut workspace);
        rows.push(row);
    }
    for ends in rows.windows(2).take(EDGES) {
        let to: Vec<f64> = ends[0].iter().zip(&ends[1]).map(|(a, b)| a + SHARE * (b - a)).collect();
        add_edge(&mut text, &checker, [&ends[0], &to], n, &mut workspace);
    }
    text
}

/// The demo arm in its world, with a padding of 1 cm.
pub fn checker() -> (CollisionChecker, Arc<RobotModel>) {
    let file = |name: &str| root().join(name);
    let (urdf, srdf) = (file("urdf/demo_arm/demo_arm.urdf"), file("urdf/demo_arm/demo_arm.srdf"));
    let robot = RobotModel::load(&urdf, Some(&srdf), &[]).expect("the robot is sound");
    let mut loader = SceneLoader::default();
    let bytes = std::fs::read(file("config/demo_world.yaml")).expect("there is a world");
    let none = clearance::MeshFiles::default();
    loader.read_file(&bytes, Path::new("demo_world.yaml"), None, &robot, &none).expect("the world is sound");
    let scene = loader.into_scene();
    let settings = Settings { padding: 0.01, ..Settings::default() }.with_scene(&scene);
    let robot = Arc::new(robot);
    let checker =
        CollisionChecker::with_matrix(Arc::clone(&robot), &scene.world, settings, scene.matrix.as_ref());
    (checker.expect("the settings are sound"), robot)
}

fn numbers(values: &[f64]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

fn names(checker: &CollisionChecker, pair: Option<(BodyId, BodyId)>) -> String {
    pair.map_or_else(
        || "- -".to_owned(),
        |(a, b)| format!("{} {}", checker.body_name(a), checker.body_name(b)),
    )
}

fn add_state(
    text: &mut String,
    checker: &CollisionChecker,
    row: &[f64],
    n: usize,
    workspace: &mut Workspace,
) {
    let q = checker.robot().configuration(row).expect("the state is sound");
    let report = checker.check(&q, Question::SelfAndWorldDistance { limit: 0.3 }, workspace);
    let near = |found: Option<&PairDistance>| {
        let distance = found.map_or(f64::INFINITY, |found| found.distance);
        format!("{distance} {}", names(checker, found.map(|found| (found.a, found.b))))
    };
    let [of_self, of_world] = PairKind::ALL.map(|kind| near(report.nearest_of(kind)));
    let is_free = checker.is_free(&q, workspace);
    let _ = writeln!(text, "{} {is_free} {of_self} {of_world}", numbers(&row[..n]));
}

fn add_edge(
    text: &mut String,
    checker: &CollisionChecker,
    ends: [&[f64]; 2],
    n: usize,
    workspace: &mut Workspace,
) {
    let [from, to] = ends.map(|row| checker.robot().configuration(row).expect("the state is sound"));
    let report = checker.check_motion(&from, &to, workspace);
    let (verdict, t, pair) = match report.verdict {
        MotionVerdict::Free => (1, [f64::NAN; 2], None),
        MotionVerdict::Contact { t, pair, .. } => (0, t, Some(pair)),
        MotionVerdict::Undecided { t, pair, .. } => (-1, t, pair),
    };
    let (from, to) = (numbers(&ends[0][..n]), numbers(&ends[1][..n]));
    let _ = writeln!(text, "{from} {to} {verdict} {} {}", numbers(&t), names(checker, pair));
}
