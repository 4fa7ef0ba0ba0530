//! What sees the world, and how long its word counts.

use std::time::Duration;

use clearance_geometry::math::Extremes;

use super::{Now, Reason, Time};

/// Something that tells what is around the robot again and again: a point cloud's topic, or the octomap.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldSource {
    pub name: String,
    /// What it told last; `None` while it never has.
    pub seen: Option<Observation>,
    /// Age (s) beyond which that says nothing about the world any more.
    pub ttl: f64,
}

/// When something was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observation {
    /// By the sensor's stamp.
    pub stamp: Time,
    /// When the message came, by the steady clock.
    pub at: Duration,
}

impl WorldSource {
    /// How old (s) its word is: by its stamp, or since it came if that is longer; `None` while there is none.
    #[must_use]
    pub fn age(&self, now: Now) -> Option<f64> {
        let seen = self.seen?;
        let silence = now.steady.saturating_sub(seen.at).as_secs_f64();
        Some(now.ros.map_or(silence, |ros| ros.seconds_since(seen.stamp).greater(silence)))
    }

    /// Why the world is not known any more, if it is not.
    pub fn freshness(&self, now: Now) -> Result<(), Reason> {
        let age = self.age(now);
        if age.is_some_and(|age| age <= self.ttl) {
            return Ok(());
        }
        Err(Reason::StaleWorld { source: self.name.clone(), age, ttl: self.ttl })
    }

    /// How long it stays fresh, if it is.
    pub(super) fn time_to_stale(&self, now: Now) -> Option<Duration> {
        let left = self.ttl - self.age(now).filter(|age| *age <= self.ttl)?;
        // a little later, so that it is stale then whatever way rounding goes
        Some(Duration::try_from_secs_f64(left).ok()? + Duration::from_millis(1))
    }
}
