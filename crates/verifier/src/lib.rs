//! Verifier of certificates. It shares no code with the checker that makes them: this is the smallest code that has to be trusted.
//!
//! A certificate claims that a robot can make a motion without collision ([`Certificate`](clearance_motion::Certificate)). None of its
//! claims is trusted. The kinematics here are uncompiled; there are no bounding volume trees of the engine, no SIMD lanes, and no
//! rounding to f32. An accepted certificate is true if the following code is correct:
//!
//! | file | content |
//! |---|---|
//! | `documents` | it is about this robot, world and motion; every pair is listed |
//! | `joins` | segments follow each other exactly, or the gap between them is free; obstacles start where the world has them |
//! | `expected`, `differences` | it is about the motion that was meant, and what differs if it is not |
//! | `coverage` | for every pair, intervals cover all of every segment |
//! | `course`, `moment` | lines that joints turn about and slide along, and by how much, from the URDF's tree |
//! | `bound` | how much nearer a pair can come within an interval (`docs/derivations/motion-bound.md`) |
//! | `element` | how far a triangle or primitive reaches in a direction, and its corners |
//! | `body`, `apart` | every two elements are proven apart, by boxes or by a direction along which they are |
//! | `interior` | nothing lies inside a closed mesh, if these are solids |
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
