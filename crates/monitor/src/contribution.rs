//! Stamps, ages and freshness of the joint state messages that make up the robot's state.

use std::time::Duration;

use clearance_geometry::math::Extremes;

use super::{MonitorSettings, Now, Reason, Time};

/// A message that is the last one with a position for some joints of the robot.
#[derive(Clone, Debug)]
pub(super) struct Contribution {
    /// Stamp in use.
    pub stamp: Time,
    /// Time of reception (steady clock).
    pub at: Duration,
    /// Indices of the positions that are taken from this message.
    pub positions: Vec<usize>,
}

/// All messages that make up the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Contributions(pub Vec<Contribution>);

impl Contributions {
    /// Stamp of the oldest message: later motion of its joints is unknown.
    pub fn stamp(&self) -> Option<Time> {
        self.0.iter().map(|c| c.stamp).min()
    }

    /// Stamp of the newest message.
    pub fn newest_stamp(&self) -> Option<Time> {
        self.0.iter().map(|c| c.stamp).max()
    }

    /// Time (s) between the oldest and the newest stamp.
    pub fn spread(&self) -> f64 {
        self.newest_stamp().zip(self.stamp()).map_or(0.0, |(newest, oldest)| newest.seconds_since(oldest))
    }

    /// Whether all messages are still valid; `names` are the names of the robot's positions.
    pub fn freshness(&self, now: Now, settings: &MonitorSettings, names: &[String]) -> Result<(), Reason> {
        let stale_after = settings.stale_after;
        let ros = now.ros.ok_or(Reason::NoClock)?;
        let ages = self.0.iter().map(|c| (c, ros.seconds_since(c.stamp)));
        let mut joints = Vec::new();
        let (mut oldest, mut ahead, mut all) = (0.0_f64, 0.0_f64, true);
        for (contribution, age) in ages {
            let older = age.greater(contribution.since_reception(now));
            ahead = ahead.greater(-age);
            if older > stale_after {
                oldest = oldest.greater(older);
                joints.extend(contribution.positions.iter().map(|&index| names[index].clone()));
            } else {
                all = false;
            }
        }
        if !joints.is_empty() {
            if all {
                joints.clear();
            }
            return Err(Reason::Stale { joints, age: oldest, stale_after, also: None });
        }
        if ahead > stale_after { Err(Reason::FutureStamp { ahead }) } else { Ok(()) }
    }

    /// Time until the first message becomes stale; `None` if one is stale already.
    pub fn time_to_stale(&self, now: Now, settings: &MonitorSettings) -> Option<Duration> {
        let ros = now.ros.filter(|_| !self.0.is_empty())?;
        let oldest = self.0.iter().map(|c| ros.seconds_since(c.stamp).greater(c.since_reception(now)));
        let left = settings.stale_after - oldest.fold(0.0, f64::greater);
        // slightly later, so that the state is stale at that time despite rounding
        Some(Duration::try_from_secs_f64(left).ok()? + Duration::from_millis(1))
    }
}

impl Contribution {
    /// Time (s) since the reception.
    fn since_reception(&self, now: Now) -> f64 {
        now.steady.saturating_sub(self.at).as_secs_f64()
    }
}
