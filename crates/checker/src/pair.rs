//! One pair of bodies at their poses, ready to be asked about.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_proximity as query;
use clearance_proximity::{
    CollisionBody, DistanceBounds, Effort, ElementPair, Piece, Postponed, Scratch, Separation,
};
use clearance_scene::BodyId;

use super::report::{PairDistance, UndecidedPair};

/// What never changes about a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairInfo {
    pub ids: (BodyId, BodyId),
    /// The part's index, and that of the other part or the place of the obstacle.
    pub bodies: (usize, usize),
    /// Safety distance (m) that is taken off the distance of the bodies.
    pub padding: f64,
}

/// A pair in one state.
pub(super) struct Pair<'c> {
    pub info: PairInfo,
    pub bodies: (&'c CollisionBody, &'c CollisionBody),
    /// Pose of a in the root frame.
    pub pose_ra: MatrixPose,
    pub pose_ab: MatrixPose,
}

/// What is certain about a distance without padding where the exact one would cost too much.
#[derive(Clone, Copy, Debug)]
pub(super) struct Roughly {
    pub lower: f64,
    pub upper: Separation,
}

impl Pair<'_> {
    /// Whether the padded bodies touch; if not, they are proven apart.
    pub fn touches(&self, scratch: &mut Scratch) -> bool {
        let (a, b) = self.bodies;
        query::within_margin(a, b, self.pose_ab, self.info.padding, scratch).is_some()
    }

    /// As [`Self::touches`], of some pieces of b.
    pub fn pieces_touch(&self, pieces: &[Piece], scratch: &mut Scratch) -> bool {
        let (a, b) = self.bodies;
        query::pieces_within_margin(a, (b, pieces), self.pose_ab, self.info.padding, scratch).is_some()
    }

    /// Gives what may be nearest of a and some pieces of b, or all of it, to be measured later, unless it is proven farther apart than
    /// `limit` (m). Returns a number (m) that the distance without padding certainly does not exceed.
    pub fn nearest_in_doubt(
        &self,
        pieces: Option<&[Piece]>,
        limit: f64,
        scratch: &mut Scratch,
        postpone: impl FnMut(Postponed),
    ) -> f64 {
        let (a, b) = self.bodies;
        query::nearest_in_doubt(a, (b, pieces), &self.pose_ab, limit, scratch, postpone)
    }

    /// Measures what may be nearest of the pair.
    pub fn measured(
        &self,
        postponed: &Postponed,
        scratch: &mut Scratch,
    ) -> (Separation, Option<ElementPair>) {
        postponed.measured(self.bodies, &self.pose_ab, scratch)
    }

    /// The distance without padding, unless it is proven larger than `limit`.
    pub fn separation(&self, limit: f64, scratch: &mut Scratch) -> Option<Separation> {
        let (a, b) = self.bodies;
        query::distance(a, b, self.pose_ab, limit, scratch)
    }

    /// What is certain about the distance without padding, up to a limit, with some effort.
    pub fn separation_bounds(&self, limit: f64, effort: &Effort, scratch: &mut Scratch) -> DistanceBounds {
        let (a, b) = self.bodies;
        query::distance_bounds(a, b, self.pose_ab, limit, effort, scratch)
    }

    /// As [`Self::separation`], but within the tolerances from when the state has cost too much.
    pub fn separation_while(
        &self,
        limit: f64,
        effort: &Effort,
        scratch: &mut Scratch,
    ) -> Result<Option<Separation>, Roughly> {
        let DistanceBounds { lower, upper, .. } = self.separation_bounds(limit, effort, scratch);
        match upper {
            Some(upper) if lower < upper.distance => Err(Roughly { lower, upper }),
            exact => Ok(exact),
        }
    }

    /// As [`Self::separation_while`], up to what points of the bodies are known to be `near`, which is not more than `reached` (m).
    pub fn separation_below_while(
        &self,
        (near, reached): (&Separation, f64),
        effort: &Effort,
        scratch: &mut Scratch,
    ) -> Result<Option<Separation>, Roughly> {
        let DistanceBounds { lower, upper, .. } =
            query::distance_bounds_below(self.bodies, &self.pose_ab, reached, effort, scratch);
        match upper {
            Some(upper) if lower < upper.distance => Err(Roughly { lower, upper }),
            None if lower < reached => Err(Roughly { lower: lower.lesser(near.distance), upper: *near }),
            exact => Ok(exact),
        }
    }

    /// An exact separation as it is told: which common point of bodies that touch is found depends on the limit, which must not tell
    /// what was asked before.
    pub fn told(&self, exact: &Separation, scratch: &mut Scratch) -> PairDistance {
        if exact.distance > 0.0 {
            return self.padded(exact);
        }
        self.padded(&self.separation(CONTACT_DISTANCE, scratch).unwrap_or(*exact))
    }

    /// As [`Self::touches`], until a deadline.
    pub fn contact_bounds(&self, effort: &Effort, scratch: &mut Scratch) -> DistanceBounds {
        let (a, b) = self.bodies;
        query::margin_bounds(a, b, self.pose_ab, self.info.padding, effort.deadline, scratch)
    }

    /// The pair with what is certain about its padded distance.
    pub fn undecided(&self, lower: f64, upper: Option<f64>) -> UndecidedPair {
        let (a, b) = self.info.ids;
        let padded = |raw: f64| (raw - self.info.padding).greater(0.0);
        UndecidedPair { a, b, lower: padded(lower), upper: upper.map_or(f64::INFINITY, padded) }
    }

    /// A separation in the frame of a, with the padding taken off and the points in the root frame.
    pub fn padded(&self, raw: &Separation) -> PairDistance {
        let (a, b) = self.info.ids;
        PairDistance {
            a,
            b,
            distance: (raw.distance - self.info.padding).greater(0.0),
            lower: (raw.distance - self.info.padding).greater(0.0),
            witness_points: raw.witness_points.map(|p| &self.pose_ra * p),
        }
    }
}
