//! States of a robot: from a file, sampled at random, or from a random walk.

use std::path::Path;

use clearance::robot::JointKind;
use clearance::{CollisionChecker, Configuration, RobotModel};
use serde_json::Value;

use crate::Outcome;
use crate::random::Random;

/// Radians or metres that a joint moves at most in a step of the walk: a millisecond of a brisk motion.
const STEP: f64 = 0.002;

/// Most tries for each free state.
const TRIES: usize = 100;

/// For every position of a configuration the interval to draw from.
pub struct Space {
    bounds: Vec<(f64, f64)>,
}

impl Space {
    /// Joints without limits turn once; planar and floating joints stay where they are.
    pub fn new(robot: &RobotModel) -> Self {
        let mut bounds: Vec<_> = robot.default_configuration().positions().iter().map(|&d| (d, d)).collect();
        for id in robot.joint_ids() {
            let joint = robot.joint(id);
            let Some(first) = robot.first_position(id) else { continue };
            bounds[first] = match (&joint.kind, joint.limits) {
                (JointKind::Planar(_) | JointKind::Floating, _) => continue,
                (JointKind::Continuous(_), _) | (_, None) => (-std::f64::consts::PI, std::f64::consts::PI),
                (_, Some(limits)) => (limits.lower, limits.upper),
            };
        }
        Self { bounds }
    }

    /// The interval of every position; that of a position which stays is a point.
    pub fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn draw(&self, random: &mut Random) -> Vec<f64> {
        self.bounds.iter().map(|&(lower, upper)| random.between(lower, upper)).collect()
    }

    pub fn uniform(
        &self,
        robot: &RobotModel,
        random: &mut Random,
        count: usize,
    ) -> Outcome<Vec<Configuration>> {
        (0..count).map(|_| Ok(robot.configuration(&self.draw(random))?)).collect()
    }

    /// States that the library finds free, by rejection; fewer than `count` if they are too rare.
    pub fn free(
        &self,
        checker: &CollisionChecker,
        random: &mut Random,
        count: usize,
    ) -> Outcome<Vec<Configuration>> {
        let mut workspace = checker.workspace();
        let mut found = Vec::new();
        for _ in 0..TRIES * count {
            let q = checker.robot().configuration(&self.draw(random))?;
            if checker.is_free(&q, &mut workspace) {
                found.push(q);
                if found.len() == count {
                    break;
                }
            }
        }
        Ok(found)
    }

    /// A random walk from `start`, as joint states come at 1 kHz; limits turn it back.
    pub fn walk(
        &self,
        robot: &RobotModel,
        random: &mut Random,
        start: &Configuration,
        steps: usize,
    ) -> Outcome<Vec<Configuration>> {
        let mut at = start.positions().to_vec();
        let mut velocity = vec![0.0; at.len()];
        (0..steps)
            .map(|_| {
                for ((x, v), &(lower, upper)) in at.iter_mut().zip(&mut velocity).zip(&self.bounds) {
                    // a direction that lasts some tenths of a second, as those of motions do
                    *v = f64::clamp(*v + random.between(-0.1, 0.1) * STEP, -STEP, STEP);
                    if !(lower..=upper).contains(&(*x + *v)) {
                        *v = -*v;
                    }
                    *x = (*x + *v).clamp(lower, upper);
                }
                Ok(robot.configuration(&at)?)
            })
            .collect()
    }
}

/// The states of a file `{"joint_order": [...], "q": [[...], ...]}`.
pub fn from_file(robot: &RobotModel, file: &Path) -> Outcome<Vec<Configuration>> {
    let content: Value = serde_json::from_slice(&std::fs::read(file)?)?;
    let missing = || format!("{}: no joint_order or no q", file.display());
    let names: Vec<&str> =
        content["joint_order"].as_array().ok_or_else(missing)?.iter().filter_map(Value::as_str).collect();
    let rows = content["q"].as_array().ok_or_else(missing)?;
    rows.iter()
        .map(|row| {
            let values = row.as_array().into_iter().flatten().filter_map(Value::as_f64);
            Ok(robot.configuration_from_names(names.iter().copied().zip(values))?)
        })
        .collect()
}
