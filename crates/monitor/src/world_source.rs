//! Sensors of the world, and the age and staleness of their data.

use std::time::Duration;

use clearance_geometry::math::Extremes;

use super::{Now, Reason, Time};

/// A sensor that publishes the world repeatedly: the topic of a point cloud, or the octomap.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldSource {
    /// Name of the topic, or of the octomap.
    pub name: String,
    /// Times of its last measurement; `None` before the first one.
    pub seen: Option<Observation>,
    /// Age (s) beyond which the last measurement is stale.
    pub ttl: f64,
}

/// Time of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observation {
    /// Stamp of the sensor.
    pub stamp: Time,
    /// Time of reception (steady clock).
    pub at: Duration,
}

impl Observation {
    /// Age (s): by its stamp, or since its reception if that is longer.
    #[must_use]
    pub fn age(&self, now: Now) -> f64 {
        let since_reception = now.steady.saturating_sub(self.at).as_secs_f64();
        now.ros.map_or(since_reception, |ros| ros.seconds_since(self.stamp).greater(since_reception))
    }
}

impl WorldSource {
    /// Age (s) of the last message: by its stamp, or since its reception if that is longer; `None` before the first
    /// one.
    #[must_use]
    pub fn age(&self, now: Now) -> Option<f64> {
        Some(self.seen?.age(now))
    }

    /// Why the data of this sensor is stale, if it is.
    pub fn freshness(&self, now: Now) -> Result<(), Reason> {
        let age = self.age(now);
        if age.is_some_and(|age| age <= self.ttl) {
            return Ok(());
        }
        Err(Reason::StaleWorld { source: self.name.clone(), age, ttl: self.ttl })
    }

    /// Time until it becomes stale, if it is not.
    pub(super) fn time_to_stale(&self, now: Now) -> Option<Duration> {
        let left = self.ttl - self.age(now).filter(|age| *age <= self.ttl)?;
        // slightly later, so that it is stale at that time despite rounding
        Some(Duration::try_from_secs_f64(left).ok()? + Duration::from_millis(1))
    }
}
