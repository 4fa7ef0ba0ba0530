//! `cargo bench --bench along`: cost of `clearance_along` (least distance along a motion), with and without a limit
//! of 5 cm, compared with `check_motion` and with exact distances every 0.01 rad.
//!
//! Motions have the given length in joint space and start in free states. CPU time of the thread (µs): mean and median
//! of all motions, each the fastest of some passes; then the multiples of the time of `check_motion`, the evaluations of
//! pairs in intervals, and how many motions were not bounded within the tolerance. Robots of `../shared/robots` are
//! measured where that folder exists. Arguments select robots by name.

#[allow(dead_code)]
#[path = "../tests/it/random.rs"]
mod random;
#[allow(dead_code)]
#[path = "robots/mod.rs"]
mod robots;

use std::hint::black_box;

use clearance::checker::Workspace;
use clearance::{
    CollisionChecker, Configuration, MotionClearanceOptions, MotionOptions, MotionSegment, Question,
};
use cpu_time::ThreadTime;
use random::Random;

/// Lengths of motions (rad, m).
const LENGTHS: [f64; 3] = [0.05, 0.5, 2.0];

/// Number of free motions of each length.
const MOTIONS: usize = 150;

/// Number of random motions after which a length is given up.
const ATTEMPTS: usize = 20_000;

const PASSES: usize = 7;

/// Step (rad, m) of the exact distances.
const STEP: f64 = 0.01;

/// The configuration at this distance from `from`, in a random direction; limits do not matter.
fn goal(checker: &CollisionChecker, from: &Configuration, length: f64, random: &mut Random) -> Configuration {
    let way: Vec<f64> = from.positions().iter().map(|_| random.within(-1.0, 1.0)).collect();
    let norm = way.iter().map(|w| w * w).sum::<f64>().sqrt();
    let to: Vec<f64> = from.positions().iter().zip(&way).map(|(q, w)| q + w / norm * length).collect();
    checker.robot().configuration(&to).expect("near the limits")
}

/// Random free motions of this length.
fn motions(checker: &CollisionChecker, length: f64, random: &mut Random) -> Vec<MotionSegment> {
    let mut workspace = checker.workspace();
    let mut found = Vec::new();
    for _ in 0..ATTEMPTS {
        let from = robots::random_state(checker, random);
        if !checker.is_free(&from, &mut workspace) {
            continue;
        }
        let to = goal(checker, &from, length, random);
        if checker.check_motion(&from, &to, &mut workspace).is_free() {
            found.push(MotionSegment::straight(checker.robot(), &from, &to));
        }
        if found.len() == MOTIONS {
            break;
        }
    }
    found
}

type Query = fn(&CollisionChecker, &MotionSegment, f64, &mut Workspace);

/// Distances (m) beyond this are not searched by the query with a limit.
const LIMIT: f64 = 0.05;

const QUERIES: [(&str, Query); 4] = [
    ("check_motion", |checker, segment, _, workspace| {
        black_box(checker.check_motion_with(segment, &MotionOptions::default(), workspace));
    }),
    ("clearance_along", |checker, segment, _, workspace| {
        black_box(checker.clearance_along(segment, &MotionClearanceOptions::default(), workspace));
    }),
    ("with limit", |checker, segment, _, workspace| {
        let options = MotionClearanceOptions { limit: LIMIT, ..MotionClearanceOptions::default() };
        black_box(checker.clearance_along(segment, &options, workspace));
    }),
    ("distances", |checker, segment, length, workspace| {
        let question = Question::SelfAndWorldDistance { limit: f64::INFINITY };
        let mut t = 0.0;
        while t < 1.0 + STEP / length {
            black_box(checker.check(&segment.at(t.min(1.0)), question, workspace));
            t += STEP / length;
        }
    }),
];

/// The fastest time (µs) of each query on each motion.
fn measure(checker: &CollisionChecker, motions: &[MotionSegment], length: f64) -> [Vec<f64>; 4] {
    let mut workspaces = QUERIES.map(|_| checker.workspace());
    let mut best = QUERIES.map(|_| vec![f64::INFINITY; motions.len()]);
    for pass in 0..PASSES {
        for turn in 0..4 {
            let which = (pass + turn) % 4;
            if which == 3 && pass > 1 {
                continue;
            }
            for (segment, best) in motions.iter().zip(&mut best[which]) {
                let start = ThreadTime::now();
                (QUERIES[which].1)(checker, segment, length, &mut workspaces[which]);
                *best = best.min(start.elapsed().as_secs_f64() * 1e6);
            }
        }
    }
    best
}

#[allow(clippy::cast_precision_loss)] // few motions
fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// Prints the evaluations per motion, and the number of motions without a result within the tolerance.
#[allow(clippy::cast_precision_loss)] // few evaluations
fn print_evaluations(checker: &CollisionChecker, motions: &[MotionSegment]) {
    let mut workspace = checker.workspace();
    let options = MotionClearanceOptions::default();
    let found: Vec<_> =
        motions.iter().map(|segment| checker.clearance_along(segment, &options, &mut workspace)).collect();
    let evaluations: Vec<f64> = found.iter().map(|found| found.evaluations as f64).collect();
    let unfinished = found.iter().filter(|found| found.unfinished.is_some()).count();
    println!(
        "  evaluations {:.1} median {:.0}  unfinished {unfinished}",
        mean(&evaluations),
        median(&evaluations)
    );
}

fn main() {
    let selected: Vec<String> = std::env::args().skip(1).filter(|name| !name.starts_with("--")).collect();
    for (name, robot) in robots::all(&["ur5e", "panda", "g1"]) {
        if !selected.is_empty() && !selected.iter().any(|other| other == name) {
            continue;
        }
        let mut random = Random::new(7);
        let checker = robots::checker(&robot, &mut random);
        for length in LENGTHS {
            let motions = motions(&checker, length, &mut random);
            if motions.is_empty() {
                continue;
            }
            print!("{name:8} {length:4} rad {:3}", motions.len());
            let times = measure(&checker, &motions, length);
            for ((query, _), times) in QUERIES.iter().zip(&times) {
                print!("  {query} {:.1} median {:.1}", mean(times), median(times));
            }
            for (which, what) in [(1, "multiple"), (2, "with limit")] {
                print!(
                    "  {what} {:.1} median {:.1}",
                    mean(&times[which]) / mean(&times[0]),
                    median(&times[which]) / median(&times[0])
                );
            }
            print_evaluations(&checker, &motions);
        }
    }
}
