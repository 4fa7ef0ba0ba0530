//! Tests of the library from outside, one binary with a module for each subject.

mod bodies;
mod cases;
mod hostile;
mod random;
mod robots;
mod support;
mod tally;
mod triangles;
mod truth;
