//! Tests of motion checks: free motions against dense samples, contacts against the states at their times.
//!
//! A motion that comes within 5 mm of contact is looked at every 0.001 (rad and m, in the joints' 2-norm); of the others it is enough
//! to see that they stay farther away. Families: robots alone, among primitives, before a mesh world, before walls a millimetre thin, full turns,
//! and edges that were moved until they just graze.

use clearance::checker::{CollisionChecker, MotionOptions, MotionOrder, MotionVerdict, Question, Workspace};
use clearance::geometry::math::{Pose, Vector};
use clearance::geometry::{Primitive, Shape};
use clearance::motion::MotionSegment;
use clearance::robot::{Configuration, RobotModel};
use clearance::scene::Settings;
use clearance::scene::{Obstacle, World};
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;

use super::share;
use crate::peer_results::env_world;
use crate::random::Random;
use crate::random_world;
use crate::tally::{Tally, json, shared_folder};

/// Nearer than this (m) a motion is looked at densely.
const NEAR: f64 = 5e-3;

/// Between two dense samples, in the joints' 2-norm.
const DENSE: f64 = 1e-3;

/// Between two coarse samples, of which distances are asked.
const COARSE: f64 = 0.05;

struct Subject {
    checker: CollisionChecker,
    /// By position: from where to where it may go.
    ranges: Vec<[f64; 2]>,
}

impl Subject {
    fn new(robot: &Arc<RobotModel>, world: &World) -> Self {
        let checker = CollisionChecker::new(robot.clone(), world, Settings::default()).unwrap();
        let mut ranges = vec![[-std::f64::consts::PI, std::f64::consts::PI]; robot.position_names().len()];
        for joint in robot.joint_ids() {
            if let (Some(i), Some(limits)) = (robot.first_position(joint), robot.joint(joint).limits) {
                ranges[i] = [limits.lower.max(-6.3), limits.upper.min(6.3)];
            }
        }
        Self { checker, ranges }
    }

    fn state(&self, random: &mut Random) -> Configuration {
        let positions: Vec<f64> = self.ranges.iter().map(|[lo, hi]| random.within(*lo, *hi)).collect();
        self.checker.robot().configuration(&positions).unwrap()
    }

    /// Some way from a state: as long as is asked, or one joint a full turn.
    fn goal(&self, from: &Configuration, length: f64, random: &mut Random) -> Configuration {
        let mut to = from.positions().to_vec();
        if length > 6.0 {
            let joint = random.below(u32::try_from(to.len()).unwrap()) as usize;
            to[joint] += std::f64::consts::TAU * if random.below(2) == 0 { 1.0 } else { -1.0 };
        } else {
            let way: Vec<f64> = to.iter().map(|_| random.within(-1.0, 1.0)).collect();
            let norm = way.iter().map(|x| x * x).sum::<f64>().sqrt();
            to.iter_mut().zip(&way).for_each(|(q, w)| *q += w / norm * length);
        }
        self.checker.robot().configuration(&to).unwrap()
    }

    /// What is wrong with the answers about one edge.
    fn disagreements(&self, random: &mut Random, workspace: &mut Workspace) -> Vec<String> {
        let length = [0.05, 0.2, 0.5, 1.0, 2.0, 7.0][random.below(6) as usize];
        let from = self.state(random);
        let mut to = self.goal(&from, length, random);
        let check = |to: &Configuration, order: MotionOrder, workspace: &mut Workspace| {
            let segment = MotionSegment::straight(self.checker.robot(), &from, to);
            let options = MotionOptions { order, ..MotionOptions::default() };
            self.checker.check_motion_with(&segment, &options, workspace).verdict
        };
        // half of those that collide are moved towards the state they come from until they graze
        let first = check(&to, MotionOrder::Earliest, workspace);
        if let MotionVerdict::Contact { t: [lo, _], .. } = first
            && lo > 0.0
            && random.below(2) == 0
        {
            let way = from.positions().iter().zip(to.positions());
            let until: Vec<f64> = way.map(|(a, b)| a + (lo * 0.9999) * (b - a)).collect();
            to = self.checker.robot().configuration(&until).unwrap();
        }
        let earliest = check(&to, MotionOrder::Earliest, workspace);
        let any = check(&to, MotionOrder::Any, workspace);
        let is_free = self.checker.is_motion_free(&from, &to, workspace);
        let mut wrong = self.against_samples(&earliest, &from, &to, workspace);
        if is_free != (earliest == MotionVerdict::Free) {
            wrong.push(format!("{earliest:?}, but is_motion_free is {is_free}"));
        }
        if matches!(
            (&earliest, &any),
            (MotionVerdict::Free, MotionVerdict::Contact { .. })
                | (MotionVerdict::Contact { .. }, MotionVerdict::Free)
        ) {
            wrong.push(format!("{earliest:?}, but in any order {any:?}"));
        }
        wrong
    }

