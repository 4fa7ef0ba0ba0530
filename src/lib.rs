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

pub use checker::{CollisionChecker, CollisionReport, Question, Workspace};
pub use clearance_checker as checker;
pub use clearance_files::{input_files, ply_format, readable_text, yaml};
pub use clearance_geometry as geometry;
pub use clearance_geometry::{constants, math, simd};
pub use clearance_monitor as monitor;
pub use clearance_motion as motion;
pub use clearance_proximity as query;
pub use clearance_proximity::{bounding_volume, bvh};
pub use clearance_robot as robot;
#[cfg(feature = "ros")]
pub use clearance_ros as node;
pub use clearance_scene as scene;
pub use clearance_scene::Settings;
pub use clearance_verifier as verifier;
pub use robot::{Configuration, MeshFiles, RobotModel};
pub use scene::World;

/// The examples of the README compile and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The examples of the page about Rust compile and run.
#[cfg(doctest)]
#[doc = include_str!("../docs/plan/rust.md")]
struct RustPage;
