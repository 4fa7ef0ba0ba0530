//! Point clouds that were received and not processed yet: the latest of each topic.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use clearance_monitor::{Now, Time};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::PointCloud2;

use crate::messages::time_and_geometry::time_of;

/// Time (s) by which the stamp of a cloud may be later than the clock. A later one is of a clock that was set back.
const LARGEST_LEAD: f64 = 1.0;

/// Time (s) by which a cloud is older than the last one of its topic, as of a second sensor: the last one remains. `None` if it is
/// not older, or the stamp of the last one is of a clock that was set back.
pub fn delay_of(stamp: Time, last: Time, now: Now) -> Option<f64> {
    let delay = last.seconds_since(stamp);
    let is_set_back = now.ros.is_some_and(|now| last.seconds_since(now) > LARGEST_LEAD);
    (delay > 0.0 && !is_set_back).then_some(delay)
}

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
    /// Whether several publishers send on its topic.
    pub is_shared: bool,
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
    /// Stores a cloud, unless it is older than the one that waits: `false`.
    pub fn put(&self, topic: &str, message: CloudMessage) -> bool {
        let mut waiting = self.lock();
        let last = waiting.get(topic).map(CloudMessage::stamp);
        let is_late = last.is_some_and(|last| delay_of(message.stamp(), last, message.received_at).is_some());
        match waiting.get_mut(topic) {
            Some(last) if is_late => last.is_shared |= message.is_shared,
            _ => drop(waiting.insert(topic.to_owned(), message)),
        }
        !is_late
    }

    /// Takes all clouds that were stored since the last call.
    pub fn take(&self) -> BTreeMap<String, CloudMessage> {
        std::mem::take(&mut *self.lock())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, CloudMessage>> {
        self.by_topic.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(seconds: i32, now: i64) -> CloudMessage {
        let mut cloud = PointCloud2::default();
        cloud.header.stamp.sec = seconds;
        let ros = Some(Time::from_nanoseconds(now * 1_000_000_000));
        let received_at = Now { steady: std::time::Duration::ZERO, ros };
        CloudMessage { cloud: Arc::new(cloud), received_at, since: Instant::now(), is_shared: false }
    }

    #[test]
    fn the_newer_of_two_clouds_waits_unless_the_clock_was_set_back() {
        let clouds = CloudMessages::default();
        let waiting = || clouds.take().remove("points").unwrap().cloud.header.stamp.sec;
        assert!(clouds.put("points", cloud(20, 20)) && !clouds.put("points", cloud(19, 20)));
        assert!(clouds.put("others", cloud(19, 20)));
        assert_eq!(waiting(), 20);
        assert!(clouds.put("points", cloud(20, 20)) && clouds.put("points", cloud(5, 5)));
        assert_eq!(waiting(), 5);
    }
}
