//! Access to the last evaluation for the other parts of the program.

use std::sync::{Arc, Mutex};

use clearance_monitor::{Evaluation, MonitorSettings};

/// The last evaluation, for services that evaluate requests about the same robot and world.
pub type CurrentEvaluation = Arc<Mutex<Option<Evaluation>>>;

/// Callback that receives every evaluation and its settings, for a display outside of ROS. It must return quickly.
pub type Observer = Box<dyn FnMut(&Evaluation, &MonitorSettings) + Send>;
