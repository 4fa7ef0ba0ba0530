//! A proof that a motion is free, as a document that others can check.
//!
//! For every pair of bodies that has to be checked it lists intervals that cover [0, 1]. On each the pair's distance in the
//! middle is said to be not less than `lower`, and to lose at most `bound` on the way to either end:
//! the pair is apart throughout if `lower > bound + padding`. The bound is derived in
//! `docs/derivations/motion-bound.md`. Hashes say which model, world and motion it is about, and a digest that nothing in it was
//! altered by accident; what it claims is not to be trusted but checked.

use serde::{Deserialize, Serialize};

use super::Fingerprint;
use super::segment::SegmentText;
use super::{MotionSegment, SegmentError};
use crate::robot::{ConfigurationError, RobotModel};

/// What [`Certificate::format`] says.
pub const FORMAT: &str = "clearance certificate 1";

/// A proof that a robot can make a motion and hits nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// [`FORMAT`].
    pub format: String,
    /// The robot's name.
    pub robot: String,
    /// SHA-256 of the model: links, joints, shapes, paddings.
    pub model: String,
    /// SHA-256 of the obstacles.
    pub world: String,
    /// SHA-256 of joints and segments' motions.
    pub motion: String,
    /// Names of the positions.
    pub joints: Vec<String>,
    /// Names of the bodies of the pairs that have to be checked.
    pub pairs: Vec<[String; 2]>,
    pub segments: Vec<SegmentProof>,
    /// SHA-256 of all the rest.
    pub digest: String,
}

/// A stretch of the motion and the proof that it is free.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentProof {
    pub motion: SegmentText,
    /// In the order of pairs, then of time: `[pair, from, to, lower, bound]`.
    pub proofs: Vec<Proof>,
}

/// One pair is apart from `from` to `to`: `(pair, from, to, lower, bound)` with the pair's number, two fractions of the segment, and two
/// lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Proof(pub usize, pub f64, pub f64, pub f64, pub f64);

/// Why a text is no certificate.
#[derive(Debug, thiserror::Error)]
pub enum CertificateError {
    #[error("this is no certificate: {0}")]
    Text(#[from] serde_json::Error),
    #[error("the format is '{0}', but only '{FORMAT}' is known")]
    Format(String),
    #[error("the digest does not fit the content: something in it was altered")]
    Digest,
    #[error("segment {segment}: {error}")]
    Segment { segment: usize, error: SegmentError },
    #[error("segment {segment}: {error}")]
    Configuration { segment: usize, error: ConfigurationError },
    #[error("segment {0} has neither 'from' and 'to' nor 'polynomials', or both")]
    NoMotion(usize),
}

impl Certificate {
    /// A certificate of these parts, with its digest.
    #[must_use]
    pub fn new(
        robot: &RobotModel,
        [model, world]: [String; 2],
        pairs: Vec<[String; 2]>,
        segments: Vec<SegmentProof>,
    ) -> Self {
        let joints = robot.position_names().to_vec();
        let motion = motion_hash(&joints, &segments);
        let mut certificate = Self {
            format: FORMAT.to_owned(),
            robot: robot.name().to_owned(),
            model,
            world,
            motion,
            joints,
            pairs,
            segments,
            digest: String::new(),
        };
        certificate.digest = certificate.content_hash();
        certificate
    }

    /// Reads a certificate and checks that it is whole.
    pub fn from_json(text: &str) -> Result<Self, CertificateError> {
        let certificate: Self = serde_json::from_str(text)?;
        if certificate.format != FORMAT {
            return Err(CertificateError::Format(certificate.format));
        }
        if certificate.digest != certificate.content_hash() {
            return Err(CertificateError::Digest);
        }
        Ok(certificate)
    }

    /// One line of JSON.
    #[must_use]
    #[allow(clippy::missing_panics_doc)] // it never does
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("numbers and texts have a JSON form")
    }

    /// What [`Self::motion`] has to be.
    #[must_use]
    pub fn motion_hash(&self) -> String {
        motion_hash(&self.joints, &self.segments)
    }

    /// What [`Self::digest`] has to be.
    #[must_use]
    pub fn content_hash(&self) -> String {
        sha256(&Self { digest: String::new(), ..self.clone() })
    }

    /// The motion of one segment.
    pub fn segment(&self, robot: &RobotModel, segment: usize) -> Result<MotionSegment, CertificateError> {
        let text = &self.segments[segment].motion;
        let of_segment = |error| CertificateError::Segment { segment, error };
        let motion = match (&text.from, &text.to, &text.polynomials) {
            (Some(from), Some(to), None) => {
                let ends = [from, to].map(|q| robot.configuration(q));
                let [from, to] =
                    ends.map(|q| q.map_err(|error| CertificateError::Configuration { segment, error }));
                MotionSegment::straight(robot, &from?, &to?)
            }
            (None, None, Some(polynomials)) => {
                MotionSegment::polynomial(robot, polynomials.clone()).map_err(of_segment)?
            }
            _ => return Err(CertificateError::NoMotion(segment)),
        };
        let motion = motion.with_movers(text.obstacles.clone()).map_err(of_segment)?;
        if text.tube.is_empty() {
            return Ok(motion);
        }
        motion.with_tube(robot, text.tube.clone()).map_err(of_segment)
    }
}

fn motion_hash(joints: &[String], segments: &[SegmentProof]) -> String {
    sha256(&(joints, segments.iter().map(|s| &s.motion).collect::<Vec<_>>()))
}

/// Of a thing's JSON; shortest forms of numbers make it the same everywhere.
pub(crate) fn sha256(thing: &impl Serialize) -> String {
    let text = serde_json::to_vec(thing).expect("numbers and texts have a JSON form");
    let mut print = Fingerprint::default();
    print.bytes(&text);
    print.finish()
}
