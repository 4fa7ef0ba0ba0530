//! Certificate: a proof that a motion is free, as a document that an independent program can verify.
//!
//! For every pair of bodies that has to be checked it lists intervals that cover [0, 1]. For each interval it claims that the pair's
//! distance in the middle is at least `lower`, and decreases by at most `bound` towards either end: the pair is free of contact in the
//! interval if `lower > bound + padding`. The bound is derived in `docs/derivations/motion-bound.md`. Hashes identify the model, world
//! and motion. A digest detects accidental changes. The claims must be verified, not trusted.

use std::io::{BufWriter, Write};

use clearance_files::readable_text::on_one_line;
use clearance_robot::{ConfigurationError, RobotModel};
use serde::{Deserialize, Serialize};

use super::segment::SegmentText;
use super::{CertificateParts, Fingerprint, MotionSegment, ObstacleUncertainty, SegmentError};

/// [`Certificate::format`] of a certificate with parts and tolerance.
pub const FORMAT: &str = "clearance certificate 2";

/// [`Certificate::format`] of one without; still read.
pub const FORMAT_1: &str = "clearance certificate 1";

/// A proof that a robot can make a motion without collision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Name and version of the format.
    pub format: String,
    /// The robot's name.
    pub robot: String,
    /// SHA-256 of the model: links, joints, shapes, paddings.
    pub model: String,
    /// SHA-256 of the obstacles.
    pub world: String,
    /// SHA-256 of joints and segments' motions.
    pub motion: String,
    /// Tolerance (m) of the check: pairs farther apart than this had to be decided. Proofs do not depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Distance (m) that every pair is proven to keep, besides its padding; without it 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
    /// Hashes of the parts of robot and world. They name the differences if `model` or `world` does not match.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parts: Option<CertificateParts>,
    /// Names of the positions.
    pub joints: Vec<String>,
    /// Names of the bodies of the pairs that have to be checked.
    pub pairs: Vec<[String; 2]>,
    /// The segments with their proofs, in order.
    pub segments: Vec<SegmentProof>,
    /// SHA-256 of all the rest.
    pub digest: String,
}

/// A certificate with an empty digest, without a copy of what may be large: the same fields in the same order.
#[derive(Serialize)]
struct Unsigned<'c> {
    format: &'c str,
    robot: &'c str,
    model: &'c str,
    world: &'c str,
    motion: &'c str,
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    margin: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    parts: Option<&'c CertificateParts>,
    joints: &'c [String],
    pairs: &'c [[String; 2]],
    segments: &'c [SegmentProof],
    digest: &'static str,
}

/// A segment of the motion, and the proof that it is free.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentProof {
    /// The segment of the motion.
    pub motion: SegmentText,
    /// Ordered by pair, then by time: `[pair, from, to, lower, bound]`.
    pub proofs: Vec<Proof>,
}

/// Proof that one pair is free of contact between `from` and `to`: `(pair, from, to, lower, bound)` with the pair's index, two fractions
/// of the segment, and two lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Proof(pub usize, pub f64, pub f64, pub f64, pub f64);

