//! `cargo bench --bench edges`: cost of `is_motion_free` on free and on colliding edges, compared with `check_motion`
//! in both orders.
//!
//! All three take the same edges in turn. Edges have the given length in joint space and start in free states; those
//! that collide do so with a free end (`passing`) or with a colliding end (`colliding`). CPU time of the thread (µs):
//! the mean of all edges, of the fastest of some passes. Robots of `../shared/robots` are measured where that folder
//! exists. Arguments select robots by name.

#[allow(dead_code)]
#[path = "../tests/it/random.rs"]
mod random;
#[allow(dead_code)]
#[path = "robots/mod.rs"]
mod robots;

use std::hint::black_box;

use clearance::checker::Workspace;
use clearance::{CollisionChecker, Configuration, MotionOptions, MotionOrder, MotionSegment, MotionVerdict};
use cpu_time::ThreadTime;
use random::Random;

/// Lengths of edges (rad, m).
const LENGTHS: [f64; 4] = [0.05, 0.1, 0.5, 2.0];

/// Number of edges of each kind.
const EDGES: usize = 300;

/// Number of random edges after which rare kinds are given up.
const ATTEMPTS: usize = 30_000;

const PASSES: usize = 15;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Free,
    /// Collides, but both ends are free.
    Passing,
    /// Collides at its end.
    Colliding,
}

const KINDS: [Kind; 3] = [Kind::Free, Kind::Passing, Kind::Colliding];

/// Edges of one kind.
#[derive(Default)]
struct Edges(Vec<MotionSegment>);

/// The configuration at this distance from `from`, in a random direction; limits do not matter.
fn goal(checker: &CollisionChecker, from: &Configuration, length: f64, random: &mut Random) -> Configuration {
    let way: Vec<f64> = from.positions().iter().map(|_| random.within(-1.0, 1.0)).collect();
    let norm = way.iter().map(|w| w * w).sum::<f64>().sqrt();
    let to: Vec<f64> = from.positions().iter().zip(&way).map(|(q, w)| q + w / norm * length).collect();
    checker.robot().configuration(&to).expect("near the limits")
}

/// Random edges of this length, by kind.
fn edges(checker: &CollisionChecker, length: f64, random: &mut Random) -> [Edges; 3] {
    let mut workspace = checker.workspace();
    let mut edges = KINDS.map(|_| Edges::default());
    for _ in 0..ATTEMPTS {
        let from = robots::random_state(checker, random);
        if !checker.is_free(&from, &mut workspace) {
            continue;
        }
        let to = goal(checker, &from, length, random);
        let kind = match checker.check_motion(&from, &to, &mut workspace).verdict {
            MotionVerdict::Free => Kind::Free,
            MotionVerdict::Contact { .. } if checker.is_free(&to, &mut workspace) => Kind::Passing,
            MotionVerdict::Contact { .. } => Kind::Colliding,
            MotionVerdict::Undecided { .. } => continue,
        };
        let Edges(of_kind) = &mut edges[kind as usize];
        if of_kind.len() < EDGES {
            of_kind.push(MotionSegment::straight(checker.robot(), &from, &to));
        }
        if edges.iter().all(|edges| edges.0.len() == EDGES) {
            break;
        }
    }
    edges
}

type Query = fn(&CollisionChecker, &MotionSegment, &mut Workspace) -> bool;

fn in_order(
    checker: &CollisionChecker,
    segment: &MotionSegment,
    order: MotionOrder,
    workspace: &mut Workspace,
) -> bool {
    let options = MotionOptions { order, ..MotionOptions::default() };
    checker.check_motion_with(segment, &options, workspace).is_free()
}

const QUERIES: [(&str, Query); 3] = [
    ("earliest", |checker, segment, workspace| in_order(checker, segment, MotionOrder::Earliest, workspace)),
    ("any", |checker, segment, workspace| in_order(checker, segment, MotionOrder::Any, workspace)),
    ("is_motion_free", |checker, segment, workspace| {
        checker.is_motion_free_with(segment, &MotionOptions::default(), workspace)
    }),
];

/// Mean time (µs) of each query on these edges.
#[allow(clippy::cast_precision_loss)] // few edges
fn measure(checker: &CollisionChecker, Edges(edges): &Edges) -> [f64; 3] {
    let mut workspaces = QUERIES.map(|_| checker.workspace());
    let mut best = [f64::INFINITY; 3];
    for pass in 0..PASSES {
        for turn in 0..3 {
            let which = (pass + turn) % 3;
            let start = ThreadTime::now();
            for edge in edges {
                black_box((QUERIES[which].1)(checker, edge, &mut workspaces[which]));
            }
            let time = start.elapsed().as_secs_f64() * 1e6 / edges.len() as f64;
            best[which] = best[which].min(time);
        }
    }
    best
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
            for (kind, edges) in KINDS.iter().zip(&edges(&checker, length, &mut random)) {
                if edges.0.is_empty() {
                    continue;
                }
                print!("{name:8} {length:4} rad {:3} {kind:9?}", edges.0.len());
                let times = measure(&checker, edges);
                for ((query, _), time) in QUERIES.iter().zip(times) {
                    print!("  {query} {time:7.2}");
                }
                let [earliest, any, own] = times;
                println!("  ratios {:.2} {:.2}", own / earliest, own / any);
            }
        }
    }
}
