//! Motions of robots and obstacles, and certificates that a motion is free.
//!
//! | concept | type |
//! |---|---|
//! | one smooth segment, t from 0 to 1 | [`MotionSegment`] |
//! | a rigid moving obstacle | [`MovingObstacle`] |
//! | the same over time, with constant velocity or through poses | [`ObstacleTrajectory`] |
//! | speed and acceleration limits of obstacles whose path is not known | [`ObstacleLimits`] |
//! | consecutive segments with times | [`Trajectory`] |
//! | direction of rotation of a continuous joint | [`ContinuousDirection`] |
//! | deviation of a line or an arc of a link from its samples | [`sample_deviation`] |
//! | a proof that a motion is free, as a document | [`Certificate`] |

#![deny(missing_docs)]
// minimum and maximum of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod certificate;
mod certificate_parts;
mod continuous_direction;
mod continuous_turns;
mod fingerprint;
mod model_fingerprint;
mod moving_obstacle;
mod obstacle_motions;
mod obstacle_trajectory;
mod obstacle_uncertainty;
mod part_hashes;
mod sample_deviation;
mod segment;
mod segment_error;
mod segment_join;
mod trajectory;
mod trajectory_document;
mod trajectory_start;
mod trajectory_text_error;
mod trajectory_yaml;

pub use certificate::shown;
pub use certificate::{Certificate, CertificateError, Proof, SegmentProof};
pub use certificate_parts::{BodyPart, CertificateParts, JointPart};
pub use continuous_direction::{ContinuousDirection, HeldTurn, shortest_turns};
pub use continuous_turns::ContinuousTurn;
pub use fingerprint::Fingerprint;
pub use model_fingerprint::{model_fingerprint, world_fingerprint};
pub use moving_obstacle::MovingObstacle;
pub use obstacle_motions::{ObstacleMotions, ObstacleTextError};
pub use obstacle_trajectory::{ObstacleTrajectory, PosesError};
pub use obstacle_uncertainty::{
    LimitError, ObstacleLimits, ObstacleUncertainty, SpeedLimit, UncertaintyText,
};
pub use part_hashes::{certificate_parts, mesh_model_name};
pub use sample_deviation::sample_deviation;
pub use segment::floating;
pub use segment::{MotionSegment, SegmentText};
pub use segment_error::SegmentError;
pub use segment_join::{Join, JoinError, join};
pub use trajectory::{Trajectory, TrajectoryError, TrajectoryPoint};
pub use trajectory_start::{START_TOLERANCE, StartMismatch};
pub use trajectory_text_error::TrajectoryTextError;
