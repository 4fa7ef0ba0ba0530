//! `cargo bench --bench gradients`: cost and error of the derivatives of signed distances, on the bundled robots and,
//! where the folder `../shared` exists, on real ones.
//!
//! Costs: pair distances, and the same with derivatives, in turn in one run, CPU time of the thread, least of the rounds. Errors:
//! derivatives of smooth pairs against differences of distances; `-- --pairs N` sets their number for each robot. Arguments that are names
//! select robots.

#[allow(dead_code)]
#[path = "../tests/it/gradients/differences.rs"]
mod differences;
#[allow(dead_code)]
#[path = "../tests/it/random.rs"]
mod random;
#[allow(dead_code)]
#[path = "robots/mod.rs"]
mod robots;

use std::hint::black_box;

use clearance::checker::{Clearance, ClearanceOptions, WitnessCount};
use clearance::{CollisionChecker, Configuration, Question};
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

fn random_states(checker: &CollisionChecker, random: &mut Random) -> Vec<Configuration> {
    (0..STATES).map(|_| robots::random_state(checker, random)).collect()
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
    let all = robots::all(&["ur5e", "panda", "pr2"]);
    let is_selected = |name: &&str| arguments.iter().any(|argument| argument == name);
    let is_any_selected = all.iter().any(|(name, _)| is_selected(name));
    for (name, robot) in &all {
        if is_any_selected && !is_selected(name) {
            continue;
        }
        let mut random = Random::new(7);
        let checker = robots::checker(robot, &mut random);
        if let Some(pairs) = pairs {
            errors(&checker, pairs, &mut random);
            continue;
        }
        let states = random_states(&checker, &mut random);
        let mut workspace = checker.workspace();
        let (free, hit): (Vec<_>, Vec<_>) =
            states.iter().cloned().partition(|q| checker.is_free(q, &mut workspace));
        costs(name, "free", &checker, &free);
        costs(name, "overlapping", &checker, &hit);
        witness_counts(&checker, &states);
    }
}
