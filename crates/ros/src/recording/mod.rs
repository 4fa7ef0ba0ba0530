//! Recordings of the node's inputs and outputs in processing order, and their replay without a network.
//!
//! ```text
//! monitor loop, loader, tf, clock ──> tape (bounded, never waits) ──> writer ──> FILE.mcap
//! FILE.mcap ──> reader ──> replay: the same loader and the same monitor ──> the first answer that differs
//! ```
//!
//! A recording is an MCAP file of the `ros2` profile: messages in CDR with `ros2msg` schemas, as `ros2 bag` and Foxglove read them.
//! The topic `~/recording` (`std_msgs/String`) has one `RecordStep` in JSON for each event that changed the node's inputs or
//! outputs. The messages of a step are stored right before it. Files (robot, world, meshes) are attachments.

mod difference;
mod mcap_file;
mod messages;
mod recorder_handle;
mod replay;
mod save;
mod step;
mod step_messages;
mod writer;

#[cfg(test)]
mod tests;

pub use mcap_file::ReadError;
pub use recorder_handle::{Given, Judged, OriginalMessage, RecordedEvent, RecorderHandle};
pub use replay::{Archive, Difference, Outcome, Prepared, recorded_path, replay};
pub use save::save_part;
pub use step::{Clocks, OrderStep, RecordedMonitorEvent, SceneDoor};
pub use writer::{Recorder, RecordingSettings};
