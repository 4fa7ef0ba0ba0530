//! Data type of a certificate's parts: the hash of each link, joint and obstacle, to show which of them differs.

use serde::{Deserialize, Serialize};

/// Parts of the model hash and the world hash. A verifier computes its own and compares; it trusts nothing in here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertificateParts {
    /// Links, in the order of the URDF.
    pub links: Vec<BodyPart>,
    /// Joints, in the order of the URDF.
    pub joints: Vec<JointPart>,
    /// Obstacles of the world.
    pub obstacles: Vec<BodyPart>,
    /// Attached objects, in the order of attaching.
    pub attached_objects: Vec<BodyPart>,
    /// Mesh treatment: `surface` or `solid`.
    pub meshes: String,
    /// True if padding also applies between links.
    pub pad_self: bool,
    /// Whether pairs of links, and pairs with obstacles, are checked.
    pub check_self: bool,
    /// True if pairs with obstacles are checked.
    pub check_world: bool,
}

/// A link, an obstacle or an attached object: name, hash of its shapes and its carrying link, safety distance (m), scale factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyPart(pub String, pub String, pub f64, pub f64);

/// A joint: name, and hash of its frame, axis, kind, links and mimic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointPart(pub String, pub String);
