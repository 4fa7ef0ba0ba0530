//! Evaluates the robot's state without I/O, clocks or ROS: the inputs are messages and times, the outputs are evaluations.
//!
//! Rules in the order of their evaluation; the first one that applies decides:
//!
//! | what is the matter | status | code |
//! |---|---|---|
//! | the process takes more memory than it may, and ends | UNKNOWN | `memory` |
//! | checking was turned off | UNKNOWN | `disabled` |
//! | no usable robot model | UNKNOWN | `no_model` |
//! | another robot was described, and its model is being built | UNKNOWN | `model_swap` |
//! | no link of the robot has collision geometry | UNKNOWN | `no_geometry` |
//! | no joint state has arrived | UNKNOWN | `no_joint_state` |
//! | the clock was set back by more than `stale_after`, and no joint state has arrived since | UNKNOWN | `clock_jump` |
//! | simulated time is asked for and none has arrived | UNKNOWN | `no_clock` |
//! | the last joint state that names some joint, or its stamp, is older than `stale_after` | UNKNOWN | `stale` |
//! | its stamp lies more than `stale_after` in the future | UNKNOWN | `future_stamp` |
//! | its stamp is older than that of the last evaluated one of the same publisher about the same joints | UNKNOWN | `out_of_order` |
//! | names and positions differ in number, a joint twice, a name of more than 1024 bytes, a position that no joint can have | UNKNOWN | `malformed` |
//! | a position of the robot is NaN or infinite | UNKNOWN | `non_finite` |
//! | `tf` does not tell where a joint is that it has to place, or no more | UNKNOWN | `no_transform` |
//! | a joint has never been named | UNKNOWN | `partial` |
//! | two publishers report a joint at different places at about the same time | UNKNOWN | `contradiction` |
//! | a mimic joint is reported elsewhere than where its leader takes it, unless the settings make that a warning | UNKNOWN | `contradiction` |
//! | the last message of a sensor shows nothing of the room | UNKNOWN | `blind_cloud` |
//! | something that was announced is missing from the world because it was rejected | UNKNOWN | `rejected_obstacle` |
//! | messages about the world were lost on their way | UNKNOWN | `lost_messages` |
//! | messages about the world were received 0.1 s ago, and are not in force yet | UNKNOWN | `world_update` |
//! | a sensor that sees the world is silent for longer than its time-to-live, or never spoke; a whole scene that is required was never told; `tf` lost the root in what obstacles stand in | UNKNOWN | `stale_world` |
//! | some pair touches | COLLIDING | |
//! | `check_deadline` passed before every pair was decided | UNKNOWN | `deadline` |
//! | every pair was found apart | FREE | |
//!
//! Joint states of several publishers are merged. For each joint, the last message with its name counts, with its own age.
//! A joint state with names and without positions is skipped, with a warning.
//! Mimic joints need not be reported. For those that are, the last message with the name counts, too.
//! Unknown joints, joints outside their limits and stamps of zero do not prevent an evaluation; they are warnings.
//! Each evaluation also contains the allowed share of the robot's speed: 0 unless the status is FREE.
//! With a look-ahead horizon it also contains the time until which nothing can touch; if that cannot be computed, there is a
//! warning.
//! Silence never means safe: a heartbeat publishes the last evaluation again, with its growing age, until it is stale.

// minima of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
#![deny(missing_docs)]

mod approach_rate;
mod check_budget;
pub mod cloud;
mod contact_watch;
mod contribution;
mod evaluation;
mod input;
mod joint_state_history;
mod joint_state_merger;
mod look_ahead;
mod mimic_reports;
mod monitor;
mod now;
mod obstacle_motion;
mod received_states;
mod root_location;
mod settings;
mod speed;
mod speed_settings;
mod state_evaluator;
mod status;
mod transform_joints;
mod world_source;
mod world_updates;

#[cfg(test)]
mod tests;

pub use clearance_scene::Time;
pub use evaluation::{CheckedState, Evaluation, Expiry, LeftOut, Revision};
pub use input::{JointStateInput, SourceId};
pub use joint_state_history::JointStateHistory;
pub use monitor::Monitor;
pub use now::Now;
pub use obstacle_motion::ObstacleMotion;
pub use settings::MonitorSettings;
pub use speed_settings::{SpeedDistances, SpeedSettings};
pub use state_evaluator::Stopwatch;
pub use status::{Reason, Status};
pub use world_source::{Observation, WorldSource};
