//! Collision, distance and certified motion checks of URDF robots.
//!
//! ```
//! use std::{path::Path, sync::Arc};
//! use clearance::{CollisionChecker, Question, RobotModel, Settings, World};
//!
//! let (urdf, srdf) = (Path::new("urdf/demo_arm/demo_arm.urdf"), Path::new("urdf/demo_arm/demo_arm.srdf"));
//! let robot = Arc::new(RobotModel::load(urdf, Some(srdf), &[])?);
//! let checker = CollisionChecker::new(Arc::clone(&robot), &World::default(), Settings::default())?;
//! let mut workspace = checker.workspace(); // one per thread
//!
//! let q = robot.configuration_from_names([("joint2", 0.4), ("joint4", -1.8)])?; // rad; other joints at their defaults
//! assert!(checker.is_free(&q, &mut workspace));
//! let report = checker.check(&q, Question::Distance { limit: 0.5 }, &mut workspace);
//! println!("{:?}", report.nearest);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | task | start at |
//! |---|---|
//! | read a robot | [`RobotModel::load`], [`RobotModel::from_text`] |
//! | describe its surroundings | [`World`], [`SceneLoader`] (MoveIt scenes, octrees, point clouds) |
//! | check states | [`CollisionChecker::is_free`], [`CollisionChecker::check`], [`CollisionChecker::check_states`] |
//! | sample and interpolate states | [`RobotModel::sample`], [`RobotModel::interpolate`], [`RobotModel::joint_group`] |
//! | check motions | [`CollisionChecker::check_motion`], [`CollisionChecker::check_trajectory`] |
//! | least distance along a motion | [`CollisionChecker::clearance_along`], [`CollisionChecker::event_distance`] |
//! | check the edges of a planner | [`CollisionChecker::is_motion_free`], [`CollisionChecker::are_motions_free`] |
//! | plan a path of proven motions | [`planner::plan`] |
//! | decide which links can collide | [`collision_matrix::MatrixBuilder`] |
//! | find defects of a robot's geometry | [`lint::lint`] |
//! | cover the links with spheres | [`sphere_cover`], [`covers`] |
//! | keep a proof, and check it again | [`CollisionChecker::certify_motion`], [`Verifier`] |
//! | follow a stream of joint states | [`CollisionChecker::streaming_workspace`], [`monitor`] |
//! | two posed bodies without a robot | [`proximity`] |
//!
//! **Guarantees.** A state or motion is reported free only if this is proven for the exact query. Results do not depend on the number of
//! threads or on the instruction set. A collision is a result, never an `Err`; after validation, queries do not fail or panic.
//!
//! **Units and frames.** Metres, radians and seconds; poses and points are in the frame of the root link unless their documentation names
//! another frame.
//!
//! **Threads.** [`RobotModel`], [`World`] and [`CollisionChecker`] are `Send` and `Sync`. A [`Workspace`] belongs to one thread at a time.
//!
//! **Features.** `cli` builds the program, `ros` the node, `monitor` the module of that name; all are on by default. With
//! `default-features = false` the library has no dependency on DDS, terminal or command line crates.
//!
//! The modules are crates of the workspace, from shapes ([`geometry`]) to the checker ([`checker`]). The most used names are re-exported
//! here. The node (`clearance-ros`) and the readers of bounded input files (`clearance-files`) are not part of this interface.

#![deny(missing_docs)]

// the modules of the command line name this library as any other program does
#[cfg(feature = "cli")]
extern crate self as clearance;

// public for the binary and for the command of the Python package
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;

/// Shapes, triangle meshes, poses and the tolerances of all computations.
#[doc(inline)]
pub use clearance_geometry as geometry;

/// The linear algebra library whose types are in this interface: points (`Point3<f64>`), vectors (`Vector3<f64>`), rotations
/// (`UnitQuaternion<f64>`) and poses (`Isometry3<f64>`), named `Point`, `Vector`, `Rotation` and `Pose` in [`geometry::math`].
#[doc(inline)]
pub use clearance_geometry::nalgebra;

/// Robots: URDF, SRDF and mesh files, configurations and forward kinematics.
#[doc(inline)]
pub use clearance_robot as robot;

/// Surroundings of a robot: obstacles, attached objects, allowed collisions, frames, and the files that describe them.
#[doc(inline)]
pub use clearance_scene as scene;

/// Motion segments, trajectories and certificates.
#[doc(inline)]
pub use clearance_motion as motion;

/// Distance and collision queries between two posed bodies without a robot, and their bounding volume trees.
#[doc(inline)]
pub use clearance_proximity as proximity;

/// Checks of a robot in its world: states, batches, streams and motions.
#[doc(inline)]
pub use clearance_checker as checker;

/// A small motion planner whose edges are proven free.
#[doc(inline)]
pub use clearance_planner as planner;

/// Proven collision matrix: which pairs of links can collide within the joint limits.
#[doc(inline)]
pub use clearance_collision_matrix as collision_matrix;

/// Covers of the links of a robot by spheres, with proven errors.
#[doc(inline)]
pub use clearance_covers as covers;
/// Checks of robot models: mesh defects, and certified distances between collision and visual geometry.
#[doc(inline)]
pub use clearance_lint as lint;

/// Independent verification of certificates.
#[doc(inline)]
pub use clearance_verifier as verifier;

/// Evaluation of a stream of joint states: merged states, staleness, speed scale. The node consists of this and of its I/O.
#[doc(inline)]
#[cfg(feature = "monitor")]
pub use clearance_monitor as monitor;

pub use clearance_checker::{
    CollisionChecker, CollisionReport, Contact, LeastClearance, LookAhead, LookAheadState, MotionClearance,
    MotionClearanceOptions, MotionOptions, MotionOrder, MotionReport, MotionVerdict, NearestMoment,
    PairDistance, Question, SettingsError, TrajectoryReport, UndecidedPair, UndecidedReason, Workspace,
};
pub use clearance_covers::{CoverSize, SearchLimit, sphere_cover};
pub use clearance_geometry::{Primitive, Shape};
pub use clearance_motion::{Certificate, MotionSegment, Trajectory, TrajectoryPoint};
pub use clearance_robot::{
    Configuration, JointGroup, JointId, LinkId, MeshFiles, ModelError, RobotModel, SamplingBox,
};
pub use clearance_scene::{
    AllowedCollisionMatrix, AttachedObject, BodyId, MeshModel, Obstacle, ObstacleId, Scene, SceneLoader,
    Settings, World,
};
pub use clearance_verifier::Verifier;

/// Compiles and runs the examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// Compiles and runs the examples of the page about Rust.
#[cfg(doctest)]
#[doc = include_str!("../docs/plan/rust.md")]
struct RustPage;
