//! Data type of a reading of both clocks: ROS time and steady clock.

use std::time::Duration;

use super::Time;

/// Readings of ROS time and of a steady clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Now {
    /// ROS time, which message stamps use; `None` while simulated time is in use and none was received.
    pub ros: Option<Time>,
    /// Steady clock with an arbitrary origin. It measures silence even when ROS time stands still or jumps.
    pub steady: Duration,
}
