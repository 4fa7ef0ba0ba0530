//! Lower bounds on the distances of all self pairs and of all world pairs in one state.

use clearance_checker::{CollisionChecker, CollisionReport, PairKind};
use clearance_geometry::math::Extremes;

/// Lower bounds (m) on the distances of all pairs of a kind, padding subtracted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct DistanceBounds {
    of_self: f64,
    of_world: f64,
}

impl DistanceBounds {
    /// The bounds that the report on a survey implies: `influence_distance` and `limit` (m) are those of the question.
    /// They are zero where the deadline left pairs undecided.
    pub fn of(
        report: &CollisionReport,
        checker: &CollisionChecker,
        [influence_distance, limit]: [f64; 2],
    ) -> Self {
        let of = |kind: PairKind| {
            if !checker.checks(kind) {
                return f64::INFINITY;
            }
            if report.has_collision(kind) || !report.undecided.is_empty() {
                return 0.0;
            }
            // nothing beyond the influence distance was searched for if the deadline passed before
            let beyond = match report.unfinished {
                Some(unfinished) if unfinished == kind => influence_distance,
                _ => influence_distance.greater(limit),
            };
            let reported = report.pair_distances.iter().chain(report.nearest_of(kind));
            let of_kind = reported.filter(|pair| pair.kind() == kind);
            of_kind.map(|pair| pair.lower).fold(beyond, f64::lesser)
        };
        Self { of_self: of(PairKind::SelfPair), of_world: of(PairKind::WorldPair) }
    }

    /// The bound (m) on the distances of the pairs of one kind.
    pub fn of_kind(&self, kind: PairKind) -> f64 {
        match kind {
            PairKind::SelfPair => self.of_self,
            PairKind::WorldPair => self.of_world,
        }
    }
}
