//! The verifier: checks all claims of a certificate of a motion for one robot in one world.

use clearance_motion::{Certificate, MotionSegment};
use clearance_robot::RobotModel;
use clearance_scene::{AllowedCollisionMatrix, Settings, World};
use std::sync::atomic::AtomicBool;

use super::segment_kinematics::SegmentKinematics;
use super::segment_verifier::SegmentVerifier;
use super::verifier_model::VerifierModel;
use super::{ExpectedMotion, Rejection, VerificationStatistics};
use super::{certificate_content, interval_coverage, segment_continuity};

/// Verifies certificates about one robot in one world; bodies are built once.
///
/// It is immutable after construction and can be shared by threads.
#[derive(Debug)]
pub struct Verifier<'r> {
    pub(super) model: VerifierModel<'r>,
}

/// As [`Verifier::verify`], for one certificate.
///
/// # Errors
/// The first claim that could not be proven, or the first difference from this robot and world.
pub fn verify(
    robot: &RobotModel,
    world: &World,
    settings: &Settings,
    matrix: Option<&AllowedCollisionMatrix>,
    certificate: &Certificate,
) -> Result<VerificationStatistics, Rejection> {
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
    ) -> Result<Self, Rejection> {
        let model = VerifierModel::new(robot, world, settings, matrix)?;
        Ok(Self { model })
    }

    /// Lets another thread end a verification: once `stop` is true, certificates are rejected with [`Rejection::Stopped`].
    #[must_use]
    pub fn stopped_by(mut self, stop: &'r AtomicBool) -> Self {
        self.model.stop = Some(stop);
        self
    }

    /// Accepts a certificate only if all of its claims are proven here again. The caller must check which motion of
    /// the robot and of the obstacles it is about.
    ///
    /// # Errors
    /// The first claim that could not be proven, or the first difference from this robot and world.
    pub fn verify(&self, certificate: &Certificate) -> Result<VerificationStatistics, Rejection> {
        let any_motion = ExpectedMotion { any_obstacle_motion: true, ..ExpectedMotion::default() };
        self.verify_expected(certificate, &any_motion)
    }

    /// As [`Self::verify`], but accepts only a certificate of the expected motion.
    ///
    /// # Errors
    /// As [`Self::verify`], and if the certificate is about another motion.
    pub fn verify_expected(
        &self,
        certificate: &Certificate,
        expected: &ExpectedMotion,
    ) -> Result<VerificationStatistics, Rejection> {
        certificate_content::check(certificate, self.model.robot, &self.model.required)?;
        let motions = |segment| {
            let motion = certificate.segment(self.model.robot, segment);
            motion.map_err(|error| Rejection::Motion { segment, error })
        };
        let given = (0..certificate.segments.len()).map(motions).collect::<Result<Vec<_>, _>>()?;
        let expected_segments = expected.check(self.model.robot.position_names(), certificate, &given)?;
        let verified = self.prove(certificate, given, expected)?;
        // numbers that differ by rounding are nevertheless a different motion
        expected_segments
            .map_or(Ok(()), |segments| self.prove(certificate, segments, expected).map(|_| ()))?;
        Ok(verified)
    }

    /// Checks that the proofs of a certificate prove these segments free.
    fn prove(
        &self,
        certificate: &Certificate,
        segments: Vec<MotionSegment>,
        expected: &ExpectedMotion,
    ) -> Result<VerificationStatistics, Rejection> {
        let pairs = self.model.required.pairs.len();
        let mut verified =
            VerificationStatistics { segments: segments.len(), pairs, ..VerificationStatistics::default() };
        let margin = certificate.kept_margin();
        let mut last: Option<SegmentKinematics> = None;
        for ((segment, motion), proof) in segments.into_iter().enumerate().zip(&certificate.segments) {
            let kinematics = SegmentKinematics::new(self.model.robot, self.model.world, segment, motion)?;
            certificate_content::check_ends(segment, &kinematics, self.model.robot)?;
            match &last {
                Some(last) => {
                    segment_continuity::check(&self.model, (segment, margin), &last.motion, &kinematics)?;
                }
                None if expected.determines_obstacle_starts() => {}
                None => segment_continuity::check_start(&self.model, margin, &kinematics)?,
            }
            interval_coverage::check(segment, margin, &proof.proofs, &self.model.required.pairs)?;
            let statistics = SegmentVerifier::new(&self.model, segment, margin, &kinematics)
                .check_proofs(&proof.proofs)?;
            verified.add(&statistics);
            last = Some(kinematics);
        }
        Ok(verified)
    }
}
