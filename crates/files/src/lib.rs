//! Input files: bounded reading, the only place that opens any, and the syntax of YAML and PLY.
//!
//! | content | file |
//! |---|---|
//! | opening and bounded reading of files | `input_files` |
//! | YAML documents, and error messages about them | `yaml` |
//! | header and numbers of PLY | `ply_format` |
//! | text that is safe for terminals and logs | `readable_text` |

#![warn(missing_docs)]
// minima of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod input_files;
pub mod ply_format;
pub mod readable_text;
pub mod yaml;
