//! Data types of the proof that two links collide in every state: balls inside their solids and points in contact.

use serde::{Deserialize, Serialize};

/// Proof that two links always collide.
///
/// The box of joint positions is halved as in [`NeverProof`](super::NeverProof). `proof` has two kinds of leaves:
///
/// - `*`, a ball of the first link and one of the second, as three digits each: the balls overlap in the whole box. A digit follows, which
///   is the sum of 1 if the first solid sticks out of the second and 2 if the second sticks out of the first. Three digits follow for each:
///   the direction (frame of the first link) along which the solid sticks out.
/// - `=`: the points of `contact` touch. Only links without a joint between them have this leaf.
///
/// Digits are base 64: `0`–`9`, `A`–`Z`, `a`–`z`, `-`, `_`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlwaysProof {
    /// Name of the first link in the URDF.
    pub link1: String,
    /// Name of the second link in the URDF.
    pub link2: String,
    /// The evidence.
    pub evidence: ContactEvidence,
}

/// Balls inside solids of two links, and the boxes of joint positions in which they overlap.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactEvidence {
    /// Balls in solids of the first link.
    pub balls1: Vec<InnerBall>,
    /// Balls in solids of the second link.
    pub balls2: Vec<InnerBall>,
    /// One point of each link: they touch.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub contact: Option<[ElementPoint; 2]>,
    /// The boxes.
    pub proof: String,
}

/// A ball inside a solid: a primitive, or a connected closed part of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InnerBall {
    /// Number of the shape among the collision shapes of the link, from 0.
    pub shape: usize,
    /// Number of the first face of the connected part, from 0; 0 for a primitive.
    pub face: usize,
    /// Centre (m) in the frame of the link.
    pub centre: [f64; 3],
    /// Radius (m).
    pub radius: f64,
}

/// A point of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElementPoint {
    /// Number of the shape among the collision shapes of the link, from 0.
    pub shape: usize,
    /// Number of the face, from 0; 0 for a primitive.
    pub face: usize,
    /// Weights of the corners of the face; the position (m) in the frame of a primitive.
    pub at: [f64; 3],
}