/// Reason why a text is not a valid certificate.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message of each variant describes it and its fields")]
pub enum CertificateError {
    #[error("this is no certificate: {0}")]
    Text(#[from] serde_json::Error),
    #[error("the format is '{0}', but only '{FORMAT}' and '{FORMAT_1}' are known")]
    Format(String),
    #[error("the format is '{0}', but fields of this format are missing, or there are fields of another one")]
    Fields(String),
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
    /// A certificate of format 1, with its digest.
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
            format: FORMAT_1.to_owned(),
            robot: robot.name().to_owned(),
            model,
            world,
            motion,
            tolerance: None,
            margin: None,
            parts: None,
            joints,
            pairs,
            segments,
            digest: String::new(),
        };
        certificate.digest = certificate.content_hash();
        certificate
    }

    /// The same certificate in format 2: with the parts behind its hashes, and the tolerance (m) it was made with.
    #[must_use]
    pub fn with_parts(mut self, parts: CertificateParts, tolerance: f64) -> Self {
        FORMAT.clone_into(&mut self.format);
        (self.parts, self.tolerance) = (Some(parts), Some(tolerance));
        self.digest = self.content_hash();
        self
    }

    /// The same certificate about a check with this margin (m), at least 0.
    #[must_use]
    pub fn with_margin(mut self, margin: f64) -> Self {
        self.margin = (margin > 0.0).then_some(margin);
        self.digest = self.content_hash();
        self
    }

    /// Distance (m) that every pair is claimed to keep, besides its padding.
    #[must_use]
    pub fn kept_margin(&self) -> f64 {
        self.margin.unwrap_or(0.0)
    }

    /// True if it has exactly the fields of its format.
    #[must_use]
    pub fn has_known_format(&self) -> bool {
        match self.format.as_str() {
            FORMAT => self.parts.is_some() && self.tolerance.is_some(),
            FORMAT_1 => self.parts.is_none() && self.tolerance.is_none() && self.margin.is_none(),
            _ => false,
        }
    }

    /// Reads a certificate and checks its format and digest.
    pub fn from_json(text: &str) -> Result<Self, CertificateError> {
        let certificate: Self = serde_json::from_str(text)?;
        if ![FORMAT, FORMAT_1].contains(&certificate.format.as_str()) {
            return Err(CertificateError::Format(shown(&certificate.format)));
        }
        if !certificate.has_known_format() {
            return Err(CertificateError::Fields(certificate.format));
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

    /// Expected value of [`Self::motion`].
    #[must_use]
    pub fn motion_hash(&self) -> String {
        motion_hash(&self.joints, &self.segments)
    }

    /// Expected value of [`Self::digest`].
    #[must_use]
    pub fn content_hash(&self) -> String {
        let Self {
            format,
            robot,
            model,
            world,
            motion,
            tolerance,
            margin,
            parts,
            joints,
            pairs,
            segments,
            digest: _,
        } = self;
        let (tolerance, margin, parts) = (*tolerance, *margin, parts.as_ref());
        sha256(&Unsigned {
            format,
            robot,
            model,
            world,
            motion,
            tolerance,
            margin,
            parts,
            joints,
            pairs,
            segments,
            digest: "",
        })
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
        let mut motion = motion.with_movers(text.obstacles.clone()).map_err(of_segment)?;
        if let Some(text) = &text.obstacle_uncertainty {
            let uncertainty = ObstacleUncertainty::try_from(text.clone());
            motion = motion.with_uncertainty(uncertainty.map_err(|error| of_segment(error.into()))?);
        }
        if text.tube.is_empty() {
            return Ok(motion);
        }
        motion.with_tube(robot, text.tube.clone()).map_err(of_segment)
    }
}

/// Maximum length (characters) of a document's text quoted in a message.
const LONGEST_SHOWN: usize = 100;

/// A text from a document, for messages: shortened, and without control characters for terminals.
#[must_use]
pub fn shown(text: &str) -> String {
    let mut short: String = text.chars().take(LONGEST_SHOWN).collect();
    short = on_one_line(&short).into_owned();
    if text.chars().nth(LONGEST_SHOWN).is_some() {
        short.push('…');
    }
    short
}

fn motion_hash(joints: &[String], segments: &[SegmentProof]) -> String {
    sha256(&(joints, segments.iter().map(|s| &s.motion).collect::<Vec<_>>()))
}

/// Hash of a value's JSON; shortest forms of numbers make it the same on every machine.
pub fn sha256(thing: &impl Serialize) -> String {
    let mut print = Fingerprint::default();
    let mut buffer = BufWriter::new(&mut print);
    let written = serde_json::to_writer(&mut buffer, thing).is_ok() && buffer.flush().is_ok();
    assert!(written, "numbers and texts have a JSON form");
    drop(buffer);
    print.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BodyPart;
    use clearance_robot::MeshFiles;

    /// The digest can be computed by anyone: SHA-256 of the compact JSON with an empty digest.
    #[test]
    fn digests_are_those_of_the_text() {
        let urdf = include_str!("../../../urdf/two_link/two_link.urdf");
        let robot = RobotModel::from_urdf(urdf, &MeshFiles::default()).unwrap();
        let q = robot.default_configuration();
        let motion = MotionSegment::straight(&robot, &q, &q).text();
        let segments = vec![SegmentProof { motion, proofs: vec![Proof(0, 0.0, 1.0, 0.7, 1e-9)] }];
        let old =
            Certificate::new(&robot, ["m".into(), "w".into()], vec![["a".into(), "b".into()]], segments);
        let part = BodyPart("a".into(), "0".into(), 0.0, 1.0);
        let parts = CertificateParts {
            links: vec![part.clone()],
            joints: vec![],
            obstacles: vec![],
            attached_objects: vec![part],
            meshes: "surface".into(),
            pad_self: false,
            check_self: true,
            check_world: true,
        };
        let new = old.clone().with_parts(parts, 5e-4);
        for certificate in [old, new.clone(), new.with_margin(0.02)] {
            let text = certificate.to_json().replace(&certificate.digest, "");
            let mut print = Fingerprint::default();
            print.bytes(text.as_bytes());
            assert_eq!(certificate.digest, print.finish());
            assert_eq!(Certificate::from_json(&certificate.to_json()).unwrap(), certificate);
        }
    }
}
