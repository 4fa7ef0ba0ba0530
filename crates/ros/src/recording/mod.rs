//! Recordings of the node's inputs and outputs in processing order.
//!
//! ```text
//! monitor loop, loader, tf, clock ──> recorder handle (bounded, never waits) ──> recorder ──> FILE.mcap
//! ```
//!
//! A recording is an MCAP file of the `ros2` profile: messages in CDR with `ros2msg` schemas, as `ros2 bag` and
//! Foxglove read them. The topic `~/recording` (`std_msgs/String`) has one `RecordStep` in JSON for each event that
//! changed the node's inputs or outputs. The messages of a step are stored right before it. Files (robot, world,
//! meshes) are attachments.

pub mod mcap_file; // reader of MCAP files
pub mod message_schemas; // message schemas that are stored in a recording
pub mod recorded_event; // types of recorded events
pub mod recorder; // recorder thread: writes an MCAP file
pub mod recorder_handle; // handle through which the node records events
pub mod save; // saves a part of a recording
pub mod step; // steps of a recording
