//! Tests that true certificates are accepted, false ones are rejected, and the trusted bounds hold for sampled points.

mod alterations;
mod motion_bound;
mod prover;
mod rejections;
mod scenes;
mod separation_test;
