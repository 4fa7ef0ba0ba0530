//! `cargo bench --bench between_states`: cost of the check of the motion between two joint states (`check_between_states`),
//! on top of the evaluation of the states.
//!
//! Two monitors evaluate the same streams in turn, one of them without the check. A stream follows a straight line
//! between random free states at 1 rad/s (Euclidean norm over all joints), with velocities. CPU time of the thread
//! (µs) for one joint state: median of all blocks, and the median of the ratios of blocks that follow each other.
//! `proven` is the share of motions that are proven free. Robots of `../shared/robots` are measured where that folder
//! exists. Arguments select robots by name.

#[allow(dead_code)]
#[path = "../tests/it/random.rs"]
mod random;
#[allow(dead_code)]
#[path = "robots/mod.rs"]
mod robots;

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clearance::monitor::{
    JointStateInput, Monitor, MonitorSettings, MotionSincePrevious, Now, Revision, Time,
};
use clearance::{CollisionChecker, Configuration};
use cpu_time::ThreadTime;
use random::Random;

/// Rates of joint states (Hz).
const RATES: [f64; 3] = [50.0, 250.0, 1000.0];

/// Speed (rad/s) of the norm of all joints.
const SPEED: f64 = 1.0;

/// States of a block, and number of blocks for each monitor.
const BLOCK: usize = 50;
const BLOCKS: usize = 120;

/// A stream of free states: straight lines between random states, one step (rad) after the other.
struct Stream<'c> {
    checker: &'c CollisionChecker,
    random: Random,
    at: Vec<f64>,
    velocities: Vec<f64>,
    seconds: f64,
}

impl<'c> Stream<'c> {
    fn new(checker: &'c CollisionChecker, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let at = free_state(checker, &mut random).positions().to_vec();
        let velocities = vec![0.0; at.len()];
        Self { checker, random, at, velocities, seconds: 100.0 }
    }

    /// The joint states of a block; the robot turns round where the next state would not be free.
    fn block(&mut self, rate: f64) -> Vec<(JointStateInput, Now)> {
        let goal = free_state(self.checker, &mut self.random);
        let way: Vec<f64> = goal.positions().iter().zip(&self.at).map(|(to, from)| to - from).collect();
        let norm = way.iter().map(|w| w * w).sum::<f64>().sqrt();
        self.velocities = way.iter().map(|w| w / norm * SPEED).collect();
        let mut workspace = self.checker.workspace();
        (0..BLOCK).map(|_| self.next(rate, &mut workspace)).collect()
    }

    #[allow(clippy::cast_possible_truncation)] // minutes
    fn next(&mut self, rate: f64, workspace: &mut clearance::Workspace) -> (JointStateInput, Now) {
        for _ in 0..2 {
            let next: Vec<f64> = self.at.iter().zip(&self.velocities).map(|(q, v)| q + v / rate).collect();
            let robot = self.checker.robot();
            if robot.configuration(&next).is_ok_and(|q| self.checker.is_free(&q, workspace)) {
                self.at = next;
                break;
            }
            self.velocities.iter_mut().for_each(|v| *v = -*v);
        }
        self.seconds += 1.0 / rate;
        let stamp = Time::from_nanoseconds((self.seconds * 1e9) as i64);
        let input = JointStateInput {
            stamp,
            names: self.checker.robot().position_names().to_vec(),
            positions: self.at.clone(),
            velocities: self.velocities.clone(),
            ..JointStateInput::default()
        };
        (input, Now { ros: Some(stamp), steady: Duration::from_secs_f64(self.seconds) })
    }
}

fn free_state(checker: &CollisionChecker, random: &mut Random) -> Configuration {
    let mut workspace = checker.workspace();
    loop {
        let state = robots::random_state(checker, random);
        if checker.is_free(&state, &mut workspace) {
            return state;
        }
    }
}

/// A clock for the monitor's time budget.
fn stopwatch() -> Duration {
    thread_local!(static START: Instant = Instant::now());
    START.with(Instant::elapsed)
}

fn monitor(revision: &Arc<Revision>, check_between_states: bool) -> Monitor {
    let settings = MonitorSettings { check_between_states, ..MonitorSettings::default() };
    let mut monitor = Monitor::new(settings, stopwatch);
    monitor.set_checker(Arc::clone(revision));
    monitor
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// Prints the times of one robot at one rate.
#[allow(clippy::cast_precision_loss)] // few states
fn measure(name: &str, revision: &Arc<Revision>, rate: f64) {
    let mut stream = Stream::new(&revision.checker, 11);
    let mut monitors = [false, true].map(|check| monitor(revision, check));
    let (mut times, mut proven) = ([Vec::new(), Vec::new()], 0);
    for block in 0..BLOCKS {
        let states = stream.block(rate);
        for which in [block % 2, 1 - block % 2] {
            let states = states.clone();
            let start = ThreadTime::now();
            for (input, now) in states {
                let evaluation = black_box(monitors[which].on_joint_state(input, now));
                proven += usize::from(evaluation.motion_since_previous == MotionSincePrevious::ProvenFree);
                monitors[which].prepare();
            }
            times[which].push(start.elapsed().as_secs_f64() * 1e6 / BLOCK as f64);
        }
    }
    let ratios = times[0].iter().zip(&times[1]).map(|(without, with)| with / without).collect();
    let [without, with] = times.map(median);
    let share = 100.0 * proven as f64 / (BLOCK * BLOCKS) as f64;
    println!(
        "{name:8} {rate:6} Hz  without {without:8.2}  with {with:8.2}  ratio {:.3}  proven {share:.2} %",
        median(ratios)
    );
}

fn main() {
    let selected: Vec<String> = std::env::args().skip(1).filter(|name| !name.starts_with("--")).collect();
    for (name, robot) in robots::all(&["ur5e", "panda", "g1"]) {
        if !selected.is_empty() && !selected.iter().any(|other| other == name) {
            continue;
        }
        let checker = robots::checker(&robot, &mut Random::new(7));
        let revision = Arc::new(Revision::new(checker, 1, 1));
        for rate in RATES {
            measure(name, &revision, rate);
        }
    }
}
