//! Checks certificates, and shares nothing with what makes them: the smallest code that has to be trusted.
//!
//! A certificate claims that a robot can make a motion and hits nothing ([`Certificate`](clearance_motion::Certificate)). Nothing in
//! it is believed. The kinematics here are the plain ones; there is no tree of volumes, no lane, no rounding to f32 of the
//! engine's. What has to be right for an accepted certificate to be true:
//!
//! | file | what |
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
//! What finds the directions (`direction`) need not be right: a bad direction proves nothing, and the certificate is refused.

// minima of floating-point numbers, see `math/extremes.rs` of clearance-geometry
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