    fn against_samples(
        &self,
        verdict: &MotionVerdict,
        from: &Configuration,
        to: &Configuration,
        workspace: &mut Workspace,
    ) -> Vec<String> {
        let at = |t: f64| {
            let way = from.positions().iter().zip(to.positions());
            let positions: Vec<f64> = way.map(|(a, b)| a + t * (b - a)).collect();
            self.checker.robot().configuration(&positions).unwrap()
        };
        let is_free = *verdict == MotionVerdict::Free;
        let free_until = match verdict {
            MotionVerdict::Free => 1.0,
            MotionVerdict::Contact { t: [lo, hi], .. } => {
                if self.checker.is_free(&at(*hi), workspace) {
                    return vec![format!("{verdict:?}, but that state is free")];
                }
                *lo
            }
            MotionVerdict::Undecided { t: [lo, _], .. } => *lo,
        };
        let length =
            from.positions().iter().zip(to.positions()).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let steps = |step: f64| {
            (1..)
                .take_while(move |i| f64::from(*i) * step < length)
                .map(move |i| f64::from(i) * step / length)
        };
        let question = Question::Distance { limit: NEAR + 2.0 * COARSE };
        let mut last: Option<(f64, f64)> = None;
        for t in
            std::iter::once(0.0).chain(steps(COARSE)).chain([1.0]).take_while(|t| is_free || *t < free_until)
        {
            let found = self.checker.check(&at(t), question, workspace);
            if !found.is_free() {
                return vec![format!("{verdict:?}, but it collides at {t}")];
            }
            let distance = found.nearest.map_or(f64::INFINITY, |n| n.distance);
            // a point moves by 1.5 m a radian or so
            if let Some((before, was)) = last
                && distance.min(was) < NEAR + 0.75 * COARSE
            {
                let dense = steps(DENSE).filter(|s| *s > before && *s < t);
                for s in dense {
                    if !self.checker.is_free(&at(s), workspace) {
                        return vec![format!("{verdict:?}, but it collides at {s}")];
                    }
                }
            }
            last = Some((t, distance));
        }
        vec![]
    }
}

/// Walls a millimetre thin around a robot.
fn walls(random: &mut Random) -> World {
    let mut world = World::default();
    for i in 0..6 {
        let primitive = Primitive::cuboid([0.001, random.within(0.1, 0.8), random.within(0.1, 0.8)]).unwrap();
        let direction = random.vector(1.0).normalize() * random.within(0.35, 0.8) + Vector::z() * 0.3;
        let pose = Pose::from_parts(direction.into(), random.rotation());
        world.add(Obstacle::of_shape(format!("wall{i}"), pose, Shape::Primitive(primitive))).unwrap();
    }
    world
}

fn subjects() -> Vec<(String, Subject)> {
    let mut random = Random::new(31);
    let mut all = vec![];
    let mut add = |name: &str, robot: &Arc<RobotModel>, worlds: Vec<(&str, World)>| {
        for (world, obstacles) in worlds {
            all.push((format!("{name}, {world}"), Subject::new(robot, &obstacles)));
        }
    };
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/demo_arm");
    let demo = RobotModel::load(&bundled.join("demo_arm.urdf"), Some(&bundled.join("demo_arm.srdf")), &[]);
    add(
        "demo_arm",
        &Arc::new(demo.unwrap()),
        vec![
            ("alone", World::default()),
            ("walls", walls(&mut random)),
            ("other shapes", random_world::world(&mut random, 0.6)),
        ],
    );
    if let Some(truth) = shared_folder("truth") {
        for name in ["ur5", "panda"] {
            let folder = truth.join(name);
            let robot = RobotModel::load(&folder.join("robot.urdf"), Some(&folder.join("robot.srdf")), &[]);
            let env = |file: &str| {
                let objects = json(&folder.join(file))["objects"].as_array().unwrap().clone();
                env_world(&objects, &folder)
            };
            let worlds = vec![
                ("alone", World::default()),
                ("primitives", env("env_prim_10.json")),
                ("mesh", env("env_mesh.json")),
                ("walls", walls(&mut random)),
                ("other shapes", random_world::world(&mut random, 0.8)),
            ];
            add(name, &Arc::new(robot.unwrap()), worlds);
        }
    }
    all
}

#[test]
fn random_motions_against_dense_samples() {
    for (name, subject) in subjects() {
        let count = share(150, 100_000);
        let wrong: Vec<String> = (0..count)
            .into_par_iter()
            .map_init(
                || subject.checker.workspace(),
                |workspace, i| {
                    let mut random = Random::new(i as u64 + 1);
                    let wrong = subject.disagreements(&mut random, workspace);
                    (!wrong.is_empty()).then(|| format!("{name} {i}: {}", wrong.join("; ")))
                },
            )
            .flatten()
            .collect();
        let mut tally = Tally::new(&format!("soundness, motions: {name}"));
        tally.add_all(count, wrong);
        tally.finish(count);
    }
}
