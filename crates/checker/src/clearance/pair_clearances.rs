//! Options and result of a clearance query: near pairs, and the derivatives of their signed distances.

use clearance_geometry::math::{Extremes, Point, Vector};
use clearance_proximity::{TieTolerance, UnknownDepth, Work};
use clearance_scene::BodyId;

/// Distance of unit normals up to which candidates belong to one direction.
const ONE_NORMAL: f64 = 1e-6;

/// Options of a clearance query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearanceOptions {
    /// Pairs with a larger signed distance (m) are not reported. If it is negative, only pairs that overlap at least as deep are; NaN
    /// counts as 0.
    pub influence_distance: f64,
    /// Witness pairs count as equally near if their distances differ by at most this.
    pub tie_tolerance: TieTolerance,
    /// Number of candidates that are listed for a pair of bodies whose witness pair is not unique; 0 for none.
    pub most_candidates: usize,
}

impl ClearanceOptions {
    /// Options without candidates.
    #[must_use]
    pub fn new(influence_distance: f64) -> Self {
        Self { influence_distance, tie_tolerance: TieTolerance::default(), most_candidates: 0 }
    }
}

/// Number of witness pairs of two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WitnessCount {
    /// One: the signed distance has a derivative.
    One,
    /// Several, within the tolerance: the signed distance has directional derivatives only. The reported row is that of one of them.
    Several,
    /// Not known: the bodies overlap, and are not both convex. The row is that of a translation that separates them.
    Unknown,
}

/// Signed distance of two bodies.
///
/// Apart, it is the distance, padding subtracted. If the bodies overlap, it is minus the penetration depth: bodies enlarged by their
/// paddings separate by a translation of this length. Closed meshes then count as solids, as for [`Contact`](crate::Contact).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairClearance {
    /// The first body: a link or an attached object.
    pub a: BodyId,
    /// The second body.
    pub b: BodyId,
    /// Signed distance (m). If the depth is only bounded, it is the lower bound: after a translation of the second body by this length
    /// along the normal, the bodies are proven apart. If no such translation is known, it is `upper`.
    pub distance: f64,
    /// Lower bound (m) on the signed distance: equal to `distance`, or minus infinity if no translation is known that separates the
    /// bodies.
    pub lower: f64,
    /// Upper bound (m) on the signed distance: equal to `distance` if the bodies are apart. No translation shorter than minus this
    /// separates bodies that overlap.
    pub upper: f64,
    /// Reason why the true depth may be much larger than the bounds say, or is not known.
    pub unknown: Option<UnknownDepth>,
    /// Nearest points of the two bodies (m, root frame), without padding; if they overlap, the points that come apart last. If no
    /// separating translation is known, a common point twice.
    pub witness_points: [Point; 2],
    /// Unit vector (root frame) along which the second body moves away from the first; `None` if no separating translation is known.
    pub normal: Option<Vector>,
    /// Whether the witness points and the normal are unique.
    pub witnesses: WitnessCount,
    /// True if all witness pairs are among the candidates, or so many of them that are extreme that directional derivatives are within
    /// half a percent of the size of the contact.
    pub has_all_candidates: bool,
}

/// One of several witness pairs of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearanceCandidate {
    /// Index of the pair of bodies in [`Clearance::pairs`].
    pub pair: usize,
    /// Nearest points of the two bodies (m, root frame), without padding.
    pub witness_points: [Point; 2],
    /// Unit vector (root frame) along which the second body moves away from the first.
    pub normal: Vector,
}

