//! The ROS 2 node: connects subscriptions to the monitor, and evaluations to publishers. This crate makes no safety decisions.
//!
//! ```text
//! robot_description, parameters ──> loader ──────┐ checkers
//! joint_states ──────────────────────────────> monitor loop ──> ~/state, ~/is_free, ~/distance, /diagnostics, ~/time_to_contact,
//! parameter services, /clock ──> services ───────┘ settings │   ~/speed_scale; markers ──> ~/markers
//! ~/enable ──> services ──> monitor loop
//! ~/check_motion, ~/check_trajectory ──> services ──> motions <─┘ the robot, the world, the current joint state
//!                                       answers <── services <──┘ └──> ~/certificates, ~/swept_volume
//! ~/check_states, ~/get_distances ──> services ──> states ──> services ──> answers
//! ```
//!
//! planning scenes, octomaps, clouds, tf, services about them ──> world ──> loader
//!
//! monitor loop, loader, world ──> recorder, if it is wanted
//!
//! With the option `view`, every evaluation is also passed to the `view`, which shows it in web browsers.
//!
//! Each box is a thread; the threads communicate through channels. Only `middleware` calls the ROS client library. `thread_priority`
//! documents the priorities of the threads, and why no thread may wait for another one by yielding.

// minima of floating-point numbers: see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod activity;
mod arguments;
mod cdr;
mod checker_of_scene;
pub mod clearance_msgs;
pub mod clearance_srvs;
mod clock;
mod diagnostics;
pub mod doctor;
mod enable_service;
mod environment;
#[doc(hidden)]
pub mod fuzzing;
mod goals;
#[cfg(test)]
mod interface_text;
mod link_volumes;
mod loader;
mod loader_inputs;
mod log_rate_limiter;
mod logged_meshes;
pub mod logging;
mod lost_messages;
mod mailbox;
mod marker_topic;
mod markers;
mod memory_limit;
mod messages;
mod middleware;
mod missing_objects;
mod monitor_loop;
mod motion;
mod motion_requests;
mod motion_services;
mod names;
mod order;
mod parameter_files;
mod parameter_services;
mod parameter_value;
mod parameters;
mod publishers;
pub mod recording;
mod refusal;
mod request_context;
mod run;
mod scene;
mod scene_keeper;
mod scene_order;
mod sequence_gaps;
mod simulation_clock;
mod startup;
mod state_requests;
mod state_services;
mod swept_volume_markers;
mod termination;
mod thread_priority;
mod threads;
mod trajectory_action;
mod view;
mod waiting;
mod whole_scene;

pub use arguments::{ArgumentError, ParameterSource, RosArguments};
pub use environment::{Environment, EnvironmentError, Reach};
pub use loader::Surroundings;
pub use middleware::{Announcement, MiddlewareError};
pub use monitor_loop::Observer;
pub use motion::{Motion, Trajectory};
pub use parameter_value::Value;
pub use parameters::Parameters;
pub use run::{NODE_NAME, NodeError, NodeOptions, initial_parameters, run};
pub use startup::Startup;
pub use termination::is_ending;
pub use thread_priority::ThreadPriority;
pub use view::{View, ViewAddress, ViewAddressError, ViewError};
