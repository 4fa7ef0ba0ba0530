//! The ROS 2 node: subscriptions to the monitor, judgements to publishers. Nothing here decides what is safe.
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
//! On request every judgement is also left for the `view`, which shows it to web browsers.
//!
//! Each box is a thread; they talk through channels. Only `middleware` knows the ROS client library's calls. Which threads run first, and why
//! none of them may wait for others by yielding, is said in `thread_priority`.

// minima of floating-point numbers, see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod activity;
mod arguments;
mod arrivals;
mod cdr;
mod cell;
mod checker_of_scene;
pub mod clearance_msgs;
pub mod clearance_srvs;
mod clock;
mod diagnostics;
pub mod doctor;
mod enable_service;
mod environment;
mod flood;
#[doc(hidden)]
pub mod fuzzing;
mod goals;
#[cfg(test)]
mod interface_text;
mod link_volumes;
mod loader;
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
mod outlook;
mod parameter_files;
mod parameter_services;
mod parameter_value;
mod parameters;
mod publishers;
pub mod recording;
mod refusal;
mod run;
mod scene;
mod scene_keeper;
mod scene_order;
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
