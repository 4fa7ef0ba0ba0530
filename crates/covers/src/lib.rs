//! Covers of the links of a robot.

#![deny(missing_docs)]
// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
#![allow(missing_docs, dead_code)]

pub mod ball;
pub mod containment;
mod cover_search;
mod distance_grid;
pub mod excess;
pub mod link_solid;
pub mod measure;
mod offset_balls;
mod options;
pub mod outer_cover;
mod primitive_mesh;
mod refinement;
mod samples;
mod triangle_tree;

pub use options::{CoverError, CoverSize};
