//! Evaluates the clearance of one state: the signed distances of near pairs, then their derivatives.
//!
//! For witness points p on body a and q on body b with the unit normal n from a to b, the signed distance d has the derivative
//! `nᵀ (J_b(q) − J_a(p))` with the Jacobians J of the points (for bodies that are apart: Gilbert & Johnson 1985, *Distance functions and
//! their application to robot path planning in the presence of obstacles*). Joints that move both bodies alike cancel: only those on the
//! path between the bodies contribute.

use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_proximity::{
    PenetrationDepth, Separation, WitnessOptions, WitnessPair, WitnessPairs, depth_witnesses,
    distance_with_witnesses, is_one_inside, penetration_depth,
};
use clearance_robot::PointAlong;
use clearance_scene::BodyId;

use super::pair_clearances::{Clearance, ClearanceCandidate, ClearanceOptions, PairClearance, WitnessCount};
use crate::pair_kind::SearchedPairs;
use crate::pairs::PosedPair;
use crate::state::QueriedState;

/// Clearance query on one state, with the memory that it uses.
pub struct ClearanceQuery<'a> {
    pub state: QueriedState<'a>,
    pub options: &'a ClearanceOptions,
    pub witnesses: &'a mut WitnessPairs,
    pub result: &'a mut Clearance,
}

impl ClearanceQuery<'_> {
    /// Writes all near pairs to the result.
    pub fn evaluate(mut self) {
        let influence = self.options.influence_distance;
        // touching pairs are within any limit
        let limit = influence.greater(0.0);
        self.state.queue_candidates(SearchedPairs::All, limit);
        for k in 0..self.state.candidates.len() {
            let index = self.state.candidates[k].index;
            let pair = self.state.pair(index);
            let Some(found) = self.pair_clearance(&pair, index, limit) else { continue };
            if influence < 0.0 && found.distance > influence {
                continue;
            }
            self.add(&pair, index, found);
        }
        self.result.work = self.state.scratch.work;
    }

    /// Writes these pairs of bodies to the result, as far as they are in the pair list, until the time is over.
    pub fn evaluate_pairs(mut self, bodies: &[(BodyId, BodyId)], is_over: impl Fn() -> bool) {
        let QueriedState { pairs, q, robot, scratch, .. } = &mut self.state;
        robot.place(pairs, q.positions(), scratch.level());
        for &bodies in bodies {
            if is_over() {
                break;
            }
            let Some(index) = self.state.pairs.number_of(bodies) else { continue };
            let pair = self.state.pair(index);
            if let Some(found) = self.pair_clearance(&pair, index, self.options.influence_distance) {
                self.add(&pair, index, found);
            }
        }
        self.result.work = self.state.scratch.work;
    }

    /// The signed distance of a pair and its witness pairs, unless it is proven larger than `limit`.
    fn pair_clearance(&mut self, pair: &PosedPair, index: usize, limit: f64) -> Option<PairClearance> {
        // rounded as in queries of distances
        let limit = (limit + pair.info.padding).next_up();
        let options = &self.witness_options();
        let (witnesses, scratch) = (&mut *self.witnesses, &mut *self.state.scratch);
        let nearest = distance_with_witnesses(pair.posed_bodies(), limit, options, witnesses, scratch)?;
        let padding = pair.info.padding;
        if nearest.distance > padding {
            return Some(of_bodies_apart(pair, &nearest, witnesses));
        }
        let [a, b] = self.state.pairs.solids(index);
        let of_paddings_only = nearest.distance > 0.0 && !is_one_inside(a, b, &pair.pose_ab, scratch);
        if of_paddings_only && pair.comes_apart(&nearest, scratch) {
            return Some(of_bodies_apart(pair, &nearest, witnesses));
        }
        let depth = penetration_depth(a, b, pair.pose_ab, padding, scratch);
        // the distance changes at most as much as a body is moved; the depth of solids says nothing about surfaces that are apart
        let of_distance = padding - nearest.distance;
        let depth = depth.map(|depth| PenetrationDepth {
            lower: if of_paddings_only { of_distance } else { depth.lower },
            ..depth
        });
        let Some(depth) = depth.filter(|depth| depth.upper.is_finite()) else {
            return Some(without_depth(pair, depth.as_ref(), &nearest));
        };
        let of_depth = (&depth, padding);
        let is_known = depth_witnesses([a, b], &pair.pose_ab, of_depth, options, witnesses);
        let count = match (is_known, witnesses.are_several()) {
            (false, _) => WitnessCount::Unknown,
            (true, false) => WitnessCount::One,
            (true, true) => WitnessCount::Several,
        };
        let bounds = [-depth.upper, -depth.lower];
        let found = of_witnesses(pair, bounds, witnesses.pairs().first(), &nearest);
        Some(PairClearance { unknown: depth.unknown, ..found.counted(count, witnesses) })
    }

    fn witness_options(&self) -> WitnessOptions {
        WitnessOptions { tolerance: self.options.tie_tolerance, most: self.options.most_candidates.max(1) }
    }

    /// Adds a pair with its row, and its candidates if they were requested.
    fn add(&mut self, pair: &PosedPair, index: usize, found: PairClearance) {
        if self.options.most_candidates > 0 && found.witnesses == WitnessCount::Several {
            for witness in self.witnesses.pairs() {
                let WitnessPair { points, normal } = in_root(pair, witness);
                let candidate =
                    ClearanceCandidate { pair: self.result.pairs.len(), witness_points: points, normal };
                self.result.candidates.push(candidate);
                let witness = Some(WitnessPair { points, normal });
                add_row(&self.state, index, witness.as_ref(), &mut self.result.candidate_gradient);
            }
        }
        let witness = found.normal.map(|normal| WitnessPair { points: found.witness_points, normal });
        add_row(&self.state, index, witness.as_ref(), &mut self.result.gradient);
        self.result.pairs.push(found);
    }
}

