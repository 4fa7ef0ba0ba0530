//! `cargo bench --bench solid_meshes`: times of `--mesh solid` compared with `--mesh surface` for states, streams of
//! states and motions where no body is inside another.
//!
//! Both answer the same states in turn. CPU time of the thread (µs), best of the rounds; pin it to one core with `taskset -c 1`. Robots of
//! `../shared/robots` are measured where that folder exists.

#[allow(dead_code)]
#[path = "../../tests/it/random.rs"]
mod random;
#[allow(dead_code)]
#[path = "../robots/mod.rs"]
mod robots;
mod surroundings;

use std::hint::black_box;
use std::sync::Arc;

use clearance::checker::{MotionOptions, Workspace};
use clearance::motion::MotionSegment;
use clearance::scene::MeshModel;
use clearance::{CollisionChecker, Configuration, Question, RobotModel, Settings, World};
use cpu_time::ThreadTime;

use random::Random;

const ROUNDS: usize = 11;
const STATES: usize = 100;
const MOTIONS: usize = 20;

/// States a thousandth of a second apart, through some of the given ones.
fn succession(robot: &RobotModel, through: &[Configuration]) -> Vec<Configuration> {
    let mut states = Vec::new();
    for ends in through.windows(2).take(STATES / 50) {
        for i in 0..200 {
            let share = f64::from(i) / 2000.0;
            let mixed = ends[0].positions().iter().zip(ends[1].positions()).map(|(p, q)| p + (q - p) * share);
            states.push(robot.configuration(&mixed.collect::<Vec<_>>()).expect("within limits"));
        }
    }
    states
}

/// Best CPU times of two passes in turn: surface, solid (µs per item).
#[allow(clippy::cast_precision_loss)] // few items
fn race(count: usize, passes: [&mut dyn FnMut(); 2]) -> [f64; 2] {
    let mut best = [f64::INFINITY; 2];
    let [surface, solid] = passes;
    for _ in 0..ROUNDS {
        for (pass, best) in [&mut *surface as &mut dyn FnMut(), &mut *solid].into_iter().zip(&mut best) {
            let start = ThreadTime::now();
            pass();
            *best = best.min(start.elapsed().as_secs_f64() * 1e6 / count as f64);
        }
    }
    best
}

fn print_row(row: &str, [surface, solid]: [f64; 2]) {
    println!("| {row} | {surface:.3} | {solid:.3} | {:.3} |", solid / surface);
}

/// A robot in its surroundings with meshes as surfaces, and with meshes as solids.
struct Comparison {
    title: String,
    surface: CollisionChecker,
    solid: CollisionChecker,
    /// Random states.
    any: Vec<Configuration>,
    /// States that are free for both.
    free: Vec<Configuration>,
}

impl Comparison {
    fn new(title: String, robot: &Arc<RobotModel>, world: &World, check_self: bool) -> Self {
        let checker = |mesh_model| {
            let settings = Settings { mesh_model, check_self, ..Settings::default() };
            CollisionChecker::new(Arc::clone(robot), world, settings).expect("settings are sound")
        };
        let (surface, solid) = (checker(MeshModel::Surface), checker(MeshModel::Solid));
        let random = &mut Random::new(7);
        let mut any: Vec<_> = (0..20_000).map(|_| robots::random_state(&solid, random)).collect();
        let mut workspace = solid.workspace();
        let free = any.iter().filter(|q| solid.is_free(q, &mut workspace)).take(STATES).cloned().collect();
        any.truncate(STATES);
        Self { title, surface, solid, any, free }
    }

    /// Both pass over the same `count` items in turn, each with a workspace of its own.
    fn row(&self, name: &str, count: usize, pass: impl Fn(&CollisionChecker, &mut Workspace)) {
        let [mut a, mut b] = [&self.surface, &self.solid].map(CollisionChecker::workspace);
        let times = race(count, [&mut || pass(&self.surface, &mut a), &mut || pass(&self.solid, &mut b)]);
        print_row(&format!("{} | {name}", self.title), times);
    }

    fn states(&self) {
        self.row("boolean, any state", self.any.len(), |checker, workspace| {
            self.any.iter().for_each(|q| _ = black_box(checker.is_free(q, workspace)));
        });
        for (name, question) in [
            ("boolean", Question::Free),
            ("pairs", Question::Pairs),
            ("distance", Question::Distance { limit: f64::INFINITY }),
            ("distance within 0.1 m", Question::Distance { limit: 0.1 }),
        ] {
            self.row(&format!("{name}, free states"), self.free.len(), |checker, workspace| {
                self.free.iter().for_each(|q| _ = black_box(checker.check(q, question, workspace)));
            });
        }
        self.row("batch", self.free.len(), |checker, workspace| {
            let mut results = vec![false; self.free.len()];
            checker.are_free_with(&self.free, workspace, black_box(&mut results));
        });
    }

    fn streams(&self) {
        let near = succession(self.solid.robot(), &self.free);
        for (name, question) in [
            ("stream, boolean", Question::Free),
            ("stream, distance within 0.1 m", Question::Distance { limit: 0.1 }),
        ] {
            self.row(name, near.len(), |checker, _| {
                let mut stream = checker.streaming_workspace();
                for q in &near {
                    black_box(checker.check(q, question, &mut stream));
                    checker.prepare(&mut stream);
                }
            });
        }
    }

    fn motions(&self) {
        let robot = self.solid.robot();
        let options = MotionOptions::default();
        let segments = self.free.iter().zip(&self.free[1..]).map(|(from, to)| {
            let mixed = from.positions().iter().zip(to.positions()).map(|(p, q)| p + 0.1 * (q - p));
            let to = robot.configuration(&mixed.collect::<Vec<_>>()).expect("within limits");
            MotionSegment::straight(robot, from, &to)
        });
        let is_free = |segment: &MotionSegment| {
            self.solid.check_motions(std::slice::from_ref(segment), &options)[0].is_free()
        };
        let segments: Vec<_> = segments.filter(is_free).take(MOTIONS).collect();
        self.row("motion, free", segments.len(), |checker, workspace| {
            for segment in &segments {
                black_box(checker.check_motion_with(segment, &options, workspace));
            }
        });
    }
}

fn main() {
    println!("| robot | world | question | surface (µs) | solid (µs) | ratio |");
    println!("|---|---|---|---|---|---|");
    for (name, robot) in robots::all(&["panda", "ur5e", "pr2"]) {
        let reach = if name == "pr2" { 1.6 } else { 1.0 };
        for (world_name, world, check_self) in surroundings::worlds(reach) {
            let comparison = Comparison::new(format!("{name} | {world_name}"), &robot, &world, check_self);
            if comparison.free.len() < STATES {
                println!("| {name} | {world_name} | only {} free states | | | |", comparison.free.len());
                continue;
            }
            comparison.states();
            comparison.streams();
            comparison.motions();
        }
    }
}
