//! `cargo bench --bench survey`: cost of the monitor's query on a stream of states at 1 kHz, in rooms of different content.
//!
//! `pairs` is the part of the query that reports the pairs within the influence distance, and the least distance where there are none.
//! `survey` is the whole query, with the least distances of self pairs and of world pairs. Both take the same states in turn, each with
//! its own stream, prepared between states as in the node. CPU time of the thread (µs); ratios are what counts. Robots of `../shared/robots` are
//! measured where that folder exists. Arguments select robots by name.

#[allow(dead_code)]
#[path = "../tests/it/random.rs"]
mod random;
#[allow(dead_code)]
#[path = "robots/mod.rs"]
mod robots;

use std::hint::black_box;

use clearance::checker::Workspace;
use clearance::geometry::math::{Pose, Vector};
use clearance::geometry::{Primitive, Shape};
use clearance::proximity::Effort;
use clearance::scene::Obstacle;
use clearance::{CollisionChecker, Configuration, Question, RobotModel, Settings, World};
use cpu_time::ThreadTime;
use random::Random;

const STATES: u32 = 3000;
/// Time (s) between states.
const PERIOD: f64 = 1e-3;
/// Parameters of the node by default (m).
const INFLUENCE: f64 = 0.1;
const LIMIT: f64 = 1.0;

/// As the node sets it at 1 kHz.
const BUDGET: Effort = Effort {
    relative_tolerance: 0.1,
    absolute_tolerance: 0.001,
    exact_within: 0.0,
    exact_cost: 2000,
    deadline: None,
};

/// A floor and boxes around it; with a cloud, points on a wall, too.
fn room(boxes: usize, points: u32, random: &mut Random) -> World {
    let mut world = World::default();
    let mut add = |name: String, pose: Pose, shape: Shape| {
        world.add(Obstacle::of_shape(name, pose, shape)).expect("names differ");
    };
    let cuboid = |size: [f64; 3]| Shape::Primitive(Primitive::cuboid(size).expect("sizes are positive"));
    add("floor".to_owned(), Pose::translation(0.0, 0.0, -1.2), cuboid([6.0, 6.0, 0.1]));
    for i in 0..boxes {
        let away = Vector::new(random.within(-1.0, 1.0), random.within(-1.0, 1.0), random.within(-0.6, 0.8));
        let place = away.normalize() * random.within(0.7, 1.6);
        let size = [random.within(0.05, 0.3), random.within(0.05, 0.3), random.within(0.05, 0.3)];
        add(format!("box{i}"), Pose::from_parts(place.into(), random.rotation()), cuboid(size));
    }
    if points > 0 {
        add("wall".to_owned(), Pose::translation(0.9, 0.0, 0.3), random.points(points, 0.5, 0.01));
    }
    world
}

/// A swing of all joints around the middle of their ranges, each at its own rate.
fn swing(robot: &RobotModel, random: &mut Random) -> Vec<Configuration> {
    let joints: Vec<_> = (robot.joint_ids())
        .filter(|joint| robot.first_position(*joint).is_some())
        .map(|joint| {
            let range =
                robot.joint(joint).limits.map_or([-1.5, 1.5], |l| [l.lower.max(-3.0), l.upper.min(3.0)]);
            (range, random.within(0.1, 0.5), random.within(0.0, 6.0))
        })
        .collect();
    let position = |time: f64, &([lower, upper], rate, phase): &([f64; 2], f64, f64)| {
        0.5 * (lower + upper) + 0.2 * (upper - lower) * (rate * time * std::f64::consts::TAU + phase).sin()
    };
    (0..STATES)
        .map(|i| {
            let time = f64::from(i) * PERIOD;
            let positions: Vec<f64> = joints.iter().map(|joint| position(time, joint)).collect();
            robot.configuration(&positions).expect("within limits")
        })
        .collect()
}

fn pairs(checker: &CollisionChecker, q: &Configuration, effort: &Effort, stream: &mut Workspace) {
    let near = checker.check_with(q, Question::PairDistances { limit: INFLUENCE }, effort, stream);
    if near.nearest.is_none() {
        black_box(checker.check_with(q, Question::Distance { limit: LIMIT }, effort, stream));
    }
}

fn survey(checker: &CollisionChecker, q: &Configuration, effort: &Effort, stream: &mut Workspace) {
    let question = Question::Survey { influence_distance: INFLUENCE, limit: LIMIT };
    black_box(checker.check_with(q, question, effort, stream));
}

type Query = fn(&CollisionChecker, &Configuration, &Effort, &mut Workspace);

#[allow(clippy::cast_precision_loss)] // few states
fn measure(checker: &CollisionChecker, states: &[Configuration], effort: &Effort) {
    let queries: [Query; 2] = [pairs, survey];
    let mut streams = queries.map(|_| checker.streaming_workspace());
    let mut times = queries.map(|_| Vec::with_capacity(states.len()));
    for (i, q) in states.iter().enumerate() {
        for which in [i % 2, 1 - i % 2] {
            let start = ThreadTime::now();
            queries[which](checker, q, effort, &mut streams[which]);
            times[which].push(start.elapsed().as_secs_f64() * 1e6);
            checker.prepare(&mut streams[which]);
        }
    }
    let columns = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        [mean, times[times.len() / 2], times[times.len() * 99 / 100]]
    });
    for (name, [mean, median, p99]) in ["pairs", "survey"].iter().zip(columns) {
        print!("  {name} {mean:7.1} mean {median:7.1} median {p99:7.1} p99;");
    }
    println!("  {:.2} times the mean", columns[1][0] / columns[0][0]);
}

fn main() {
    let selected: Vec<String> = std::env::args().skip(1).filter(|name| !name.starts_with("--")).collect();
    for (name, robot) in robots::all(&["panda", "ur5e", "g1"]) {
        if !selected.is_empty() && !selected.iter().any(|other| other == name) {
            continue;
        }
        for (boxes, points) in [(0, 0), (20, 0), (200, 0), (20, 5000)] {
            let mut random = Random::new(11);
            let world = if boxes == 0 { World::default() } else { room(boxes, points, &mut random) };
            let checker = CollisionChecker::new(robot.clone(), &world, Settings::default())
                .expect("settings are sound");
            let states = swing(&robot, &mut random);
            for (words, effort) in [("exact", Effort::default()), ("budget", BUDGET)] {
                print!("{name:8} {boxes:3} boxes {points:4} points {words:6}");
                measure(&checker, &states, &effort);
            }
        }
    }
}
