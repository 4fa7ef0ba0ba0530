//! Verifies the proofs of one segment: a pair of bodies stays apart during each interval.

use std::borrow::Cow;

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_motion::Proof;
use clearance_scene::ObstacleId;

use super::body::Body;
use super::interval_midpoint::{BodyCarrier, BodyPlacement, IntervalMidpoint};
use super::motion_bound::{PairMotion, Side};
use super::proof_interval::ProofInterval;
use super::segment_kinematics::{Rate, SegmentKinematics};
use super::separation_test::SeparationTest;
use super::verifier_model::VerifierModel;
use super::{Rejection, VerificationStatistics};

/// Tolerance (m) by which distances may be below the claimed ones: the accuracy of the search for nearest points of round solids.
const CLAIM_SLACK: f64 = 1e-9;

/// Amount added to a bound, in m and as a fraction of it (`docs/derivations/motion-bound.md`).
const BOUND_SLACK: f64 = 1e-9;

/// The distance (m) in the middle of an interval at which a pair with an approach of at most `found` touches nowhere in it.
fn keeping_apart(found: f64) -> f64 {
    found * (1.0 + BOUND_SLACK) + BOUND_SLACK.greater(CONTACT_DISTANCE)
}

/// Verifies the proofs of one segment, and counts the work.
pub(super) struct SegmentVerifier<'p, 'r> {
    model: &'p VerifierModel<'r>,
    segment: usize,
    /// Distance (m) that pairs have to keep, besides their paddings.
    margin: f64,
    kinematics: &'p SegmentKinematics,
    midpoint: IntervalMidpoint,
    /// By step, for the interval at hand.
    rates: Vec<Rate>,
    statistics: VerificationStatistics,
}

impl<'p, 'r> SegmentVerifier<'p, 'r> {
    pub fn new(
        model: &'p VerifierModel<'r>,
        segment: usize,
        margin: f64,
        kinematics: &'p SegmentKinematics,
    ) -> Self {
        let midpoint = IntervalMidpoint::new(model.robot, model.bodies.len());
        Self {
            model,
            segment,
            margin,
            kinematics,
            midpoint,
            rates: Vec::new(),
            statistics: VerificationStatistics::default(),
        }
    }

    /// Checks all proofs, those of one middle together.
    pub fn check_proofs(mut self, proofs: &[Proof]) -> Result<VerificationStatistics, Rejection> {
        let intervals = proofs.iter().map(|p| ProofInterval::new(p.1, p.2)).zip(0..);
        let mut order: Vec<(ProofInterval, usize)> = intervals.collect();
        order.sort_by(|(i, _), (j, _)| {
            i.middle.total_cmp(&j.middle).then(i.half_width.total_cmp(&j.half_width))
        });
        let mut seen = vec![false; self.model.required.pairs.len()];
        let mut last = None;
        for (interval, proof) in order {
            self.model.check_stop()?;
            if last != Some(interval) {
                self.go_to(interval);
                last = Some(interval);
            }
            let pair = proofs[proof].0;
            self.place(pair);
            self.check_proof(proof, &proofs[proof], interval)?;
            // surfaces stay apart, so a body that is outside once is outside throughout
            if !std::mem::replace(&mut seen[pair], true) {
                self.check_not_inside(pair)?;
            }
        }
        self.statistics.proofs = proofs.len();
        Ok(self.statistics)
    }

    pub fn go_to(&mut self, interval: ProofInterval) {
        if self.midpoint.t != interval.middle {
            self.midpoint.go_to(self.model.robot, self.kinematics, interval.middle);
        }
        let rates = self.kinematics.steps.iter().map(|step| step.rate(interval.middle, interval.half_width));
        self.rates.clear();
        self.rates.extend(rates);
    }

    pub fn bodies(&self, pair: usize) -> [(usize, &'p Body, &'p [usize]); 2] {
        let VerifierModel { required, bodies, paths, .. } = self.model;
        required.pairs[pair].bodies.map(|index| {
            let path = match index.checked_sub(paths.len()) {
                None => paths[index].as_slice(),
                Some(obstacle) => self.kinematics.obstacle_path(obstacle),
            };
            (index, bodies[index].as_ref().expect("pairs name only bodies with geometry"), path)
        })
    }

    pub fn place(&mut self, pair: usize) {
        for (index, body, path) in self.bodies(pair) {
            let carriers = &self.model.carriers;
            let obstacle = || BodyCarrier::Obstacle(index - carriers.len());
            let carrier = carriers.get(index).map_or_else(obstacle, |link| BodyCarrier::Link(*link));
            self.midpoint.place(self.kinematics, BodyPlacement { index, carrier, body, path });
        }
    }

