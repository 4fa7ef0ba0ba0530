//! Benchmark queries only for this library: batches, streams, level 0, and memory of the hierarchies.

use std::hint::black_box;

use clearance::{CollisionChecker, Configuration, Question};
use cpu_time::ProcessTime;

use crate::answer::Answer;

/// Passes over the states for the time of level 0; the fastest counts.
const PASSES: usize = 20;

/// Whether each state is free, on one thread.
pub fn batch(checker: &CollisionChecker, states: &[Configuration]) -> Vec<bool> {
    let mut free = vec![false; states.len()];
    checker.are_free_with(states, &mut checker.workspace(), &mut free);
    free
}

/// The least distance within `limit` of successive states, each helped by the last; the stream begins cold.
pub fn stream(checker: &CollisionChecker, states: &[Configuration], limit: f64) -> Vec<Answer> {
    let mut workspace = checker.streaming_workspace();
    let ask = |q| checker.check(q, Question::Distance { limit }, &mut workspace);
    states.iter().map(ask).map(|report| Answer::Distance(report.nearest.map(|n| n.distance))).collect()
}

/// CPU time (ns) a state of kinematics and capsules alone.
#[allow(clippy::cast_precision_loss)] // counts of states
pub fn level_0_nanoseconds(checker: &CollisionChecker, states: &[Configuration]) -> f64 {
    let mut workspace = checker.workspace();
    let pass = |_| {
        let start = ProcessTime::now();
        for _ in 0..PASSES {
            black_box(checker.count_near_pairs(states, &mut workspace));
        }
        start.elapsed().as_secs_f64() * 1e9 / (PASSES * states.len().max(1)) as f64
    };
    (0..PASSES).map(pass).fold(f64::INFINITY, f64::min)
}

/// Bytes of all hierarchies, triangles included.
pub fn hierarchy_bytes(checker: &CollisionChecker) -> usize {
    checker.hierarchy_size().0
}
