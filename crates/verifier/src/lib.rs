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
//! | `documents` | it is about this robot, world and motion; every pair is listed |
//! | `joins` | segments follow each other exactly, or the gap between them is free; obstacles start at their poses in the world |
//! | `expected`, `differences` | it is about the expected motion, or the differences from it |
//! | `coverage` | for every pair, intervals cover all of every segment |
//! | `segment_kinematics`, `interval_midpoint` | axes of revolute and prismatic joints, and their motion, from the URDF's tree |
//! | `bound` | maximum decrease of a pair's distance within an interval (`docs/derivations/motion-bound.md`) |
//! | `element` | extent of a triangle or primitive in a direction, and its corners |
//! | `body`, `apart` | all pairs of elements are proven apart, by boxes or by a separating direction |
//! | `interior` | nothing lies inside a closed mesh, if meshes are solids |
//!
//! The search for directions (`direction`) need not be correct: a wrong direction proves nothing, and the certificate is rejected.

// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod apart;
mod body;
mod bound;
mod coverage;
mod differences;
mod direction;
mod documents;
mod element;
mod expected;
mod interior;
mod interval_midpoint;
mod joins;
mod refusal;
mod segment_kinematics;
mod subjects;
mod verifier;

#[cfg(test)]
mod tests;

pub use differences::Differences;
pub use expected::Expected;
pub use refusal::{Refusal, Verified};
pub use verifier::{Verifier, verify};
