//! Checks motions and trajectories with proofs, and builds the certificates of free ones.

use std::sync::OnceLock;

use clearance_geometry::math::Extremes;
use clearance_motion::{
    Certificate, CertificateParts, MotionSegment, SegmentProof, Trajectory, certificate_parts,
    model_fingerprint, world_fingerprint,
};
use clearance_scene::{AllowedCollisionMatrix, BodyId, Settings};

use super::motion_check::MotionCheck;
use super::motion_report::{MotionOptions, MotionReport};
use super::trajectory_check::{Stretch, TrajectoryReport, check_stretches};
use crate::pairs::CheckedPairs;

/// Checks a motion; if it is free, the proofs are returned, too.
pub fn prove_motion(
    check: &mut MotionCheck,
    segment: &MotionSegment,
) -> (MotionReport, Option<Vec<SegmentProof>>) {
    let (report, proofs) = check.check_with_proofs(segment);
    let proof = SegmentProof { motion: segment.text(), proofs };
    let free = report.is_free().then(|| vec![proof]);
    (report, free)
}

/// Checks a trajectory; if it is free, the proofs of all segments are returned, too.
pub fn prove_trajectory(
    check: &mut MotionCheck,
    trajectory: &Trajectory,
) -> (TrajectoryReport, Option<Vec<SegmentProof>>) {
    let mut all = Vec::new();
    let report = check_stretches(trajectory, check.options(), |stretch| match stretch {
        Stretch::Segment(segment) => {
            let (report, proofs) = check.check_with_proofs(segment);
            all.push(SegmentProof { motion: segment.text(), proofs });
            report
        }
        Stretch::Gap(gap) => check.prove(gap, false).0,
    });
    let free = report.is_free().then_some(all);
    (report, free)
}

/// Parts of certificates that depend only on the robot and its world; computed at their first use.
#[derive(Clone, Debug, Default)]
pub struct CertificateConstants {
    /// SHA-256 of the model with its settings, and of the world.
    fingerprints: OnceLock<[String; 2]>,
    parts: OnceLock<CertificateParts>,
}

/// Robot, world and settings that a certificate is about.
#[derive(Clone, Copy)]
pub struct CertificateSubject<'c> {
    pub pairs: &'c CheckedPairs,
    pub settings: &'c Settings,
    pub matrix: Option<&'c AllowedCollisionMatrix>,
}

impl CertificateConstants {
    /// The certificate of free segments, for a check with these options.
    pub fn certificate(
        &self,
        subject: CertificateSubject,
        segments: Vec<SegmentProof>,
        options: &MotionOptions,
    ) -> Certificate {
        let CertificateSubject { pairs, settings, matrix } = subject;
        let (robot, world) = (pairs.robot().model(), pairs.world().world());
        let name = |id: BodyId| pairs.body_name(id).to_owned();
        let names = pairs.numbers().map(|pair| pairs.info(pair).ids).map(|(a, b)| [name(a), name(b)]);
        let parts = self.parts.get_or_init(|| certificate_parts(robot, world, settings));
        let fingerprints = self
            .fingerprints
            .get_or_init(|| [model_fingerprint(robot, settings, matrix), world_fingerprint(world)]);
        Certificate::new(robot, fingerprints.clone(), names.collect(), segments)
            .with_parts(parts.clone(), options.tolerance.greater(f64::MIN_POSITIVE).lesser(f64::MAX))
            .with_margin(options.kept_margin().lesser(f64::MAX))
    }
}
