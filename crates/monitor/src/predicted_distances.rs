//! Distances while the robot moves on at its joint velocities: also those of parts that are not the nearest ones now.

use std::collections::BTreeMap;

use clearance_checker::{CollisionChecker, PairDistance, Question, Workspace};
use clearance_geometry::math::Extremes;
use clearance_scene::BodyId;

use super::CheckedState;
use super::approach_rate::PosesAtOtherTime;

/// Largest number of states that are checked on the way, and the least way (m) between them.
const MOST_STEPS: f64 = 8.0;
const LEAST_STEP: f64 = 0.01;

/// The least distance (m) of each pair on the way.
#[derive(Debug, Default)]
pub(super) struct PredictedDistances {
    least: BTreeMap<(BodyId, BodyId), f64>,
    is_known: bool,
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
        let Some(rates) = other.rates.as_ref().filter(|_| time > 0.0) else { return Self::default() };
        let positions = checked_state.configuration.positions();
        let later = |time: f64| -> Vec<f64> {
            positions.iter().zip(rates).map(|(q, rate)| q + time * rate).collect()
        };
        let travel = checker.travel(positions, &later(time));
        let mut found = Self { least: BTreeMap::new(), is_known: travel.is_finite() };
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

    /// The least distance (m) of a pair, infinite if it does not come near; `None` if it is not known.
    pub fn of(&self, pair: &PairDistance) -> Option<f64> {
        self.is_known.then(|| self.least.get(&(pair.a, pair.b)).copied().unwrap_or(f64::INFINITY))
    }
}
