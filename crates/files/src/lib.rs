//! Input files: bounded reading, the only place that opens any, and the syntax of YAML and PLY.

#![warn(missing_docs)]
// minima of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod input_files;
pub mod ply_format;
pub mod readable_text;
pub mod yaml;
