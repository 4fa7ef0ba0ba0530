//! Certificate of a collision matrix: proofs that pairs of links never collide, or always, within the joint limits.

use clearance_motion::{Fingerprint, model_fingerprint};
use clearance_robot::RobotModel;
use clearance_scene::{AllowedCollisionMatrix, Settings};
use serde::{Deserialize, Serialize};

use super::always_certificate::{AlwaysProof, ContactEvidence, ElementPoint, InnerBall};

/// A document of proofs. The claims must be verified, not trusted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MatrixCertificate {
    /// Name and version of the format: [`Self::FORMAT`].
    pub format: String,
    /// The robot's name.
    pub robot: String,
    /// [`matrix_fingerprint`] of the robot.
    pub model: String,
    /// The pairs that never collide.
    pub pairs: Vec<NeverProof>,
    /// The pairs that always collide.
    pub always: Vec<AlwaysProof>,
    /// SHA-256 of all the rest; detects accidental changes.
    pub digest: String,
}

/// Proof that two links never collide.
///
/// The box of the joint positions between the links is halved again and again. The variables are numbered in the order of the joints from
/// the first link to the second; a mimic joint counts as its leader. `proof` has one character for each box, the whole box first: a digit
/// (`0`–`9`, then `A`–`Z`) halves the box along the variable of that number; the lower half follows, then the upper half. A leaf is proven
/// by the distance at its centre (`.`), by the gap along a joint axis (`|`), or by the gap along a direction (`/` and three characters).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NeverProof {
    /// Name of the first link in the URDF.
    pub link1: String,
    /// Name of the second link in the URDF.
    pub link2: String,
    /// The boxes.
    pub proof: String,
}

impl MatrixCertificate {
    /// [`Self::format`] of this version.
    pub const FORMAT: &'static str = "clearance collision matrix certificate 2";

    /// A certificate of these proofs.
    #[must_use]
    pub fn new(
        robot: &RobotModel,
        settings: &Settings,
        pairs: Vec<NeverProof>,
        always: Vec<AlwaysProof>,
    ) -> Self {
        let mut certificate = Self {
            format: Self::FORMAT.to_owned(),
            robot: robot.name().to_owned(),
            model: matrix_fingerprint(robot, settings),
            pairs,
            always,
            digest: String::new(),
        };
        certificate.digest = certificate.computed_digest();
        certificate
    }

    /// The digest of the content.
    #[must_use]
    pub fn computed_digest(&self) -> String {
        let mut print = Fingerprint::default();
        print.text(&self.format).text(&self.robot).text(&self.model).count(self.pairs.len());
        for NeverProof { link1, link2, proof } in &self.pairs {
            print.text(link1).text(link2).text(proof);
        }
        print.count(self.always.len());
        for AlwaysProof { link1, link2, evidence } in &self.always {
            print.text(link1).text(link2);
            print_evidence(&mut print, evidence);
        }
        print.finish()
    }
}

fn print_evidence(print: &mut Fingerprint, evidence: &ContactEvidence) {
    for balls in [&evidence.balls1, &evidence.balls2] {
        print.count(balls.len());
        for InnerBall { shape, face, centre, radius } in balls {
            print.count(*shape).count(*face).numbers(centre).numbers(&[*radius]);
        }
    }
    let points = evidence.contact.iter().flatten();
    print.count(points.clone().count());
    for ElementPoint { shape, face, at } in points {
        print.count(*shape).count(*face).numbers(at);
    }
    print.text(&evidence.proof);
}

/// SHA-256 of everything that decides which links can collide: shapes, joints with their limits, paddings, the meaning of meshes. The SRDF
/// does not matter.
#[must_use]
pub fn matrix_fingerprint(robot: &RobotModel, settings: &Settings) -> String {
    let settings = Settings { check_self: true, check_world: false, ..settings.clone() };
    let every_pair = AllowedCollisionMatrix::default();
    let mut print = Fingerprint::default();
    print.text("clearance collision matrix 1").text(&model_fingerprint(robot, &settings, Some(&every_pair)));
    let ranges = robot.position_ranges();
    for range in &ranges {
        print.numbers(range);
    }
    // proofs and random states keep to a joint's own limits, also where those of its followers are narrower
    for id in robot.joint_ids().filter(|id| robot.joint(*id).mimic.is_none()) {
        let own = robot.joint(id).limits.map(|limits| [limits.lower, limits.upper]);
        if let (Some(own), Some(position)) = (own, robot.first_position(id))
            && ranges[position] != own
        {
            print.count(position).numbers(&own);
        }
    }
    print.finish()
}
