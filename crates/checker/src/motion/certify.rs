//! Certificates of free motions and trajectories.

use clearance_geometry::math::Extremes;
use clearance_motion::{Certificate, MotionSegment, SegmentProof, Trajectory};

use super::report::{MotionOptions, MotionReport};
use super::trajectory::{Stretch, TrajectoryReport, each_segment};
use crate::collision_checker::CollisionChecker;
use crate::workspace::Workspace;
use clearance_motion::certificate_parts;
use clearance_motion::{model_fingerprint, world_fingerprint};

impl CollisionChecker {
    /// As [`Self::check_motion_with`], with the certificate if the motion is free.
    #[must_use]
    pub fn certify_motion(
        &self,
        segment: &MotionSegment,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> (MotionReport, Option<Certificate>) {
        let (report, proofs) = self.prove(segment, options, workspace, true);
        let report = self.sure_of_contact(report, segment, options, workspace);
        let proof = SegmentProof { motion: segment.text(), proofs };
        let certificate = report.is_free().then(|| self.certificate(vec![proof], options));
        (report, certificate)
    }

    /// As [`Self::check_trajectory`], with the certificate if the trajectory is free.
    #[must_use]
    pub fn certify_trajectory(
        &self,
        trajectory: &Trajectory,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> (TrajectoryReport, Option<Certificate>) {
        let mut all = Vec::new();
        let report = each_segment(trajectory, options, |stretch| match stretch {
            Stretch::Segment(segment) => {
                let (report, proofs) = self.prove(segment, options, workspace, true);
                all.push(SegmentProof { motion: segment.text(), proofs });
                self.sure_of_contact(report, segment, options, workspace)
            }
            Stretch::Gap(gap) => self.prove(gap, options, workspace, false).0,
        });
        let certificate = report.is_free().then(|| self.certificate(all, options));
        (report, certificate)
    }

    fn certificate(&self, segments: Vec<SegmentProof>, options: &MotionOptions) -> Certificate {
        let names = |(a, b)| [self.body_name(a).to_owned(), self.body_name(b).to_owned()];
        let pairs = self.all_pairs().map(|pair| names(self.info(pair).ids)).collect();
        let parts = self.parts.get_or_init(|| certificate_parts(self.robot(), self.world(), self.settings()));
        Certificate::new(self.robot(), self.fingerprints().clone(), pairs, segments)
            .with_parts(parts.clone(), options.tolerance.greater(f64::MIN_POSITIVE).lesser(f64::MAX))
    }

    /// SHA-256 of the model with its settings, and of the world.
    #[must_use]
    pub fn fingerprints(&self) -> &[String; 2] {
        self.fingerprints.get_or_init(|| {
            let model = model_fingerprint(self.robot(), self.settings(), self.matrix.as_ref());
            [model, world_fingerprint(self.world())]
        })
    }
}
