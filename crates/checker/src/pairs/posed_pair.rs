//! Pair of bodies at their poses, with its distance and collision queries.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_proximity as query;
use clearance_proximity::{
    BodyPair, CollisionBody, DistanceBounds, DistanceCandidate, Effort, ElementPair, Piece, Scratch,
    Separation,
};

use super::near_points::hardly_less_than;
use crate::collision_report::{PairDistance, UndecidedPair};
use crate::robot::PairInfo;

/// A pair in one state.
pub struct PosedPair<'c> {
    pub info: PairInfo,
    pub bodies: (&'c CollisionBody, &'c CollisionBody),
    /// Pose of a in the root frame.
    pub pose_ra: MatrixPose,
    /// Pose of b in the frame of a.
    pub pose_ab: MatrixPose,
}

/// Bounds on a distance without padding, where the exact distance would cost too much.
#[derive(Clone, Copy, Debug)]
pub struct RoughDistance {
    pub lower: f64,
    pub upper: Separation,
}

impl PosedPair<'_> {
    /// The bodies as input of proximity queries.
    pub fn posed_bodies(&self) -> BodyPair<'_> {
        BodyPair { a: self.bodies.0, b: self.bodies.1, pose_ab: &self.pose_ab }
    }

    /// Upper bound (m) on the change of the distance if the pose of b in the frame of a becomes `pose_ab`: the motion of
    /// either body in the frame of the other.
    pub fn displacement_to(&self, pose_ab: &MatrixPose) -> f64 {
        let (from, to) = (&self.pose_ab, pose_ab);
        let of_b = self.bodies.1.bounding_sphere().displacement(from, to);
        let of_a = self.bodies.0.bounding_sphere().displacement(&from.inverse(), &to.inverse());
        of_a.lesser(of_b)
    }

    /// True if the padded bodies touch; otherwise they are proven apart.
    pub fn touches(&self, scratch: &mut Scratch) -> bool {
        self.comes_within(0.0, scratch)
    }

    /// True if the padded bodies come within a margin (m); otherwise they are proven farther apart.
    pub fn comes_within(&self, margin: f64, scratch: &mut Scratch) -> bool {
        let (a, b) = self.bodies;
        query::within_margin(a, b, self.pose_ab, self.info.padding + margin, scratch).is_some()
    }

    /// As [`Self::touches`], for some pieces of b.
    pub fn pieces_touch(&self, pieces: &[Piece], scratch: &mut Scratch) -> bool {
        query::pieces_within_margin(self.posed_bodies(), pieces, self.info.padding, scratch).is_some()
    }

    /// True if bodies of which only the paddings overlap come apart by the shortest way: the second one moves away from its nearest
    /// point until the distance would be the padding. Bodies with dents may touch elsewhere then.
    pub fn comes_apart(&self, apart: &Separation, scratch: &mut Scratch) -> bool {
        /// Relative lengths that are added for curved solids, whose distance is found less accurately.
        const ALLOWANCES: [f64; 2] = [0.0, 1e-6];
        let (a, b) = self.bodies;
        let [p, q] = apart.witness_points;
        let Some(away) = (q - p).try_normalize(CONTACT_DISTANCE) else { return false };
        let overlap = (self.info.padding - apart.distance).greater(0.0);
        ALLOWANCES.iter().any(|allowance| {
            let way = overlap * (1.0 + allowance) + 2.0 * CONTACT_DISTANCE;
            let pose = MatrixPose { translation: self.pose_ab.translation + way * away, ..self.pose_ab };
            query::within_margin(a, b, pose, self.info.padding, scratch).is_none()
        })
    }

    /// True if a part of a is inside a solid mesh of b; their elements must not touch.
    pub fn is_inside(&self, scratch: &mut Scratch) -> bool {
        self.pieces_touch(&[Piece::Inside], scratch)
    }

    /// Passes the candidates for the nearest elements of a and b, or of some pieces of b, to `postpone`, to be measured
    /// later. Nothing is passed if they are proven farther apart than `limit` (m). Returns an upper bound (m) on the
    /// distance without padding.
    pub fn distance_candidates(
        &self,
        pieces: Option<&[Piece]>,
        limit: f64,
        scratch: &mut Scratch,
        postpone: impl FnMut(DistanceCandidate),
    ) -> f64 {
        query::distance_candidates(self.posed_bodies(), pieces, limit, scratch, postpone)
    }

    /// Measures a candidate of the pair.
    pub fn measure(
        &self,
        candidate: &DistanceCandidate,
        scratch: &mut Scratch,
    ) -> (Separation, Option<ElementPair>) {
        candidate.measured(self.posed_bodies(), scratch)
    }

    /// The distance without padding, unless it is proven larger than `limit`.
    pub fn separation(&self, limit: f64, scratch: &mut Scratch) -> Option<Separation> {
        let (a, b) = self.bodies;
        query::distance(a, b, self.pose_ab, limit, scratch)
    }

    /// Bounds on the distance without padding, up to a limit, with the given search options.
    pub fn separation_bounds(&self, limit: f64, effort: &Effort, scratch: &mut Scratch) -> DistanceBounds {
        query::distance_bounds(self.posed_bodies(), limit, effort, scratch)
    }

    /// As [`Self::separation`], but within the tolerances once the state has cost too much.
    pub fn separation_or_bounds(
        &self,
        limit: f64,
        effort: &Effort,
        scratch: &mut Scratch,
    ) -> Result<Option<Separation>, RoughDistance> {
        let DistanceBounds { lower, upper, .. } = self.separation_bounds(limit, effort, scratch);
        match upper {
            Some(upper) if lower < upper.distance => Err(RoughDistance { lower, upper }),
            exact => Ok(exact),
        }
    }

    /// As [`Self::separation_or_bounds`], limited by the known near points `near` of the bodies; `reached` (m) is at
    /// least their distance.
    pub fn separation_below_or_bounds(
        &self,
        near: &Separation,
        reached: f64,
        effort: &Effort,
        scratch: &mut Scratch,
    ) -> Result<Option<Separation>, RoughDistance> {
        let DistanceBounds { lower, upper, .. } =
            query::distance_bounds_below(self.posed_bodies(), reached, effort, scratch);
        match upper {
            Some(upper) if lower < upper.distance => Err(RoughDistance { lower, upper }),
            None if lower < reached => {
                Err(RoughDistance { lower: lower.lesser(near.distance), upper: *near })
            }
            exact => Ok(exact),
        }
    }

    /// As [`Self::separation_bounds`], where `near` are points of the bodies.
    pub fn separation_bounds_from(
        &self,
        near: Option<&Separation>,
        limit: f64,
        effort: &Effort,
        scratch: &mut Scratch,
    ) -> Result<Option<Separation>, RoughDistance> {
        let known = near.map(|near| (near, hardly_less_than(near))).filter(|(_, reached)| *reached <= limit);
        let Some((near, reached)) = known else { return self.separation_or_bounds(limit, effort, scratch) };
        match self.separation_below_or_bounds(near, reached, effort, scratch) {
            Ok(None) => self.separation_or_bounds(limit, effort, scratch),
            found => found,
        }
    }

    /// The reported form of an exact separation. Which common point of touching bodies is found depends on the search
    /// limit; a search with a fixed limit keeps the report independent of earlier queries.
    pub fn reported(&self, exact: &Separation, scratch: &mut Scratch) -> PairDistance {
        if exact.distance > 0.0 {
            return self.padded(exact);
        }
        self.padded(&self.separation(CONTACT_DISTANCE, scratch).unwrap_or(*exact))
    }

    /// The separation of bodies that touch with their paddings, and its elements if [`Self::elements_touch`] can test
    /// them; otherwise a lower bound (m) on the distance without padding, which is more than the padding. `near` (m) is an
    /// upper bound.
    ///
    /// To prove half of the gap costs hardly more than to prove that there is one, and lasts for more states.
    pub fn contact_or_bound(
        &self,
        near: f64,
        scratch: &mut Scratch,
    ) -> Result<(Separation, Option<ElementPair>), f64> {
        let padding = self.info.padding.greater(CONTACT_DISTANCE);
        let aim = padding + 0.5 * (near - padding).greater(0.0);
        match query::elements_found_within_margin(self.posed_bodies(), aim, scratch) {
            Some((found, elements)) if found.distance <= padding => Ok((found, elements)),
            Some((found, _)) => Err(found.distance),
            None => Err(aim),
        }
    }

    /// The separation of two elements if they touch with the paddings of the bodies.
    pub fn elements_touch(&self, elements: ElementPair, scratch: &mut Scratch) -> Option<Separation> {
        query::elements_within_margin(self.posed_bodies(), elements, self.info.padding, scratch)
    }

    /// As [`Self::touches`], until a deadline.
    pub fn contact_bounds(&self, effort: &Effort, scratch: &mut Scratch) -> DistanceBounds {
        query::margin_bounds(self.posed_bodies(), self.info.padding, effort.deadline, scratch)
    }

    /// The pair with bounds on its padded distance.
    pub fn undecided(&self, lower: f64, upper: Option<f64>) -> UndecidedPair {
        let (a, b) = self.info.ids;
        let padded = |raw: f64| (raw - self.info.padding).greater(0.0);
        UndecidedPair { a, b, lower: padded(lower), upper: upper.map_or(f64::INFINITY, padded) }
    }

    /// Converts a separation in the frame of a: subtracts the padding, and transforms the points to the root frame.
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
