//! Evaluates the robot's state without I/O, clocks or ROS: the inputs are messages and times, the outputs are
//! evaluations.
//!
//! Rules in the order of their evaluation; the first one that applies decides:
//!
//! | condition | status | code |
//! |---|---|---|
//! | the process uses more memory than allowed, and ends | UNKNOWN | `memory` |
//! | checking is switched off | UNKNOWN | `disabled` |
//! | no usable robot model | UNKNOWN | `no_model` |
//! | another robot was described, and its model is being built | UNKNOWN | `model_swap` |
//! | no link of the robot has collision geometry | UNKNOWN | `no_geometry` |
//! | no joint state was received | UNKNOWN | `no_joint_state` |
//! | the clock was set back by more than `stale_after`; no joint state since | UNKNOWN | `clock_jump` |
//! | simulated time is in use, and none was received | UNKNOWN | `no_clock` |
//! | the last joint state of some joint, or its stamp, is older than `stale_after` | UNKNOWN | `stale` |
//! | the stamp is more than `stale_after` in the future | UNKNOWN | `future_stamp` |
//! | the stamp is older than the last evaluated one of the same stream | UNKNOWN | `out_of_order` |
//! | an invalid joint state: counts differ, a joint twice, a position out of range | UNKNOWN | `malformed` |
//! | a position of the robot is NaN or infinite | UNKNOWN | `non_finite` |
//! | `tf` has no current pose of a joint whose positions come from `tf` | UNKNOWN | `no_transform` |
//! | a joint was never named | UNKNOWN | `partial` |
//! | two publishers report different positions of a joint at about the same time | UNKNOWN | `contradiction` |
//! | a mimic joint disagrees with its leader, unless that is only a warning | UNKNOWN | `contradiction` |
//! | the last message of a sensor shows nothing of the environment | UNKNOWN | `blind_cloud` |
//! | an announced object is missing, because it was rejected | UNKNOWN | `rejected_obstacle` |
//! | messages about the world were lost | UNKNOWN | `lost_messages` |
//! | messages about the world are not in use 0.1 s after their reception | UNKNOWN | `world_update` |
//! | data of a sensor, a required scene or the pose of the root in `tf` is missing or stale | UNKNOWN | `stale_world` |
//! | some pair touches | COLLIDING | |
//! | some pair is proven to have touched since the previous state | COLLIDING | `passed_through` |
//! | `check_deadline` passed before every pair was decided | UNKNOWN | `deadline` |
//! | every pair is proven free of contact | FREE | |
//!
//! Joint states of several publishers are merged. For each joint, the last message with its name counts, with its own
//! age. A joint state with names and without positions is skipped, with a warning. Mimic joints need not be reported.
//! For those that are, the last message with the name counts, too. Unknown joints, joints outside their limits and
//! stamps of zero do not prevent an evaluation; they are warnings. Each evaluation also contains the allowed share of
//! the robot's speed: 0 unless the status is FREE. With a look-ahead horizon it also contains the time until which
//! nothing can touch; if that cannot be computed, there is a warning. Silence never means safe: a heartbeat publishes
//! the last evaluation again, with its growing age, until it is stale.

// minima of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
#![deny(missing_docs)]

mod approach_rate;
mod between_states;
mod check_budget;
pub mod cloud;
mod contact_counter;
mod contact_watch;
mod contribution;
mod distance_bounds;
mod evaluation;
mod input;
mod joint_state_history;
mod joint_state_merger;
mod look_ahead;
mod mimic_reports;
mod monitor;
mod motion_since_previous;
mod named_pair;
mod now;
mod obstacle_motion;
mod obstacle_pose_histories;
mod obstacle_shift;
mod past_states;
mod pose_history;
mod predicted_distances;
mod received_states;
mod root_location;
mod root_speed;
mod separation;
mod separation_rules;
mod separation_settings;
mod settings;
mod slowdown_range;
mod speed;
mod speed_settings;
mod state_contacts;
mod state_evaluator;
mod status;
mod tracked_obstacle;
mod transform_ages;
mod transform_joints;
mod transform_stamps;
mod unevaluated_states;
mod world_source;
mod world_updates;

#[cfg(test)]
mod tests;

pub use clearance_scene::Time;
pub use contact_counter::{ContactHistory, LeastKnown, SinceHeartbeat};
pub use evaluation::{CheckedState, Evaluation, Expiry, LeftOut, Revision};
pub use input::{JointStateInput, SourceId};
pub use joint_state_history::{Coverage, JointStateHistory};
pub use monitor::Monitor;
pub use motion_since_previous::{
    GAP_NOT_PROVEN, GapReason, MotionSincePrevious, NoMotion, PASSED_THROUGH, Passage,
};
pub use named_pair::{BodyKind, NamedBody, NamedPair};
pub use now::Now;
pub use obstacle_motion::ObstacleMotion;
pub use separation::Separation;
pub use separation_rules::SeparationRules;
pub use separation_settings::SeparationSettings;
pub use settings::MonitorSettings;
pub use speed_settings::{SpeedDistances, SpeedSettings};
pub use state_contacts::ContactsOfPair;
pub use state_evaluator::Stopwatch;
pub use status::{Reason, Status};
pub use tracked_obstacle::TrackedObstacles;
pub use transform_joints::PlacedAt;
pub use world_source::{Observation, WorldSource};
