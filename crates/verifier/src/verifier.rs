//! Verifies that a certificate proves its claims.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_motion::{Certificate, MotionSegment, Proof};
use clearance_motion::{certificate_parts, model_fingerprint, world_fingerprint};
use clearance_robot::{LinkId, RobotModel};
use clearance_scene::AllowedCollisionMatrix;
use clearance_scene::Settings;
use clearance_scene::World;
use std::borrow::Cow;

use super::apart::Apart;
use super::body::Body;
use super::bound::{Approach, Side};
use super::documents::{self, Subject};
use super::interval_midpoint::{IntervalMidpoint, Ride};
use super::segment_kinematics::{Rate, SegmentKinematics, link_paths};
use super::{Expected, Refusal, Verified, coverage, joins, subjects};

/// Tolerance (m) by which distances may be below the claimed ones: the accuracy of the search for nearest points of round solids.
const CLAIM_SLACK: f64 = 1e-9;

/// Amount added to a bound, in m and as a fraction of it (`docs/derivations/motion-bound.md`).
const BOUND_SLACK: f64 = 1e-9;

/// The distance (m) in the middle of an interval at which a pair with an approach of at most `found` touches nowhere in it.
fn keeping_apart(found: f64) -> f64 {
    found * (1.0 + BOUND_SLACK) + BOUND_SLACK.greater(CONTACT_DISTANCE)
}

/// Verifies certificates about one robot in one world; bodies are built once.
#[derive(Debug)]
pub struct Verifier<'r> {
    pub(super) robot: &'r RobotModel,
    pub(super) world: &'r World,
    pub(super) subject: Subject,
    /// By link, by attached object, then by obstacle.
    bodies: Vec<Option<Body>>,
    /// By link and attached object: the link whose pose it has, and the steps that move that.
    carriers: Vec<LinkId>,
    paths: Vec<Vec<usize>>,
}

/// As [`Verifier::verify`], for one certificate.
pub fn verify(
    robot: &RobotModel,
    world: &World,
    settings: &Settings,
    matrix: Option<&AllowedCollisionMatrix>,
    certificate: &Certificate,
) -> Result<Verified, Refusal> {
    Verifier::new(robot, world, settings, matrix)?.verify(certificate)
}

impl<'r> Verifier<'r> {
    /// Selects the pairs that have to be proven. A scene's matrix, if given, decides the pairs instead of the SRDF.
    ///
    /// # Errors
    /// If paddings or scales are invalid for this robot.
    pub fn new(
        robot: &'r RobotModel,
        world: &'r World,
        settings: &Settings,
        matrix: Option<&AllowedCollisionMatrix>,
    ) -> Result<Self, Refusal> {
        let pairs = subjects::pairs(robot, world, settings, matrix)?;
        let bodies = subjects::bodies(robot, world, settings, &pairs)?;
        let model = model_fingerprint(robot, settings, matrix);
        let parts = certificate_parts(robot, world, settings);
        let subject = Subject { model, world: world_fingerprint(world), parts, pairs };
        let carriers = subjects::carriers(robot, world)?;
        let of_links = link_paths(robot);
        let paths = carriers.iter().map(|link| of_links[link.index()].clone()).collect();
        Ok(Self { robot, world, subject, bodies, carriers, paths })
    }

    /// Accepts a certificate only if all of its claims are proven here again. The caller must check which motion it belongs to.
    pub fn verify(&self, certificate: &Certificate) -> Result<Verified, Refusal> {
        self.verify_expected(certificate, &Expected::default())
    }

    /// As [`Self::verify`], but accepts only a certificate of the expected motion.
    pub fn verify_expected(
        &self,
        certificate: &Certificate,
        expected: &Expected,
    ) -> Result<Verified, Refusal> {
        documents::check(certificate, self.robot, &self.subject)?;
        let motions = |segment| {
            let motion = certificate.segment(self.robot, segment);
            motion.map_err(|error| Refusal::Motion { segment, error })
        };
        let given = (0..certificate.segments.len()).map(motions).collect::<Result<Vec<_>, _>>()?;
        let meant = expected.check(self, certificate, &given)?;
        let verified = self.prove(certificate, given, expected)?;
        // numbers that differ by rounding are nevertheless a different motion
        meant.map_or(Ok(()), |meant| self.prove(certificate, meant, expected).map(|_| ()))?;
        Ok(verified)
    }

