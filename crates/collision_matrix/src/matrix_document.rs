//! Decisions as a JSON document, from which an interrupted search resumes, and as a certificate.

use clearance_motion::Fingerprint;
use clearance_robot::RobotModel;
use clearance_scene::Settings;
use clearance_verifier::{AlwaysProof, MatrixCertificate, NeverProof, matrix_fingerprint};
use serde::{Deserialize, Serialize};

use crate::decision::{DecidedPair, Decision};

/// Decisions about the pairs of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MatrixDocument {
    /// Name and version of the format.
    pub format: String,
    /// Name of the robot.
    pub robot: String,
    /// SHA-256 of the robot's shapes, joints, limits and settings.
    pub model: String,
    /// Names of the positions of states.
    pub joints: Vec<String>,
    /// The pairs, in the order of the links.
    pub pairs: Vec<DecidedPair>,
    /// SHA-256 of all the rest.
    pub digest: String,
}

/// Name and version of the format.
const FORMAT: &str = "clearance collision matrix 2";

/// The field that all versions have.
#[derive(Deserialize)]
struct Head {
    format: String,
}

/// Reason why a document cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DocumentError {
    /// It is no such document.
    #[error("this is no collision matrix: {0}")]
    NoMatrix(String),
    /// Its content does not match its digest.
    #[error("the file was altered: its digest does not match its content; delete it to start again")]
    Altered,
    /// It is about another robot.
    #[error(
        "the file is about another robot, or about other joint limits, shapes or settings; delete it to start again"
    )]
    OtherModel,
}

impl MatrixDocument {
    /// The document of decisions.
    #[must_use]
    pub fn new(robot: &RobotModel, settings: &Settings, pairs: Vec<DecidedPair>) -> Self {
        let mut document = Self {
            format: FORMAT.to_owned(),
            robot: robot.name().to_owned(),
            model: matrix_fingerprint(robot, settings),
            joints: robot.position_names().to_vec(),
            pairs,
            digest: String::new(),
        };
        document.digest = document.computed_digest();
        document
    }

    /// Reads a document about this robot with these settings.
    ///
    /// # Errors
    /// If the text is no such document, was altered, or is about another robot.
    pub fn from_json(text: &str, robot: &RobotModel, settings: &Settings) -> Result<Self, DocumentError> {
        let damaged = |error: serde_json::Error| DocumentError::NoMatrix(error.to_string());
        let Head { format } = serde_json::from_str(text).map_err(damaged)?;
        if format != FORMAT {
            return Err(DocumentError::NoMatrix(format!("its format is '{format}', not '{FORMAT}'")));
        }
        let read: Self = serde_json::from_str(text).map_err(damaged)?;
        if read.digest != read.computed_digest() {
            return Err(DocumentError::Altered);
        }
        if read.model != matrix_fingerprint(robot, settings) {
            return Err(DocumentError::OtherModel);
        }
        Ok(read)
    }

    /// The document as one line of JSON.
    ///
    /// # Panics
    /// Never: all content can be written as JSON.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// The certificate of all pairs that never collide, or always.
    #[must_use]
    pub fn certificate(&self, robot: &RobotModel, settings: &Settings) -> MatrixCertificate {
        let proofs = self.pairs.iter().filter_map(|pair| match &pair.decision {
            Decision::Never { proof, .. } => Some(NeverProof {
                link1: pair.link1.clone(),
                link2: pair.link2.clone(),
                proof: proof.clone(),
            }),
            _ => None,
        });
        let contacts = self.pairs.iter().filter_map(|pair| match &pair.decision {
            Decision::Always { evidence } => Some(AlwaysProof {
                link1: pair.link1.clone(),
                link2: pair.link2.clone(),
                evidence: evidence.as_ref().clone(),
            }),
            _ => None,
        });
        MatrixCertificate::new(robot, settings, proofs.collect(), contacts.collect())
    }

    /// The certificate as one line of JSON.
    #[must_use]
    pub fn certificate_json(&self, robot: &RobotModel, settings: &Settings) -> String {
        // all content can be written as JSON
        serde_json::to_string(&self.certificate(robot, settings)).unwrap_or_default()
    }

    fn computed_digest(&self) -> String {
        let unsigned = Self { digest: String::new(), ..self.clone() };
        let mut print = Fingerprint::default();
        print.text(&unsigned.to_json());
        print.finish()
    }
}
