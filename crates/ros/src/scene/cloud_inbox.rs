//! Point clouds that were received and not processed yet: the latest of each topic.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use clearance_monitor::{Now, Time};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::PointCloud2;

use crate::messages::time_and_geometry::time_of;

/// Latest unprocessed cloud of each topic: a new cloud replaces the previous one.
#[derive(Default)]
pub struct CloudMessages {
    by_topic: Mutex<BTreeMap<String, CloudMessage>>,
}

/// A cloud and the time of its reception.
pub struct CloudMessage {
    pub cloud: Arc<PointCloud2>,
    pub received_at: Now,
    pub since: Instant,
}

impl CloudMessage {
    /// Time of the measurement: the stamp of the cloud, or the time of reception if it has none.
    #[must_use]
    pub fn stamp(&self) -> Time {
        match time_of(&self.cloud.header.stamp) {
            Time::ZERO => self.received_at.ros.unwrap_or_default(),
            stamp => stamp,
        }
    }
}

impl CloudMessages {
    /// Stores a cloud.
    pub fn put(&self, topic: &str, message: CloudMessage) {
        self.lock().insert(topic.to_owned(), message);
    }

    /// Takes all clouds that were stored since the last call.
    pub fn take(&self) -> BTreeMap<String, CloudMessage> {
        std::mem::take(&mut *self.lock())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, CloudMessage>> {
        self.by_topic.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