/// Adds the row of a pair: zeros without a witness pair, which is in the root frame.
fn add_row(state: &QueriedState, index: usize, witness: Option<&WitnessPair>, rows: &mut Vec<f64>) {
    let (positions, frames) = (state.q.positions(), state.robot.frames());
    let begin = rows.len();
    rows.resize(begin + positions.len(), 0.0);
    let Some(WitnessPair { points: [p, q], normal }) = witness else { return };
    let row = &mut rows[begin..];
    let (path, chain) = (state.pairs.path_between(index), state.pairs.robot().chain());
    let on_a = PointAlong { point: p.coords, direction: -normal };
    let on_b = PointAlong { point: q.coords, direction: *normal };
    chain.add_point_derivative(path.side(0), &on_a, frames, positions, row);
    chain.add_point_derivative(path.side(1), &on_b, frames, positions, row);
}

/// Transforms a witness pair from the frame of a to the root frame.
fn in_root(pair: &PosedPair, witness: &WitnessPair) -> WitnessPair {
    let MatrixPose { rotation, .. } = pair.pose_ra;
    WitnessPair { points: witness.points.map(|p| &pair.pose_ra * p), normal: rotation * witness.normal }
}

/// A pair whose signed distance is between bounds (m), with its first witness pair; the points of `nearest` if there is none.
fn of_witnesses(
    pair: &PosedPair,
    [lower, upper]: [f64; 2],
    witness: Option<&WitnessPair>,
    nearest: &Separation,
) -> PairClearance {
    let (a, b) = pair.info.ids;
    let witness = witness.map(|witness| in_root(pair, witness));
    let points =
        witness.map_or_else(|| nearest.witness_points.map(|p| &pair.pose_ra * p), |found| found.points);
    PairClearance {
        a,
        b,
        distance: lower,
        lower,
        upper,
        unknown: None,
        witness_points: points,
        normal: witness.map(|found| found.normal),
        witnesses: WitnessCount::Unknown,
        has_all_candidates: false,
    }
}

/// A pair whose bodies are apart; their paddings may overlap.
fn of_bodies_apart(pair: &PosedPair, nearest: &Separation, witnesses: &WitnessPairs) -> PairClearance {
    let count = if witnesses.are_several() { WitnessCount::Several } else { WitnessCount::One };
    let distance = nearest.distance - pair.info.padding;
    of_witnesses(pair, [distance, distance], witnesses.pairs().first(), nearest).counted(count, witnesses)
}

/// A pair that overlaps, without a known translation that separates it.
fn without_depth(pair: &PosedPair, depth: Option<&PenetrationDepth>, common: &Separation) -> PairClearance {
    let upper = depth.map_or(0.0, |depth| -depth.lower);
    PairClearance {
        lower: f64::NEG_INFINITY,
        unknown: depth.and_then(|depth| depth.unknown),
        ..of_witnesses(pair, [upper; 2], None, common)
    }
}

impl PairClearance {
    fn counted(self, witnesses: WitnessCount, found: &WitnessPairs) -> Self {
        Self {
            witnesses,
            has_all_candidates: found.is_complete() && witnesses != WitnessCount::Unknown,
            ..self
        }
    }
}