/// Signed distances of all near pairs in one state, and their derivatives with respect to the positions of the configuration.
///
/// Derivatives are in metres per radian or per metre, in the order of [`Configuration::positions`]. A mimic joint contributes to the
/// position of its leader, with its multiplier. The entries of the quaternion of a floating joint are derivatives through
/// [`RobotModel::configuration`], which normalises it: their product with the quaternion itself is zero.
///
/// [`Configuration::positions`]: clearance_robot::Configuration::positions
/// [`RobotModel::configuration`]: clearance_robot::RobotModel::configuration
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clearance {
    /// Every pair whose signed distance is at most the influence distance, in the order of the pair list.
    pub pairs: Vec<PairClearance>,
    /// Derivatives of the signed distances: a row for each pair, a column for each position; zeros if no normal is known.
    pub gradient: Vec<f64>,
    /// Witness pairs of pairs of bodies that have several, if they were requested, in the order of the pairs.
    pub candidates: Vec<ClearanceCandidate>,
    /// Derivatives, as `gradient`, with a row for each candidate.
    pub candidate_gradient: Vec<f64>,
    /// Number of positions of a configuration: columns of the matrices.
    pub columns: usize,
    /// Volume tests and primitive tests that the query took.
    pub work: Work,
}

impl Clearance {
    /// Removes all results, for a robot with this number of positions.
    pub(crate) fn clear(&mut self, columns: usize) {
        self.pairs.clear();
        self.gradient.clear();
        self.candidates.clear();
        self.candidate_gradient.clear();
        (self.columns, self.work) = (columns, Work::default());
    }

    /// Derivatives of the signed distance of a pair with respect to each position.
    ///
    /// # Panics
    /// If there are not so many pairs.
    #[must_use]
    pub fn row(&self, pair: usize) -> &[f64] {
        &self.gradient[pair * self.columns..(pair + 1) * self.columns]
    }

    /// The candidates of a pair, with their derivatives.
    pub fn candidates_of(&self, pair: usize) -> impl Iterator<Item = (&ClearanceCandidate, &[f64])> {
        let first = self.candidates.partition_point(|candidate| candidate.pair < pair);
        let of_pair = self.candidates[first..].iter().take_while(move |candidate| candidate.pair == pair);
        of_pair.zip(first..).map(|(candidate, k)| {
            (candidate, &self.candidate_gradient[k * self.columns..(k + 1) * self.columns])
        })
    }

    /// Rate of change (m per unit of motion) of the signed distance of a pair, while positions begin to move with these velocities.
    /// `None` if it is not known: a pair with several witness pairs needs all its candidates.
    ///
    /// The distance of bodies that are apart is the least over all candidates, and so is its derivative (Danskin's theorem). The depth
    /// is the least over directions, in each of which it is the largest over points: of the signed distance, the derivative is the
    /// largest over normals of the least over the candidates with this normal.
    ///
    /// # Panics
    /// If there are not so many pairs, or not one velocity for each position.
    #[must_use]
    pub fn directional_derivative(&self, pair: usize, velocities: &[f64]) -> Option<f64> {
        assert_eq!(velocities.len(), self.columns, "a velocity for each position");
        let rate =
            |row: &[f64]| row.iter().zip(velocities).map(|(entry, velocity)| entry * velocity).sum::<f64>();
        let PairClearance { witnesses, has_all_candidates, witness_points: [p, q], normal, .. } =
            self.pairs[pair];
        match witnesses {
            WitnessCount::One => return Some(rate(self.row(pair))),
            WitnessCount::Several if has_all_candidates => {}
            _ => return None,
        }
        let overlaps = normal.is_some_and(|normal| normal.dot(&(q - p)) <= 0.0);
        let least = |normal: Option<&Vector>| {
            let is_like = |other: &Vector| normal.is_none_or(|normal| (normal - other).norm() <= ONE_NORMAL);
            let alike = self.candidates_of(pair).filter(|(candidate, _)| is_like(&candidate.normal));
            alike.map(|(_, row)| rate(row)).fold(f64::INFINITY, f64::lesser)
        };
        if !overlaps {
            return Some(least(None));
        }
        let of_normals = self.candidates_of(pair).map(|(candidate, _)| least(Some(&candidate.normal)));
        Some(of_normals.fold(f64::NEG_INFINITY, f64::greater))
    }
}
