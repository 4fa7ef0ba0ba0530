//! Decision about one pair of links.

use clearance_verifier::ContactEvidence;
use serde::{Deserialize, Serialize};

/// Decision about a pair of links, over all states within the joint limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "decision")]
pub enum Decision {
    /// The links never collide: proven.
    Never {
        /// Boxes of joint positions of the proof (`split_tree`).
        proof: String,
        /// Smallest distance (m, paddings subtracted) found, where one was measured.
        least_distance: Option<f64>,
    },
    /// The links collide in every state: proven.
    Always {
        /// Balls inside both links, and boxes of joint positions in which they overlap.
        evidence: Box<ContactEvidence>,
    },
    /// The links collide in some states only. Both states are confirmed by the checker.
    Sometimes {
        /// A state in which the links collide.
        colliding: Vec<f64>,
        /// A state in which they are apart.
        free: Vec<f64>,
    },
    /// The budget or the time was used up.
    Undecided {
        /// Smallest distance (m, paddings subtracted) found, where one was measured; zero if the links collided in every state.
        least_distance: Option<f64>,
        /// Its state; empty if no state was checked.
        state: Vec<f64>,
    },
}

impl Decision {
    /// Name in tables and documents.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Never { .. } => "never",
            Self::Always { .. } => "always",
            Self::Sometimes { .. } => "sometimes",
            Self::Undecided { .. } => "undecided",
        }
    }

    /// True unless the pair is undecided.
    #[must_use]
    pub fn is_final(&self) -> bool {
        !matches!(self, Self::Undecided { .. })
    }
}

/// A pair of links with its decision. States are positions of the whole robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DecidedPair {
    /// Name of the first link in the URDF.
    pub link1: String,
    /// Name of the second link in the URDF.
    pub link2: String,
    /// Number of joint positions that move the links relative to each other.
    pub variables: usize,
    /// True if the links' rigid bodies are the same or joined by one joint.
    pub is_adjacent: bool,
    /// Part of the random states that collide.
    pub contact_share: f64,
    /// Depth (m) of the contact in one colliding state, where it was computed.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub depth: Option<f64>,
    /// The decision.
    #[serde(flatten)]
    pub decision: Decision,
}

/// Part of the random states from which links count as in contact over most of their range.
const MOSTLY: f64 = 0.5;

impl DecidedPair {
    /// True if the links are in contact in most states: usually parts that touch by design, or shapes that are too large.
    #[must_use]
    pub fn touches_mostly(&self) -> bool {
        matches!(self.decision, Decision::Always { .. }) || self.contact_share > MOSTLY
    }

    /// True if the pair is of these links, in any order.
    #[must_use]
    pub fn is_of(&self, link1: &str, link2: &str) -> bool {
        (self.link1 == link1 && self.link2 == link2) || (self.link1 == link2 && self.link2 == link1)
    }
}
