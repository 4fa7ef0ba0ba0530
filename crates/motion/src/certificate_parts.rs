//! Hashes of the single parts of a robot and a world: they name what differs when the hash of the whole does.

use serde::{Deserialize, Serialize};

/// Parts of the model hash and the world hash. A verifier computes its own and compares:
/// nothing here is believed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertificateParts {
    pub links: Vec<BodyPart>,
    pub joints: Vec<JointPart>,
    pub obstacles: Vec<BodyPart>,
    pub attached_objects: Vec<BodyPart>,
    /// Mesh treatment: `surface` or `solid`.
    pub meshes: String,
    /// Whether padding counts between links, too.
    pub pad_self: bool,
    /// Whether pairs of links, and pairs with obstacles, are checked.
    pub check_self: bool,
    pub check_world: bool,
}

/// A link, an obstacle or an attached object: name, hash of its shapes and of what carries it, safety distance (m), factor of size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyPart(pub String, pub String, pub f64, pub f64);

/// A joint: name, and hash of its frame, axis, kind, links and mimicry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointPart(pub String, pub String);
