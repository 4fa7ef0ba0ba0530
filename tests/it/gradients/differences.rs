//! Test helper: derivatives of signed distances by central differences, extrapolated to a step of zero.

use std::collections::HashMap;

use clearance::checker::{CollisionChecker, PairClearance, Question, WitnessCount, Workspace};
use clearance::robot::{Configuration, JointKind, RobotModel};
use clearance::scene::BodyId;

/// Steps (rad, m, or of a quaternion's entry), the longest first. The longest cancel most of the noise of measured distances, 1e-10 m for
/// curved primitives; the shortest do not leave a triangle.
const STEPS: [f64; 4] = [1e-3, 2e-4, 4e-5, 1e-5];

/// Largest difference of two extrapolations for which differences count as converged, relative to the scale of the row.
const CONVERGED: f64 = 1e-7;

/// Distance (m) by which the pairs of a state may be farther apart at the steps.
const FARTHER: f64 = 0.1;

/// Distance (m) of padded bodies that do not come into contact at the steps.
const FARTHER_FROM_CONTACT: f64 = 0.01;

/// Comparison of rows with differences.
#[derive(Clone, Copy, Debug, Default)]
pub struct Comparison {
    /// Entries that were compared.
    pub entries: usize,
    /// Pairs of which all entries were compared.
    pub pairs: usize,
    /// Pairs with an entry of which differences did not converge: another feature is nearest within the steps.
    pub not_converged: usize,
    /// The largest error of an entry, relative to the largest of its row, or to 0.01.
    pub worst: f64,
}

/// Pairs whose rows are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Compared {
    /// Bodies that are apart by more than a distance (m), also where their paddings overlap.
    Apart(f64),
    /// As above, but paddings do not overlap.
    Free(f64),
    /// Bodies that overlap.
    Overlapping,
}

impl Comparison {
    pub fn add(&mut self, other: &Self) {
        self.entries += other.entries;
        self.pairs += other.pairs;
        self.not_converged += other.not_converged;
        self.worst = self.worst.max(other.worst);
    }

    /// Compares all smooth pairs of a state.
    pub fn of_state(
        checker: &CollisionChecker,
        q: &Configuration,
        influence_distance: f64,
        compared: Compared,
        workspace: &mut Workspace,
    ) -> Self {
        let found = checker.clearance(q, influence_distance, workspace);
        let smooth: Vec<usize> =
            (0..found.pairs.len()).filter(|i| compared.includes(&found.pairs[*i])).collect();
        let far = influence_distance + FARTHER;
        let mut state = State { checker, q, far, compared, workspace, known: HashMap::new() };
        let mut comparison = Self::default();
        let mut converged = vec![true; smooth.len()];
        for column in 0..found.columns {
            for (i, converged) in smooth.iter().zip(&mut converged) {
                let row = found.row(*i);
                let scale = row.iter().fold(0.01, |scale: f64, entry| scale.max(entry.abs()));
                match state.derivative(column, bodies(&found.pairs[*i]), scale) {
                    Some(derivative) => {
                        comparison.entries += 1;
                        comparison.worst = comparison.worst.max((row[column] - derivative).abs() / scale);
                    }
                    None => *converged = false,
                }
            }
        }
        comparison.pairs = converged.iter().filter(|converged| **converged).count();
        comparison.not_converged = smooth.len() - comparison.pairs;
        comparison
    }
}

impl Compared {
    fn includes(self, pair: &PairClearance) -> bool {
        let [p, q] = pair.witness_points;
        let overlaps = pair.normal.is_none_or(|normal| normal.dot(&(q - p)) <= 0.0);
        let apart = nalgebra::distance(&p, &q);
        let included = match self {
            Self::Apart(least) => !overlaps && apart >= least,
            Self::Free(least) => !overlaps && apart >= least && pair.distance >= FARTHER_FROM_CONTACT,
            Self::Overlapping => overlaps,
        };
        included && pair.witnesses == WitnessCount::One
    }
}

pub fn bodies(pair: &PairClearance) -> (BodyId, BodyId) {
    (pair.a, pair.b)
}

type SignedDistances = HashMap<(BodyId, BodyId), f64>;

/// A state, and the signed distances at states near it, by position and step.
struct State<'c> {
    checker: &'c CollisionChecker,
    q: &'c Configuration,
    /// Distance (m) up to which pairs are measured.
    far: f64,
    compared: Compared,
    workspace: &'c mut Workspace,
    known: HashMap<(usize, u64), SignedDistances>,
}

impl State<'_> {
    /// `None` if differences do not converge.
    fn derivative(&mut self, column: usize, pair: (BodyId, BodyId), scale: f64) -> Option<f64> {
        STEPS.iter().find_map(|&step| {
            let [fine, middle, coarse] =
                [1.0, 2.0, 4.0].map(|factor| self.difference(column, pair, factor * step));
            let [fine, coarse] = [(4.0 * fine? - middle?) / 3.0, (4.0 * middle? - coarse?) / 3.0];
            ((fine - coarse).abs() <= CONVERGED * scale).then_some(fine)
        })
    }

    fn difference(&mut self, column: usize, pair: (BodyId, BodyId), step: f64) -> Option<f64> {
        let [after, before] = [step, -step].map(|step| self.signed_distance(column, pair, step));
        Some((after? - before?) / (2.0 * step))
    }

    fn signed_distance(&mut self, column: usize, pair: (BodyId, BodyId), step: f64) -> Option<f64> {
        let key = (column, step.to_bits());
        if !self.known.contains_key(&key) {
            let q = moved(self.checker.robot(), self.q, column, step);
            let distances = self.signed_distances(&q);
            self.known.insert(key, distances);
        }
        self.known[&key].get(&pair).copied()
    }

    fn signed_distances(&mut self, q: &Configuration) -> SignedDistances {
        if let Compared::Free(_) = self.compared {
            // depths take much longer
            let report = self.checker.check(q, Question::PairDistances { limit: self.far }, self.workspace);
            return report.pair_distances.iter().map(|pair| ((pair.a, pair.b), pair.distance)).collect();
        }
        let found = self.checker.clearance(q, self.far, self.workspace);
        found.pairs.iter().map(|pair| (bodies(pair), exact(pair))).collect()
    }
}

/// The signed distance up to rounding, plus the padding where bodies are apart. The reported one has an error of up to 1e-10 m for curved
/// primitives, and an allowance for depths.
pub fn exact(pair: &PairClearance) -> f64 {
    let [p, q] = pair.witness_points;
    match pair.normal {
        Some(normal) if normal.dot(&(q - p)) > 0.0 => nalgebra::distance(&p, &q),
        _ => pair.upper,
    }
}

/// A configuration with one position changed; quaternions are normalised.
pub fn moved(robot: &RobotModel, q: &Configuration, column: usize, step: f64) -> Configuration {
    let mut positions = q.positions().to_vec();
    positions[column] += step;
    for joint in robot.joint_ids() {
        let (JointKind::Floating, Some(first)) = (&robot.joint(joint).kind, robot.first_position(joint))
        else {
            continue;
        };
        let turn = &mut positions[first + 3..first + 7];
        let length = turn.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        for entry in turn {
            *entry /= length;
        }
    }
    robot.configuration(&positions).expect("the state moves little")
}
