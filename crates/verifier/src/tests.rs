//! Tests that true certificates are accepted, false ones are rejected, and the trusted bounds hold for sampled points.

mod apart;
mod bound;
mod prover;
mod refusals;
mod scenes;