    /// Checks that the proofs of a certificate prove these segments free.
    fn prove(
        &self,
        certificate: &Certificate,
        segments: Vec<MotionSegment>,
        expected: &Expected,
    ) -> Result<Verified, Refusal> {
        let pairs = self.subject.pairs.len();
        let mut verified = Verified { segments: segments.len(), pairs, ..Verified::default() };
        let mut last: Option<SegmentKinematics> = None;
        for ((segment, motion), proof) in segments.into_iter().enumerate().zip(&certificate.segments) {
            let course = SegmentKinematics::new(self.robot, self.world, segment, motion)?;
            documents::check_ends(segment, &course, self.robot)?;
            match &last {
                Some(last) => joins::check(self, segment, &last.motion, &course)?,
                None if expected.tells_starts() => {}
                None => joins::check_start(self, &course)?,
            }
            coverage::check(segment, &proof.proofs, &self.subject.pairs)?;
            let mut pass = Pass::new(self, segment, &course);
            pass.proofs(&proof.proofs)?;
            verified.add(&pass.verified);
            last = Some(course);
        }
        Ok(verified)
    }
}

/// The segment that is being verified.
pub(super) struct Pass<'p, 'r> {
    verifier: &'p Verifier<'r>,
    segment: usize,
    course: &'p SegmentKinematics,
    moment: IntervalMidpoint,
    /// By step, for the interval at hand.
    rates: Vec<Rate>,
    verified: Verified,
}

/// A proof's interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub middle: f64,
    pub half_width: f64,
}

impl Interval {
    pub fn new(from: f64, to: f64) -> Self {
        let middle = 0.5 * (from + to);
        Self { middle, half_width: (to - middle).greater(middle - from) }
    }
}

impl<'p, 'r> Pass<'p, 'r> {
    pub fn new(verifier: &'p Verifier<'r>, segment: usize, course: &'p SegmentKinematics) -> Self {
        let moment = IntervalMidpoint::new(verifier.robot, verifier.bodies.len());
        Self { verifier, segment, course, moment, rates: Vec::new(), verified: Verified::default() }
    }

    /// Checks all proofs, those of one middle together.
    fn proofs(&mut self, proofs: &[Proof]) -> Result<(), Refusal> {
        let intervals = proofs.iter().map(|p| Interval::new(p.1, p.2)).zip(0..);
        let mut order: Vec<(Interval, usize)> = intervals.collect();
        order.sort_by(|(i, _), (j, _)| {
            i.middle.total_cmp(&j.middle).then(i.half_width.total_cmp(&j.half_width))
        });
        let mut seen = vec![false; self.verifier.subject.pairs.len()];
        let mut last = None;
        for (interval, proof) in order {
            if last != Some(interval) {
                self.go_to(interval);
                last = Some(interval);
            }
            let pair = proofs[proof].0;
            self.place(pair);
            self.proof(proof, &proofs[proof], interval)?;
            // surfaces stay apart, so a body that is outside once is outside throughout
            if !std::mem::replace(&mut seen[pair], true) {
                self.outside(pair)?;
            }
        }
        self.verified.proofs = proofs.len();
        Ok(())
    }

    pub fn go_to(&mut self, interval: Interval) {
        if self.moment.t != interval.middle {
            self.moment.go_to(self.verifier.robot, self.course, interval.middle);
        }
        let rates = self.course.steps.iter().map(|step| step.rate(interval.middle, interval.half_width));
        self.rates.clear();
        self.rates.extend(rates);
    }

    pub fn bodies(&self, pair: usize) -> [(usize, &'p Body, &'p [usize]); 2] {
        let Verifier { subject, bodies, paths, .. } = self.verifier;
        subject.pairs[pair].bodies.map(|index| {
            let path = match index.checked_sub(paths.len()) {
                None => paths[index].as_slice(),
                Some(obstacle) => self.course.obstacle_path(obstacle),
            };
            (index, bodies[index].as_ref().expect("pairs name only bodies with geometry"), path)
        })
    }

