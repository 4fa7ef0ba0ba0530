//! Events that the other threads send to the monitor thread. Joint states and transforms it receives itself.

use std::sync::Arc;

use clearance_monitor::{Reason, Revision};

use crate::monitor_events::cloud_report::CloudReports;
use crate::monitor_events::world_update::WorldUpdate;
use crate::parameters::parameter_set::Parameters;
use crate::threading::mailbox::Sender;

/// Messages from the other threads to the monitor.
pub enum MonitorEvent {
    Checker(Arc<Revision>),
    /// A new robot description was received: its checker or its fault follows.
    ModelSwap,
    ModelFault(String),
    /// A description was received that differs from the last one of its topic. `DescriptionsProcessed`: number of
    /// descriptions that the loader has accepted or rejected.
    DescriptionReceived,
    DescriptionsProcessed(u64),
    /// Progress of a scene message, from its reception until it is in use.
    WorldUpdate(WorldUpdate),
    /// Turns checking on or off; the sender is notified when this is done.
    Enabled(bool, Sender<()>),
    /// Request to publish an evaluation after all earlier events; the sender is notified when it is published.
    PublishNow(Sender<()>),
    /// Reports on the point clouds, rejected parts of the last scene updates, and the reason why the world is
    /// incomplete, if it is.
    World {
        clouds: CloudReports,
        faults: Vec<String>,
        incomplete: Option<Reason>,
    },
    Parameters(Box<Parameters>),
    /// Memory used by the process (MiB) and its limit (MiB); the sender waits until the status is published.
    Memory {
        used: u64,
        limit: u64,
        published: Sender<()>,
    },
    Stop,
}
