//! # clearance
//!
//! Does this robot hit itself or its surroundings, and how far is it from doing so?
//!
//! ```text
//! once:      URDF text -> robot::RobotModel -> geometry::Shape per link -> query::CollisionBody
//! per tick:  joint state -> Configuration -> LinkPoses -> query -> CollisionReport -> messages
//! ```
//!
//! Read the modules top to bottom; each uses only the ones above it. Two towers stand on `geometry`: the left one
//! (`bounding_volume`, `bvh`, `query`) answers questions about two posed solids and has never heard of a robot; the
//! right one (`robot`, `scene`, `motion`) knows links, joints and obstacles and has never heard of a hierarchy. `checker` is
//! the bridge; `verifier` believes none of it and checks its proofs again; `monitor` decides what a node says; only `node`
//! knows ROS.
//!
//! Units everywhere: metres, radians, seconds.

// minima of floating-point numbers, see `math/extremes.rs`
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod constants;
pub mod input_files;
pub mod math;
pub mod ply_format;
pub mod readable_text;
pub mod simd;
pub mod yaml;

pub mod geometry;

pub mod bounding_volume;
pub mod bvh;
pub mod query;

pub mod robot;
pub mod scene;

pub mod motion;

pub mod checker;

pub mod verifier;

pub mod monitor;

#[cfg(feature = "ros")]
pub mod node;

pub use checker::{CollisionChecker, CollisionReport, Question, Settings, Workspace};
pub use robot::{Configuration, MeshFiles, RobotModel};
pub use scene::World;

#[cfg(test)]
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation)]
mod testing;

/// The examples of the README compile and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
