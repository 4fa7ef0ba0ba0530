//! Readings of the clocks.

use std::time::Duration;

use super::Time;

/// Readings of ROS time and of a steady clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Now {
    /// ROS time, in which messages are stamped; `None` while simulated time is asked for and none has arrived.
    pub ros: Option<Time>,
    /// A clock that never jumps, from any origin. It notices silence even when ROS time stands still or jumps.
    pub steady: Duration,
}
