//! The ROS 2 node: connects subscriptions to the monitor, and evaluations to publishers. This crate makes no safety
//! decisions.
//!
//! ```text
//! robot_description, parameters ──> loader ──────┐ checkers
//! joint_states ──────────────────────────────> monitor loop ──> ~/state, ~/is_free, ~/distance, /diagnostics, ~/time_to_contact,
//! parameter services, /clock ──> services ───────┘ settings │   ~/speed_scale; markers ──> ~/markers
//!                                                           │   retreat ──> ~/retreat_direction
//! ~/enable ──> services ──> monitor loop
//! ~/check_motion(s), ~/check_trajectory ─> services ─> motions <┘ the robot, the world, the current joint state
//!                                     responses <── services <──┘ └──> ~/certificates, ~/swept_volume
//! ~/check_states, ~/get_distances, ~/find_free_state ──> services ──> states ──> services ──> responses
//! planning scenes, octomaps, clouds, tf, services about them ──> world ──> loader
//! monitor loop, loader, world ──> recorder, if recording is on
//! ```
//!
//! Each box is a thread; the threads communicate through channels. With the option `view`, every evaluation is also
//! passed to `clearance_view`, which shows it in web browsers. `threading::thread_priority` documents the priorities of the
//! threads, and why no thread may wait for another one by yielding.
//!
//! A folder uses only folders above it in this table:
//!
//! | folder | content |
//! |---|---|
//! | `threading` | queues, waits and priorities |
//! | `parameters` | values, declarations, files |
//! | `dds` | participant, endpoints, discovery; the only user of the DDS library |
//! | `messages` | messages as structs, conversions |
//! | `monitor_events` | data between the monitor thread and other threads |
//! | `recording` | steps and messages, in an MCAP file |
//! | `scene` | the scene of the loader, and its commands |
//! | `topics` | publishers and subscriptions |
//! | `services` | services and the action |
//! | `loading` | the loader thread |
//! | `node` | start, monitor thread, end |
//! | `replay` | recordings without a network |
//! | `doctor` | faults of the network |

// minima of floating-point numbers: see `math/extremes.rs` of clearance-geometry
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod arguments;
mod clock;
mod dds;
mod doctor;
mod environment;
#[doc(hidden)]
pub mod fuzzing;
mod loading;
mod log_rate_limiter;
mod logging;
mod messages;
mod monitor_events;
mod names;
mod node;
mod node_error;
mod parameters;
mod recording;
mod replay;
mod scene;
mod services;
mod threading;
mod topics;

pub use arguments::{ArgumentError, RosArguments};
pub use clearance_view::{View, ViewAddress, ViewAddressError, ViewError};
pub use dds::announcement::Announcement;
pub use dds::middleware_error::MiddlewareError;
pub use doctor::examination::{DoctorOptions, run_doctor};
pub use doctor::finding::{Finding, Verdict};
pub use environment::{Environment, EnvironmentError, Reach};
pub use loading::loader::Surroundings;
pub use logging::start_logging;
pub use monitor_events::current_evaluation::Observer;
pub use names::{NODE_NAME, NameError};
pub use node::initial_parameters::initial_parameters;
pub use node::node_options::NodeOptions;
pub use node::run::run;
pub use node::startup::Startup;
pub use node::termination::is_ending;
pub use node_error::NodeError;
pub use parameters::parameter_set::Parameters;
pub use parameters::parameter_source::ParameterSource;
pub use parameters::parameter_value::Value;
pub use recording::mcap_file::ReadError;
pub use recording::recorded_event::CommandLineInputs;
pub use recording::save::save_part;
pub use replay::archive::Archive;
pub use replay::replayer::{Difference, Outcome, Prepared, recorded_path, replay};
pub use threading::thread_priority::ThreadPriority;
pub use topics::demo_motion::{Motion, Trajectory};
