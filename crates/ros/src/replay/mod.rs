//! Module of replays of recordings without a network: `replayer` replays, the others read, compare and report.
//!
//! ```text
//! FILE.mcap ──> reader ──> replayer: the same loader and the same monitor ──> the first result that differs
//! ```

pub mod archive; // files and command line in a recording
pub mod difference; // comparison of a replayed evaluation with the recorded one
pub mod replayer; // runs loader and monitor on the recorded steps
pub mod step_messages; // messages of a recorded step

#[cfg(test)]
mod tests;
