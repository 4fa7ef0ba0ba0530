//! Events that report the progress of scene messages to the monitor, from reception until checks use them.

use std::time::Duration;

use clearance_monitor::Monitor;
use serde::{Deserialize, Serialize};

/// Progress of scene messages, from their reception until they are in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WorldUpdate {
    /// A message was received, at this steady time (ns).
    Received { steady: u64 },
    /// The last received message requires no change.
    Withdrawn,
    /// This number of messages, the oldest ones, will be in use with the loader's next event.
    Completing(usize),
}

impl WorldUpdate {
    pub fn apply_to(self, monitor: &mut Monitor) {
        match self {
            Self::Received { steady } => monitor.note_world_update(Duration::from_nanos(steady)),
            Self::Withdrawn => monitor.note_world_update_withdrawn(),
            Self::Completing(updates) => monitor.note_world_updates_completing(updates),
        }
    }
}
