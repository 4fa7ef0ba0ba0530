//! Test helper: small random robots, their collision matrices, and collisions of a pair of links in a state.

use std::fmt::Write;
use std::sync::Arc;

use clearance::checker::{CollisionChecker, Question, Workspace};
use clearance::collision_matrix::{DecidedPair, MatrixBuilder, MatrixOptions};
use clearance::robot::{Configuration, MeshFiles, RobotModel};
use clearance::scene::{AllowedCollisionMatrix, BodyId, Settings, World};
use fastrand::Rng;

/// URDF of a chain or tree of links with boxes, spheres and cylinders, and two or three joints of any kind; one may be a mimic joint.
pub fn urdf(seed: u64) -> String {
    let mut random = Rng::with_seed(seed);
    let joints = random.usize(2..=3);
    let mut text = String::from("<robot name='small'>");
    for link in 0..=joints {
        let mut size = || 0.04 + 0.2 * random.f64();
        let [x, y, z] = [size(), size(), size()];
        let shape = match random.u8(0..4) {
            0 => format!("<sphere radius='{}'/>", 0.5 * x),
            1 => format!("<cylinder radius='{}' length='{z}'/>", 0.5 * x),
            _ => format!("<box size='{x} {y} {z}'/>"),
        };
        let at = offset(&mut random, 0.1);
        write!(text, "<link name='l{link}'><collision>{at}<geometry>{shape}</geometry></collision></link>")
            .unwrap();
    }
    for joint in 1..=joints {
        let parent = if random.u8(0..4) == 0 { random.usize(0..joint) } else { joint - 1 };
        let kind = ["revolute", "revolute", "continuous", "prismatic"][random.usize(0..4)];
        let half = if kind == "prismatic" { 0.15 } else { 2.5 };
        let (low, high) = (-half * random.f64(), half * random.f64());
        let axis: [i8; 3] = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]][random.usize(0..4)];
        let at = offset(&mut random, if joint == 1 { 0.14 } else { 0.3 });
        let mimic = if joint == 3 && kind == "revolute" && random.bool() {
            "<mimic joint='j1' multiplier='-0.7' offset='0.1'/>"
        } else {
            ""
        };
        let [x, y, z] = axis;
        write!(
            text,
            "<joint name='j{joint}' type='{kind}'><parent link='l{parent}'/><child link='l{joint}'/>{at}
            <axis xyz='{x} {y} {z}'/><limit lower='{low}' upper='{high}' effort='1' velocity='1'/>{mimic}</joint>"
        )
        .unwrap();
    }
    text + "</robot>"
}

fn offset(random: &mut Rng, half: f64) -> String {
    let mut number = |half: f64| half * (2.0 * random.f64() - 1.0);
    let [x, y, z] = [number(half), number(half), number(half)];
    format!("<origin xyz='{x} {y} {z}' rpy='{} {} 0'/>", number(1.5), number(1.5))
}

/// The robot, if its limits do not contradict each other.
pub fn robot(urdf: &str) -> Arc<RobotModel> {
    Arc::new(RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap_or_else(|e| panic!("{e}")))
}

/// Decisions about all pairs on some threads.
pub fn decide(robot: &Arc<RobotModel>, threads: usize) -> Vec<DecidedPair> {
    let builder = MatrixBuilder::new(robot, &Settings::default()).unwrap();
    let options = MatrixOptions { most_boxes: 30_000, ..MatrixOptions::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| builder.decide(&[], &options, &|_| {}))
}

/// A checker of all pairs.
pub struct PairOracle {
    checker: CollisionChecker,
    workspace: Workspace,
}

impl PairOracle {
    pub fn new(robot: &Arc<RobotModel>) -> Self {
        let all = AllowedCollisionMatrix::default();
        let settings = Settings::default();
        let checker =
            CollisionChecker::with_matrix(Arc::clone(robot), &World::default(), settings, Some(&all))
                .unwrap();
        let workspace = checker.workspace();
        Self { checker, workspace }
    }

    /// Names of the links that collide.
    pub fn colliding(&mut self, q: &Configuration) -> Vec<[String; 2]> {
        let report = self.checker.check(q, Question::Pairs, &mut self.workspace);
        let name = |body: BodyId| self.checker.body_name(body).to_owned();
        report.colliding_pairs.into_iter().map(|(a, b)| [name(a), name(b)]).collect()
    }

    pub fn collides(&mut self, pair: &DecidedPair, state: &[f64]) -> bool {
        let q = self.checker.robot().configuration(state).unwrap();
        self.colliding(&q).iter().any(|[a, b]| pair.is_of(a, b))
    }

    /// Distance (m) of a pair; zero in contact.
    pub fn distance(&mut self, pair: &DecidedPair, state: &[f64]) -> f64 {
        let q = self.checker.robot().configuration(state).unwrap();
        let report = self.checker.check(&q, Question::PairDistances { limit: 10.0 }, &mut self.workspace);
        let is_pair = |a: BodyId, b: BodyId| pair.is_of(self.checker.body_name(a), self.checker.body_name(b));
        if report.colliding_pairs.iter().any(|(a, b)| is_pair(*a, *b)) {
            return 0.0;
        }
        let found = report.pair_distances.iter().find(|found| is_pair(found.a, found.b));
        found.map_or(f64::INFINITY, |found| found.distance)
    }
}