    /// Proves one pair apart on one interval.
    fn check_proof(&mut self, proof: usize, claim: &Proof, interval: ProofInterval) -> Result<(), Rejection> {
        let Proof(pair, _, _, lower, bound) = *claim;
        let required = &self.model.required.pairs[pair];
        let (segment, padding) = (self.segment, required.padding + self.margin);
        let keeps = |found: f64| found <= bound * (1.0 + BOUND_SLACK) + BOUND_SLACK;
        let leaves = |found: f64| keeping_apart(found) + padding < lower;
        let mut found = self.bound(pair, interval, false);
        if !(keeps(found) && leaves(found)) {
            self.statistics.exact_bounds += 1;
            found = self.bound(pair, interval, true).lesser(found);
        }
        if !keeps(found) {
            return Err(Rejection::Bound { segment, proof, bound, found });
        }
        if !leaves(found) {
            return Err(Rejection::Margin { segment, proof, lower, found, padding });
        }
        let needed = keeping_apart(found) + padding + self.midpoint.rounding(required.bodies);
        if self.is_apart(pair, needed.greater(lower - CLAIM_SLACK)) {
            return Ok(());
        }
        let (pair, at) = (required.names.clone(), interval.middle);
        Err(Rejection::Near { segment, proof, pair, at, lower })
    }

    /// True if a pair is proven free of contact in the whole interval, without a claimed bound.
    pub fn is_apart_throughout(&mut self, pair: usize, interval: ProofInterval) -> bool {
        self.go_to(interval);
        self.place(pair);
        let required = &self.model.required.pairs[pair];
        let (padding, rounding) = (required.padding + self.margin, self.midpoint.rounding(required.bodies));
        let proves = |found: f64, verifier: &mut Self| {
            let needed = keeping_apart(found) + padding + rounding;
            needed.is_finite() && verifier.is_apart(pair, needed)
        };
        let rough = self.bound(pair, interval, false);
        proves(rough, self) || {
            let exact = self.bound(pair, interval, true).lesser(rough);
            proves(exact, self)
        }
    }

    /// Maximum decrease of a placed pair's distance in the interval.
    pub fn bound(&mut self, pair: usize, interval: ProofInterval, exact: bool) -> f64 {
        let both = self.bodies(pair);
        if exact {
            for (index, body, path) in both {
                self.midpoint.measure(index, body, path);
            }
        }
        let (placed, lines) = (both.map(|(index, ..)| self.midpoint.placed(index)), self.midpoint.lines());
        let shared = both[0].2.iter().zip(both[1].2).take_while(|(a, b)| a == b).count();
        let reach = |i: usize| {
            let (path, other) = (both[i].2, both[1 - i].1);
            // for an infinite body, the motion is bounded at the other body
            match (both[i].1.planes().is_empty(), exact) {
                (true, true) => Cow::from(placed[i].exact_reach.as_ref().unwrap_or(&placed[i].reach)),
                (true, false) => Cow::from(&placed[i].reach),
                (false, true) => Cow::from(placed[1 - i].body_reach(lines, other, path)),
                (false, false) => Cow::from(placed[1 - i].box_reach(lines, path)),
            }
        };
        let reaches = [reach(0), reach(1)];
        let side = |i: usize| Side { path: &both[i].2[shared..], reach: &reaches[i][shared..] };
        let motion = PairMotion { bodies: both.map(|(_, body, _)| body), placed, sides: [side(0), side(1)] };
        let unknown: f64 = both.iter().map(|(index, ..)| self.unknown_displacement(*index, interval)).sum();
        motion.bound(lines, &self.rates, interval.half_width, exact) + unknown
    }

    /// Maximum displacement (m) that the limits of an obstacle allow until the end of the interval; 0 for a robot body.
    fn unknown_displacement(&self, index: usize, interval: ProofInterval) -> f64 {
        let Some(uncertainty) = self.kinematics.motion.uncertainty() else { return 0.0 };
        let Some(obstacle) = index.checked_sub(self.model.carriers.len()) else { return 0.0 };
        let id = u32::try_from(obstacle).map(ObstacleId).ok();
        let obstacle = id.and_then(|id| self.model.world.place(id));
        obstacle.map_or(f64::INFINITY, |of| uncertainty.of(&of.name, interval.middle + interval.half_width))
    }

    /// True if a placed pair is proven at least `target` (m) apart.
    pub fn is_apart(&mut self, pair: usize, target: f64) -> bool {
        let [(i, a, _), (j, b, _)] = self.bodies(pair);
        let pose_ab = self.midpoint.placed(i).pose_rb.relative(&self.midpoint.placed(j).pose_rb);
        let mut test = SeparationTest::new(a, b, pose_ab, target);
        let proven = test.prove();
        self.statistics.element_tests += test.element_tests;
        proven
    }

    /// Rejects a pair of which one body lies inside the other's closed mesh, if meshes are solids.
    fn check_not_inside(&self, pair: usize) -> Result<(), Rejection> {
        let [(i, a, _), (j, b, _)] = self.bodies(pair);
        let (Some(a), Some(b)) = (&a.interior, &b.interior) else { return Ok(()) };
        let pose_ab = self.midpoint.placed(i).pose_rb.relative(&self.midpoint.placed(j).pose_rb);
        if !a.overlap(b, &pose_ab) {
            return Ok(());
        }
        let pair = self.model.required.pairs[pair].names.clone();
        Err(Rejection::Inside { segment: self.segment, pair, at: self.midpoint.t })
    }
}