    pub fn place(&mut self, pair: usize) {
        for (index, body, path) in self.bodies(pair) {
            let carriers = &self.verifier.carriers;
            let obstacle = || Ride::Obstacle(index - carriers.len());
            let ride = carriers.get(index).map_or_else(obstacle, |link| Ride::On(*link));
            self.moment.place(self.course, (index, ride), body, path);
        }
    }

    /// Proves one pair apart on one interval.
    fn proof(&mut self, proof: usize, claim: &Proof, interval: Interval) -> Result<(), Refusal> {
        let Proof(pair, _, _, lower, bound) = *claim;
        let subject = &self.verifier.subject.pairs[pair];
        let (segment, padding) = (self.segment, subject.padding);
        let keeps = |found: f64| found <= bound * (1.0 + BOUND_SLACK) + BOUND_SLACK;
        let leaves = |found: f64| keeping_apart(found) + padding < lower;
        let mut found = self.bound(pair, interval, false);
        if !(keeps(found) && leaves(found)) {
            self.verified.exact_bounds += 1;
            found = self.bound(pair, interval, true).lesser(found);
        }
        if !keeps(found) {
            return Err(Refusal::Bound { segment, proof, bound, found });
        }
        if !leaves(found) {
            return Err(Refusal::Margin { segment, proof, lower, found, padding });
        }
        let needed = keeping_apart(found) + padding + self.moment.rounding(subject.bodies);
        if self.apart(pair, needed.greater(lower - CLAIM_SLACK)) {
            return Ok(());
        }
        let (pair, at) = (subject.names.clone(), interval.middle);
        Err(Refusal::Near { segment, proof, pair, at, lower })
    }

    /// True if a pair is proven free of contact in the whole interval, without a claimed bound.
    pub fn is_apart_throughout(&mut self, pair: usize, interval: Interval) -> bool {
        self.go_to(interval);
        self.place(pair);
        let subject = &self.verifier.subject.pairs[pair];
        let (padding, rounding) = (subject.padding, self.moment.rounding(subject.bodies));
        let is_apart = |found: f64, pass: &mut Self| {
            let needed = keeping_apart(found) + padding + rounding;
            needed.is_finite() && pass.apart(pair, needed)
        };
        let rough = self.bound(pair, interval, false);
        is_apart(rough, self) || {
            let exact = self.bound(pair, interval, true).lesser(rough);
            is_apart(exact, self)
        }
    }

    /// Maximum decrease of a placed pair's distance in the interval.
    pub fn bound(&mut self, pair: usize, interval: Interval, exact: bool) -> f64 {
        let both = self.bodies(pair);
        if exact {
            for (index, body, path) in both {
                self.moment.measure(index, body, path);
            }
        }
        let (placed, lines) = (both.map(|(index, ..)| self.moment.placed(index)), self.moment.lines());
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
        let approach = Approach { bodies: both.map(|(_, body, _)| body), placed, sides: [side(0), side(1)] };
        approach.bound(lines, &self.rates, interval.half_width, exact)
    }

    /// True if a placed pair is proven at least `target` (m) apart.
    pub fn apart(&mut self, pair: usize, target: f64) -> bool {
        let [(i, a, _), (j, b, _)] = self.bodies(pair);
        let pose_ab = self.moment.placed(i).pose_rb.relative(&self.moment.placed(j).pose_rb);
        let mut apart = Apart::new(a, b, pose_ab, target);
        let proven = apart.prove();
        self.verified.element_tests += apart.element_tests;
        proven
    }

    /// Rejects a pair of which one body lies inside the other's closed mesh, if meshes are solids.
    fn outside(&self, pair: usize) -> Result<(), Refusal> {
        let [(i, a, _), (j, b, _)] = self.bodies(pair);
        let (Some(a), Some(b)) = (&a.interior, &b.interior) else { return Ok(()) };
        let pose_ab = self.moment.placed(i).pose_rb.relative(&self.moment.placed(j).pose_rb);
        if !a.overlap(b, &pose_ab) {
            return Ok(());
        }
        let pair = self.verifier.subject.pairs[pair].names.clone();
        Err(Refusal::Inside { segment: self.segment, pair, at: self.moment.t })
    }
}
