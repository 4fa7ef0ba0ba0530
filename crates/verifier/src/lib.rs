//! Verifier of certificates. It shares no kinematics, bounds or queries with the checker that makes them: this is
//! the smallest code that has to be trusted.
//!
//! A certificate claims that a robot can make a motion without collision ([`Certificate`](clearance_motion::Certificate)). None of its
//! claims is trusted. The kinematics here are the plain ones; there are no bounding volume trees of the engine, no SIMD lanes, and no
//! rounding to f32. An accepted certificate is true if the following code is correct:
//!
//! | file | content |
//! |---|---|
//! | `PairList` and `Settings` of clearance-scene | pairs that have to be apart, paddings and scales, as the checker uses them |
//! | `certificate_content`, `required_pairs` | the certificate is about this robot and world; every pair is listed |
//! | `segment_continuity` | segments follow each other exactly, or the gap between them is free; obstacles start at their poses in the world |
//! | `expected_motion`, `certificate_differences` | it is about the expected motion, or the differences from it |
//! | `interval_coverage` | for every pair, intervals cover all of every segment |
//! | `segment_kinematics`, `interval_midpoint` | axes of revolute and prismatic joints, and their motion, from the URDF's tree |
//! | `motion_bound` | maximum decrease of a pair's distance within an interval (`docs/derivations/motion-bound.md`) |
//! | `element` | extent of a triangle or primitive in a direction, and its corners |
//! | `body_geometry`, `body` | shapes of links, attached objects and obstacles as trees of boxes |
//! | `separation_test` | all pairs of elements are proven apart, by boxes or by a separating direction |
//! | `interior`, `ray_crossings` | nothing lies inside a closed mesh, if meshes are solids |
//! | `matrix_certificate`, `always_certificate` | proofs that pairs of links never collide, or always, as a document |
//! | `matrix_path`, `matrix_motion` | joints between two links and their ranges; motion of one relative to the other in a box |
//! | `matrix_proof_text`, `matrix_separation` | the boxes are all of the range; two bodies are apart in a box |
//! | `closed_part`, `inner_solid` | connected closed parts of meshes, and balls inside them |
//! | `contact_verifier` | in every box, balls of two links overlap, and neither solid lies inside the other |
//! | `matrix_verifier` | every box of such a proof is proven by the above |
//! | `segment_verifier`, `verifier` | every proof of every segment is checked by the above |
//! | `rejection`, `matrix_rejection` | reasons why a certificate of a motion, or of a collision matrix, is rejected |
//!
//! The search for directions (`separating_direction`) need not be correct: a wrong direction proves nothing, and the certificate is rejected.

#![deny(missing_docs)]
// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod always_certificate;
mod body;
mod body_geometry;
mod body_pair;
mod certificate_content;
mod certificate_differences;
mod closed_part;
mod contact_verifier;
mod element;
mod expected_motion;
mod inner_solid;
mod interior;
mod interval_coverage;
mod interval_midpoint;
mod matrix_certificate;
mod matrix_motion;
mod matrix_path;
mod matrix_proof_text;
mod matrix_rejection;
mod matrix_separation;
mod matrix_verifier;
mod motion_bound;
mod proof_interval;
mod ray_crossings;
mod rejection;
mod required_pairs;
mod segment_continuity;
mod segment_kinematics;
mod segment_verifier;
mod separating_direction;
mod separation_test;
mod verification_statistics;
mod verifier;
mod verifier_model;

#[cfg(test)]
mod tests;

pub use always_certificate::{AlwaysProof, ContactEvidence, ElementPoint, InnerBall};
pub use certificate_differences::CertificateDifferences;
pub use expected_motion::ExpectedMotion;
pub use matrix_certificate::{MatrixCertificate, NeverProof, matrix_fingerprint};
pub use matrix_rejection::MatrixRejection;
pub use matrix_verifier::{MatrixSettingsError, MatrixVerifier};
pub use rejection::Rejection;
pub use verification_statistics::VerificationStatistics;
pub use verifier::{Verifier, verify};
