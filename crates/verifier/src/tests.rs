//! Tests of the verifier: true certificates are accepted, false ones rejected, and trusted bounds hold.

mod alterations;
mod motion_bound;
mod prover;
mod rejections;
mod scenes;
mod separation_test;
