//! `clearance check --gradient`: signed distances of pairs, and their derivatives with respect to the joints.

use clearance::checker::{Clearance, CollisionChecker, PairClearance, WitnessCount};
use clearance::geometry::math::Point;
use clearance::robot::Configuration;
use rayon::prelude::*;
use serde::Serialize;

use super::failure::Failure;
use super::run_args::RunArgs;

/// Columns of the pairs of one state, in their order. Pairs have sorted names, and their points and normals are in the order of the names.
#[derive(Serialize)]
pub struct GradientResult {
    /// In metres; minus the depth of bodies that overlap.
    signed_distances: Vec<f64>,
    /// Bounds in metres; null instead of minus infinity.
    signed_distance_bounds: Vec<[f64; 2]>,
    /// Unit vectors from the first body of the pair to the second; null where none is known.
    normals: Vec<Option<[f64; 3]>>,
    /// Nearest points of the first and the second body, or the points that come apart last.
    pair_witness_points: Vec<[[f64; 3]; 2]>,
    /// Whether the points and the normal are unique.
    witness_counts: Vec<&'static str>,
    /// Rows in the order of the pairs, with a derivative for each joint (m per rad or per m).
    gradient: Vec<Vec<f64>>,
}

/// The clearance of each state, in their order.
pub fn clearances(
    checker: &CollisionChecker,
    states: &[Configuration],
    influence_distance: f64,
    run: &RunArgs,
) -> Result<Vec<Clearance>, Failure> {
    let pool = run.pool(states.len())?;
    Ok(pool.install(|| {
        let each = states.par_iter().map_init(
            || checker.workspace(),
            |workspace, q| checker.clearance(q, influence_distance, workspace),
        );
        each.collect()
    }))
}

impl GradientResult {
    pub fn new(clearance: &Clearance, checker: &CollisionChecker) -> Self {
        let pairs = || clearance.pairs.iter();
        let is_swapped = |pair: &PairClearance| checker.body_name(pair.a) > checker.body_name(pair.b);
        let normal = |pair: &PairClearance| {
            let sign = if is_swapped(pair) { -1.0 } else { 1.0 };
            pair.normal.map(|n| [n.x, n.y, n.z].map(|entry| sign * entry))
        };
        let points = |pair: &PairClearance| {
            let [p, q] = pair.witness_points.map(|p: Point| [p.x, p.y, p.z]);
            if is_swapped(pair) { [q, p] } else { [p, q] }
        };
        Self {
            signed_distances: pairs().map(|pair| pair.distance).collect(),
            signed_distance_bounds: pairs().map(|pair| [pair.lower, pair.upper]).collect(),
            normals: pairs().map(normal).collect(),
            pair_witness_points: pairs().map(points).collect(),
            witness_counts: pairs().map(|pair| word(pair.witnesses)).collect(),
            gradient: (0..clearance.pairs.len()).map(|pair| clearance.row(pair).to_vec()).collect(),
        }
    }

    /// The signed distance and the row of a pair, as text.
    pub fn words(&self, pair: usize) -> String {
        let row: Vec<String> = self.gradient[pair].iter().map(|entry| format!("{entry:.4}")).collect();
        let kinks = if self.witness_counts[pair] == word(WitnessCount::One) { "" } else { ", not unique" };
        format!("signed {:.6} m, gradient [{}]{kinks}", self.signed_distances[pair], row.join(", "))
    }
}

fn word(witnesses: WitnessCount) -> &'static str {
    match witnesses {
        WitnessCount::One => "one",
        WitnessCount::Several => "several",
        WitnessCount::Unknown => "unknown",
    }
}
