//! Collision checker: evaluates states and motions of a robot in a world, and returns collision reports.
//!
//! | question | function |
//! |---|---|
//! | is this state free? (first hit) | [`CollisionChecker::is_free`] |
//! | what hits, how far is the rest? | [`CollisionChecker::check`] |
//! | the same of many states | [`CollisionChecker::are_free`], [`CollisionChecker::check_states`] |
//! | how deep are two bodies in each other? | [`CollisionChecker::contact`] |
//! | is the way from here to there free? | [`CollisionChecker::check_motion`], [`CollisionChecker::check_trajectory`] |
//! | the same with a proof to show | [`CollisionChecker::certify_motion`], [`CollisionChecker::certify_trajectory`] |
//! | until when can nothing touch? | [`CollisionChecker::look_ahead`] |

// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod batch;
mod bodies;
mod capsule_fit;
mod capsule_lanes;
mod capsules;
mod collision_checker;
mod constant_contacts;
mod contact;
mod fixed_nearest;
mod least_distance;
mod memory;
mod mesh_lint;
mod motion;
mod nearby;
mod nearest_first;
mod numbers;
mod obstacles;
mod pair;
mod pair_priority;
mod pieces;
mod questions;
mod reachable;
mod report;
mod root_volume;
mod state_query;
mod stream;
mod volumes;
mod within_reach;
mod workspace;
mod world_hits;

pub use collision_checker::{CollisionChecker, SettingsError};
pub use constant_contacts::ConstantContacts;
pub use contact::Contact;
pub use mesh_lint::{SolidMeshRemark, solid_mesh_remarks};
pub use motion::{
    LookAhead, MotionOptions, MotionOrder, MotionReport, MotionVerdict, SweptVolume, TrajectoryReport,
    UndecidedReason, Watch,
};
pub use report::{CollisionReport, PairDistance, Question, UndecidedPair};
pub use volumes::LinkVolume;
pub use workspace::Workspace;
