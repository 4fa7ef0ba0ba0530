//! Recordings: what the node heard, what it said, and in which order both counted; and the same run again without a network.
//!
//! ```text
//! monitor loop, loader, tf, clock ──> tape (bounded, never waits) ──> writer ──> FILE.mcap
//! FILE.mcap ──> reader ──> replay: the same loader and the same monitor ──> the first answer that differs
//! ```
//!
//! A recording is an MCAP file of the `ros2` profile: messages in CDR with `ros2msg` schemas, as `ros2 bag` and Foxglove read them.
//! The topic `~/recording` (`std_msgs/String`) has one `RecordStep` in JSON for everything that changed what is known or said; the messages
//! that a step is about stand right before it. Files (robot, world, meshes) are attachments.

mod mcap_file;
mod messages;
mod recorder_handle;
mod replay;
mod save;
mod step;
mod writer;

#[cfg(test)]
mod tests;

pub use mcap_file::ReadError;
pub use recorder_handle::{Given, Judged, OriginalMessage, RecordedEvent, RecorderHandle};
pub use replay::{Archive, Difference, Outcome, Prepared, recorded_path, replay};
pub use save::save_part;
pub use step::{Clocks, OrderStep, RecordedMonitorEvent, SceneDoor};
pub use writer::{Recorder, RecordingSettings};
