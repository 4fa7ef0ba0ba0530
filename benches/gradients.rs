//! `cargo bench --bench gradients`: derivatives of signed distances, on the bundled robots and, where the folder `../shared` exists,
//! on real ones.
//!
//! Costs: pair distances, and the same with derivatives, in turn in one run, CPU time of the thread, least of the rounds. Errors:
//! derivatives of smooth pairs against differences of distances; `-- --pairs N` sets their number for each robot.

#[allow(dead_code)]
#[path = "../tests/it/gradients/differences.rs"]
mod differences;
#[allow(dead_code)]
#[path = "../tests/it/random.rs"]
mod random;

use std::collections::HashMap;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clearance::checker::{Clearance, ClearanceOptions, WitnessCount};
use clearance::geometry::math::Vector;
use clearance::scene::BodyId;
use clearance::{
    AllowedCollisionMatrix, CollisionChecker, Configuration, Obstacle, Primitive, Question, RobotModel,
    Settings, Shape, World,
};
use cpu_time::ThreadTime;
use rayon::prelude::*;

use differences::{Compared, Comparison};
use random::Random;

const ROUNDS: usize = 9;
const STATES: usize = 400;

/// Distance (m) up to which pairs are reported.
const INFLUENCE: f64 = 0.1;

/// Distance (m) from which rows are compared with differences: nearer bodies need shorter steps than the noise of their distances allows.
const NEAREST: f64 = 0.03;

/// Robots of the folder `../shared` with their packages' folder.
const SHARED: [(&str, &str); 3] = [
    ("ur_description/urdf/ur5e", "ur_description/srdf/ur5e"),
    ("moveit_resources_panda_description/urdf/panda", "moveit_resources_panda_description/srdf/panda"),
    ("moveit_resources_pr2_description/urdf/pr2", "moveit_resources_pr2_description/srdf/pr2"),
];

fn robots() -> Vec<Arc<RobotModel>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let bundled = ["demo_arm", "dual_arm"].map(|name| root.join(format!("urdf/{name}/{name}")));
    let own = bundled.into_iter().map(|stem| (stem.clone(), stem, root.to_path_buf()));
    let folder = root.join("../shared/robots");
    let shared = SHARED.map(|(urdf, srdf)| (folder.join(urdf), folder.join(srdf), folder.clone()));
    let shared = shared.into_iter().filter(|(urdf, ..)| urdf.with_extension("urdf").exists());
    own.chain(shared).map(|(urdf, srdf, packages)| load(&urdf, &srdf, packages)).collect()
}

fn load(urdf: &Path, srdf: &Path, packages: PathBuf) -> Arc<RobotModel> {
    let (urdf, srdf) = (urdf.with_extension("urdf"), srdf.with_extension("srdf"));
    Arc::new(RobotModel::load(&urdf, Some(&srdf), &[packages]).expect("the robot loads"))
}

/// Boxes, balls and cylinders around a robot, not at its root.
fn surroundings(random: &mut Random) -> World {
    let mut world = World::default();
    for i in 0..8 {
        let shape = match i % 3 {
            0 => Primitive::cuboid([0.1, 0.15, 0.2]),
            1 => Primitive::sphere(0.08),
            _ => Primitive::cylinder(0.06, 0.2),
        };
        let shape = Shape::Primitive(shape.expect("valid sizes"));
        let mut pose = random.pose(1.0);
        let (sin, cos) = (f64::from(i) * 0.8).sin_cos();
        pose.translation.vector = Vector::new(0.8 * cos, 0.8 * sin, random.within(0.0, 1.2));
        world.add(Obstacle::of_shape(format!("obstacle {i}"), pose, shape)).expect("names differ");
    }
    world
}

/// As a setup assistant does: pairs of links that collide in most states are allowed to.
fn checker(robot: &Arc<RobotModel>, world: &World, random: &mut Random) -> CollisionChecker {
    let build = |matrix: Option<&AllowedCollisionMatrix>| {
        CollisionChecker::with_matrix(Arc::clone(robot), world, Settings::default(), matrix)
            .expect("valid settings")
    };
    let checker = build(None);
    let mut counts: HashMap<(BodyId, BodyId), usize> = HashMap::new();
    let states = random_states(&checker, random);
    for report in checker.check_states(&states, Question::Pairs) {
        report.colliding_pairs.iter().for_each(|pair| *counts.entry(*pair).or_default() += 1);
    }
    let mut matrix = AllowedCollisionMatrix::from_srdf(robot);
    for ((a, b), count) in counts {
        if 10 * count > states.len() && matches!(b, BodyId::Link(_)) {
            matrix.set(checker.body_name(a), checker.body_name(b), true);
        }
    }
    build(Some(&matrix))
}

