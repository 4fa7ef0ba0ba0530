//! `cargo bench --bench recovery`: search for a free state near a colliding one, compared with MoveIt's random
//! jiggling, on the bundled robots and, where the folder `../shared` exists, on real ones.
//!
//! Random states that collide, with a free state within 0.3 (rad, m). `recovery` is `find_free_state` with default options and
//! without clearance; `jiggles` is the method of MoveIt's request adapter: a hundred random states whose positions differ by up to 0.02. Of
//! each: the share of states with a result, median and 90th percentile of its distance, and of the CPU time of the thread. Arguments
//! select robots by name; `--states N` sets the number of states.

#[allow(dead_code)]
#[path = "../tests/it/random.rs"]
mod random;
#[allow(dead_code)]
#[path = "robots/mod.rs"]
mod robots;

use clearance::checker::{Recovery, RecoveryOptions, Workspace};
use clearance::{CollisionChecker, Configuration};
use cpu_time::ThreadTime;
use random::Random;
use robots::random_state;

/// Largest distance (rad, m) of each state from a free one.
const NEAR: f64 = 0.3;

/// Largest change (rad, m) of a jiggle, and their number.
const JIGGLE: f64 = 0.02;
const JIGGLES: usize = 100;

/// A state with these changes, as far as the limits allow.
fn moved(checker: &CollisionChecker, q: &Configuration, by: &[f64]) -> Option<Configuration> {
    let robot = checker.robot();
    let mut moved: Vec<f64> = q.positions().iter().zip(by).map(|(q, by)| q + by).collect();
    for joint in robot.joint_ids() {
        if let (Some(limits), Some(first)) = (robot.joint(joint).limits, robot.first_position(joint)) {
            moved[first] = moved[first].clamp(limits.lower, limits.upper);
        }
    }
    robot.configuration(&moved).ok()
}

fn distance(a: &Configuration, b: &Configuration) -> f64 {
    a.positions().iter().zip(b.positions()).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Random states that collide, with a free state within [`NEAR`].
fn colliding_states(checker: &CollisionChecker, random: &mut Random, count: usize) -> Vec<Configuration> {
    let mut workspace = checker.workspace();
    let mut states = Vec::new();
    for _ in 0..200_000 {
        if states.len() == count {
            break;
        }
        let free = random_state(checker, random);
        if !checker.is_free(&free, &mut workspace) {
            continue;
        }
        let by: Vec<f64> = free.positions().iter().map(|_| random.within(-1.0, 1.0)).collect();
        let length = by.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        let by: Vec<f64> = by.iter().map(|entry| NEAR * entry / length).collect();
        let near = moved(checker, &free, &by);
        states.extend(near.filter(|q| !checker.is_free(q, &mut workspace)));
    }
    states
}

/// Results of one method: distances (rad, m) and times (ms).
#[derive(Default)]
struct Results {
    distances: Vec<f64>,
    times: Vec<f64>,
}

impl Results {
    fn add(&mut self, search: impl FnOnce() -> Option<f64>) -> Option<f64> {
        let start = ThreadTime::now();
        let distance = search();
        self.times.push(start.elapsed().as_secs_f64() * 1e3);
        self.distances.extend(distance);
        distance
    }

    fn print(mut self, robot: &str, method: &str) {
        #[allow(clippy::cast_precision_loss)] // few states
        let share = 100.0 * self.distances.len() as f64 / self.times.len() as f64;
        for list in [&mut self.distances, &mut self.times] {
            list.sort_by(f64::total_cmp);
        }
        let at =
            |list: &[f64], tenths: usize| list.get(list.len() * tenths / 10).copied().unwrap_or(f64::NAN);
        println!(
            "{robot:10} {method:10} {:5} states: {share:5.1} % found, distance {:.4} / {:.4}, {:8.3} / {:8.3} ms",
            self.times.len(),
            at(&self.distances, 5),
            at(&self.distances, 9),
            at(&self.times, 5),
            at(&self.times, 9)
        );
    }
}

fn recovered(checker: &CollisionChecker, q: &Configuration, workspace: &mut Workspace) -> Option<f64> {
    let options = RecoveryOptions { clearance: 0.0, ..RecoveryOptions::default() };
    match checker.find_free_state(q, &options, workspace).expect("the options are valid") {
        Recovery::Found(found) => Some(found.distance),
        _ => None,
    }
}

fn jiggled(
    checker: &CollisionChecker,
    q: &Configuration,
    random: &mut Random,
    workspace: &mut Workspace,
) -> Option<f64> {
    (0..JIGGLES).find_map(|_| {
        let by: Vec<f64> = q.positions().iter().map(|_| random.within(-JIGGLE, JIGGLE)).collect();
        let state = moved(checker, q, &by)?;
        checker.is_free(&state, workspace).then(|| distance(q, &state))
    })
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let count = arguments.iter().skip_while(|argument| *argument != "--states").nth(1);
    let count: usize = count.map_or(1000, |count| count.parse().expect("--states takes a number"));
    let selected = |name: &str| {
        let mut names =
            arguments.iter().filter(|argument| argument.starts_with(|c: char| c.is_alphabetic())).peekable();
        names.peek().is_none() || names.any(|other| other == name)
    };
    let names = ["panda", "ur5e", "pr2", "g1"];
    for (name, robot) in robots::all(&names).into_iter().filter(|(name, _)| selected(name)) {
        let mut random = Random::new(11);
        let checker = robots::checker(&robot, &mut random);
        let states = colliding_states(&checker, &mut random, count);
        let mut workspace = checker.workspace();
        let (mut recovery, mut jiggles) = (Results::default(), Results::default());
        let (mut nearer, mut both) = (0, 0);
        for q in &states {
            let recovered = recovery.add(|| recovered(&checker, q, &mut workspace));
            let jiggled = jiggles.add(|| jiggled(&checker, q, &mut random, &mut workspace));
            let Some((recovered, jiggled)) = recovered.zip(jiggled) else { continue };
            nearer += u32::from(recovered < jiggled);
            both += 1;
        }
        recovery.print(name, "recovery");
        jiggles.print(name, "jiggles");
        println!("{name:10} {both:5} states that both solve: recovery is nearer in {nearer}");
    }
}
