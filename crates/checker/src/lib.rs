//! Collision checker: evaluates states and motions of a robot in a world, and returns collision reports.
//!
//! | question | function |
//! |---|---|
//! | is this state free? (first hit) | [`CollisionChecker::is_free`] |
//! | which pairs collide, how far apart are the others? | [`CollisionChecker::check`] |
//! | the same for many states | [`CollisionChecker::are_free`], [`CollisionChecker::check_states`] |
//! | how do signed distances change with the joints? | [`CollisionChecker::clearance`] |
//! | the same for many states | [`CollisionChecker::clearances`] |
//! | how deep do two bodies overlap? | [`CollisionChecker::contact`] |
//! | where do two bodies touch? | [`CollisionChecker::contacts`] |
//! | where is the nearest free state? | [`CollisionChecker::find_free_state`] |
//! | which way leads out of a collision? | [`CollisionChecker::retreat_direction`] |
//! | is a motion free? | [`CollisionChecker::is_motion_free`] |
//! | the same for many motions | [`CollisionChecker::are_motions_free`] |
//! | where does it collide? | [`CollisionChecker::check_motion`], [`CollisionChecker::check_trajectory`] |
//! | how near do bodies come along a motion? | [`CollisionChecker::clearance_along`] |
//! | when does a distance first fall below a value? | [`CollisionChecker::event_distance`] |
//! | the same, with a certificate | [`CollisionChecker::certify_motion`], [`CollisionChecker::certify_trajectory`] |
//! | for how long can nothing touch? | [`CollisionChecker::look_ahead`] |

// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
#![deny(missing_docs)]

mod capsules;
mod clearance;
mod clearance_along;
mod collision_checker;
mod collision_report;
mod is_motion_free;
mod motion;
mod pair_kind;
mod pairs;
mod question;
#[cfg(test)]
mod random_scenes;
mod recovery;
mod remarks;
mod revision;
mod robot;
mod settings_error;
mod state;
mod workspace;
mod world;

pub use clearance::{Clearance, ClearanceCandidate, ClearanceOptions, PairClearance, WitnessCount};
pub use collision_checker::CollisionChecker;
pub use collision_report::{CollisionReport, PairDistance, UndecidedPair};
pub use motion::{
    LeastClearance, LookAhead, LookAheadState, MotionClearance, MotionClearanceOptions, MotionOptions,
    MotionOrder, MotionReport, MotionVerdict, NearestMoment, SweptVolume, TrajectoryReport, UndecidedReason,
    Watch,
};
pub use pair_kind::PairKind;
pub use question::Question;
pub use recovery::{
    FreeState, NoFreeState, Recovery, RecoveryError, RecoveryOptions, Retreat, RetreatDirection,
};
pub use remarks::{ConstantContacts, SolidMeshRemark, solid_mesh_remarks};
pub use robot::LinkVolume;
pub use settings_error::SettingsError;
pub use state::{Contact, LocalContact, PairContacts};
pub use workspace::Workspace;