fn random_states(checker: &CollisionChecker, random: &mut Random) -> Vec<Configuration> {
    let robot = checker.robot();
    let state = |_| {
        let mut positions = robot.default_configuration().positions().to_vec();
        for joint in robot.joint_ids() {
            let Some(first) = robot.first_position(joint) else { continue };
            let (low, high) =
                robot.joint(joint).limits.map_or((-3.0, 3.0), |limits| (limits.lower, limits.upper));
            positions[first] = random.within(low, high);
        }
        robot.configuration(&positions).expect("within limits")
    };
    (0..STATES).map(state).collect()
}

/// Microseconds a state of each contestant: the least of the rounds, in which all take their turn.
#[allow(clippy::cast_precision_loss)] // few states
fn race<const N: usize>(states: usize, mut contestants: [&mut dyn FnMut(); N]) -> [f64; N] {
    let mut times = [f64::INFINITY; N];
    for _ in 0..ROUNDS {
        for (pass, least) in contestants.iter_mut().zip(&mut times) {
            let start = ThreadTime::now();
            pass();
            *least = least.min(start.elapsed().as_secs_f64() * 1e6 / states as f64);
        }
    }
    times
}

fn costs(name: &str, kind: &str, checker: &CollisionChecker, states: &[Configuration]) {
    if states.is_empty() {
        return println!("{name:10} {kind:12} no states");
    }
    let question = Question::PairDistances { limit: INFLUENCE };
    let (flag, all) = (
        ClearanceOptions::new(INFLUENCE),
        ClearanceOptions { most_candidates: 64, ..ClearanceOptions::new(INFLUENCE) },
    );
    let [mut one, mut two, mut three, mut four] = [(); 4].map(|()| checker.workspace());
    let mut reused = Clearance::default();
    let pairs: usize = states.iter().map(|q| checker.clearance(q, INFLUENCE, &mut one).pairs.len()).sum();
    let [distances, gradients, into, candidates] = race(
        states.len(),
        [
            &mut || states.iter().for_each(|q| drop(black_box(checker.check(q, question, &mut one)))),
            &mut || states.iter().for_each(|q| drop(black_box(checker.clearance(q, INFLUENCE, &mut two)))),
            &mut || {
                for q in states {
                    checker.clearance_into(q, &flag, &mut three, black_box(&mut reused));
                }
            },
            &mut || states.iter().for_each(|q| drop(black_box(checker.clearance_with(q, &all, &mut four)))),
        ],
    );
    let more = |time: f64| 100.0 * (time / distances - 1.0);
    #[allow(clippy::cast_precision_loss)] // few pairs
    let pairs = pairs as f64 / states.len() as f64;
    println!(
        "{name:10} {kind:12} {:4} states, {pairs:5.1} pairs: distances {distances:9.3} µs, with gradients {gradients:9.3} ({:+.1} %), \
         into {into:9.3} ({:+.1} %), with candidates {candidates:9.3} ({:+.1} %)",
        states.len(),
        more(gradients),
        more(into),
        more(candidates)
    );
}

/// Compares rows with differences for this number of smooth pairs that do not overlap.
fn errors(checker: &CollisionChecker, pairs: usize, random: &mut Random) {
    let mut total = Comparison::default();
    while total.pairs < pairs {
        let states = random_states(checker, random);
        let each = states.par_iter().map_init(
            || checker.workspace(),
            |workspace, q| Comparison::of_state(checker, q, INFLUENCE, Compared::Free(NEAREST), workspace),
        );
        total = each.reduce(
            || total,
            |mut sum, other| {
                sum.add(&other);
                sum
            },
        );
    }
    println!("{:10} {total:?}", checker.robot().name());
}

fn witness_counts(checker: &CollisionChecker, states: &[Configuration]) {
    let mut workspace = checker.workspace();
    let (mut one, mut several, mut unknown) = (0, 0, 0);
    for pair in states.iter().flat_map(|q| checker.clearance(q, INFLUENCE, &mut workspace).pairs) {
        match pair.witnesses {
            WitnessCount::One => one += 1,
            WitnessCount::Several => several += 1,
            WitnessCount::Unknown => unknown += 1,
        }
    }
    println!("{:10} witness pairs: one {one}, several {several}, unknown {unknown}", checker.robot().name());
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let pairs = arguments.iter().skip_while(|argument| *argument != "--pairs").nth(1);
    let pairs: Option<usize> = pairs.map(|count| count.parse().expect("--pairs takes a number"));
    for robot in robots() {
        let mut random = Random::new(7);
        let world = surroundings(&mut random);
        let checker = checker(&robot, &world, &mut random);
        if let Some(pairs) = pairs {
            errors(&checker, pairs, &mut random);
            continue;
        }
        let states = random_states(&checker, &mut random);
        let mut workspace = checker.workspace();
        let (free, hit): (Vec<_>, Vec<_>) =
            states.iter().cloned().partition(|q| checker.is_free(q, &mut workspace));
        costs(robot.name(), "free", &checker, &free);
        costs(robot.name(), "overlapping", &checker, &hit);
        witness_counts(&checker, &states);
    }
}
