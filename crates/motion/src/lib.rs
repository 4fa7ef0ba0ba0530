//! Motions of robots and obstacles, and certificates that a motion is free.
//!
//! | concept | type |
//! |---|---|
//! | one smooth segment, t from 0 to 1 | [`MotionSegment`] |
//! | a rigid moving obstacle | [`MovingObstacle`] |
//! | the same over time, with constant velocity or through poses | [`ObstacleTrajectory`] |
//! | consecutive segments with times | [`Trajectory`] |
//! | direction of rotation of a continuous joint | [`ContinuousDirection`] |
//! | a proof that a motion is free, as a document | [`Certificate`] |

#![warn(missing_docs)]
// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod certificate;
mod certificate_parts;
mod continuous_joints;
mod fingerprint;
mod join;
mod model_fingerprint;
mod moving_obstacle;
mod obstacle_trajectory;
mod obstacle_trajectory_text;
mod parts_of_model;
mod segment;
mod trajectory;
mod trajectory_document;
mod trajectory_start;
mod trajectory_text;

pub use certificate::shown;
pub use certificate::{Certificate, CertificateError, Proof, SegmentProof};
pub use certificate_parts::{BodyPart, CertificateParts, JointPart};
pub use continuous_joints::{ContinuousDirection, ContinuousTurn, HeldTurn, shortest_way};
pub use fingerprint::Fingerprint;
pub use join::{Join, JoinError, join};
pub use model_fingerprint::{model_fingerprint, world_fingerprint};
pub use moving_obstacle::MovingObstacle;
pub use obstacle_trajectory::{ObstacleTrajectory, PosesError};
pub use obstacle_trajectory_text::ObstacleTextError;
pub use parts_of_model::{certificate_parts, mesh_model_name};
pub use segment::floating;
pub use segment::{MotionSegment, SegmentError, SegmentText};
pub use trajectory::{Trajectory, TrajectoryError, TrajectoryPoint};
pub use trajectory_start::{START_TOLERANCE, StartMismatch};
pub use trajectory_text::TrajectoryTextError;
