//! Least distances of near pairs while the robot moves on at its joint velocities, by checks of states on the way.

use std::collections::BTreeMap;

use clearance_checker::{CollisionChecker, PairDistance, Question, Workspace};
use clearance_geometry::math::Extremes;
use clearance_robot::{JointId, JointKind, RobotModel};
use clearance_scene::BodyId;

use super::CheckedState;
use super::approach_rate::PosesAtOtherTime;

/// Largest number of states that are checked on the way, and the least way (m) between them.
const MOST_STEPS: f64 = 8.0;
const LEAST_STEP: f64 = 0.01;

/// Largest part of the way by which points may come nearer because they turn: that is not the motion of other parts.
const MOST_TURNING: f64 = 0.15;

/// The least distance (m) of each pair on the way.
#[derive(Debug, Default)]
pub(super) struct PredictedDistances {
    least: BTreeMap<(BodyId, BodyId), f64>,
    is_known: bool,
    /// Allowance (m) for the curvature of the points' ways: the rates of approach are those of straight ways.
    curvature: f64,
}

/// The least distance of a pair on the way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    /// Infinite (m) if the pair does not come near.
    pub distance: f64,
    /// Largest contribution (m) of the curvature of the points' ways.
    pub curvature: f64,
}

impl Reached {
    /// Whether other points come nearer than to this distance (m), to which the nearest points come on straight ways.
    pub fn is_nearer_than(&self, straight: f64) -> bool {
        self.distance < straight - self.curvature || self.distance <= 0.0
    }
}

impl PredictedDistances {
    /// Distances in a time (s) after a state, for pairs that are near now. Not known without velocities.
    pub fn within(
        checker: &CollisionChecker,
        checked_state: &CheckedState,
        other: &PosesAtOtherTime,
        near: &[&PairDistance],
        time: f64,
        workspace: &mut Workspace,
    ) -> Self {
        // the mean velocity of a longer time says little about what comes
        let is_recent = time > 0.0 && other.after.abs() <= time;
        let Some(rates) = other.rates.as_ref().filter(|_| is_recent) else { return Self::default() };
        let positions = checked_state.configuration.positions();
        let later = |time: f64| -> Vec<f64> {
            positions.iter().zip(rates).map(|(q, rate)| q + time * rate).collect()
        };
        let travel = checker.travel(positions, &later(time));
        // a point that turns by an angle departs from its straight way by half of that, relative to its way
        let curvature = travel * (0.5 * time * turning(checker.robot(), rates)).lesser(MOST_TURNING);
        let mut found = Self { least: BTreeMap::new(), is_known: travel.is_finite(), curvature };
        if travel <= 0.0 || !found.is_known {
            return found;
        }
        let nearest = near.iter().map(|pair| pair.distance).fold(f64::INFINITY, f64::lesser);
        let farthest = near.iter().map(|pair| pair.distance).fold(0.0, f64::greater);
        let steps = (travel / (0.5 * nearest).greater(LEAST_STEP)).ceil().clamp(1.0, MOST_STEPS);
        let mut share = 0.0;
        while share < steps {
            share += 1.0;
            let Ok(q) = checker.robot().configuration(&later(time * share / steps)) else {
                return Self::default();
            };
            let report = checker.check(&q, Question::PairDistances { limit: farthest }, workspace);
            let distances = report.pair_distances.iter().map(|pair| ((pair.a, pair.b), pair.distance));
            let contacts = report.colliding_pairs.iter().map(|pair| (*pair, 0.0));
            for (pair, distance) in distances.chain(contacts) {
                let least = found.least.entry(pair).or_insert(f64::INFINITY);
                *least = least.lesser(distance);
            }
        }
        found
    }

    /// The least distance of a pair; `None` if it is not known.
    pub fn of(&self, pair: &PairDistance) -> Option<Reached> {
        let distance = self.least.get(&(pair.a, pair.b)).copied().unwrap_or(f64::INFINITY);
        self.is_known.then_some(Reached { distance, curvature: self.curvature })
    }
}

/// Upper bound (rad/s) on the angular velocity of any link.
fn turning(robot: &RobotModel, rates: &[f64]) -> f64 {
    let of_joint = |id: JointId| {
        let first = robot.first_position(id)?;
        match robot.joint(id).kind {
            JointKind::Revolute(_) | JointKind::Continuous(_) => Some(rates[first].abs()),
            JointKind::Planar(_) => Some(rates[first + 2].abs()),
            JointKind::Fixed | JointKind::Prismatic(_) | JointKind::Floating => None,
        }
    };
    robot.joint_ids().filter_map(of_joint).sum()
}
