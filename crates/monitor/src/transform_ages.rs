//! Stamps and ages of the transforms on a path between two frames.

use std::time::Duration;

use clearance_geometry::math::Extremes;

use super::world_source::Observation;
use super::{Now, Time};

/// The transforms on a path that can become stale. Each has its own age: one may fall silent, with a stamp in the
/// future, while others go on.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TransformAges {
    links: Vec<LinkAge>,
}

/// Age of a frame's transform to its parent.
#[derive(Clone, Debug, PartialEq)]
struct LinkAge {
    frame: String,
    stamp: Time,
    /// Time of its first use (steady clock), so that it also becomes old while ROS time stands still.
    since: Option<Duration>,
}

impl TransformAges {
    /// The transforms of these frames, with their stamps.
    pub fn of<'t>(links: impl Iterator<Item = (&'t str, Time)>) -> Self {
        let of_link = |(frame, stamp): (&str, Time)| LinkAge { frame: frame.to_owned(), stamp, since: None };
        Self { links: links.map(of_link).collect() }
    }

    /// Keeps the times of first use of transforms that have not been published again.
    pub fn inherit(&mut self, before: &Self) {
        for link in &mut self.links {
            let same = before.links.iter().find(|b| b.frame == link.frame && b.stamp == link.stamp);
            link.since = same.and_then(|same| same.since);
        }
    }

    /// Starts the age of new transforms: they are used now.
    pub fn note_seen(&mut self, now: Now) {
        for link in &mut self.links {
            link.since.get_or_insert(now.steady);
        }
    }

    /// The times of each transform.
    pub fn observations(&self, now: Now) -> impl Iterator<Item = Observation> {
        self.links
            .iter()
            .map(move |link| Observation { stamp: link.stamp, at: link.since.unwrap_or(now.steady) })
    }

    /// The oldest stamp; `None` if no transform can become stale.
    pub fn oldest_stamp(&self) -> Option<Time> {
        self.links.iter().map(|link| link.stamp).min()
    }

    /// The frames and stamps of all transforms.
    pub fn stamps(&self) -> impl Iterator<Item = (&str, Time)> {
        self.links.iter().map(|link| (link.frame.as_str(), link.stamp))
    }

    /// The time that the pose is of: the newest stamp that is not in the future, since a transform that changes slowly may be
    /// stamped ahead, or repeated rarely; `None` if no transform can become stale.
    pub fn pose_stamp(&self, ros: Time) -> Option<Time> {
        let stamps = || self.links.iter().map(|link| link.stamp);
        stamps().filter(|stamp| *stamp <= ros).max().or_else(|| stamps().min())
    }

    /// Age (s) of the oldest transform: by its stamp, or since its first use if that is longer; negative infinity if
    /// none can become stale.
    pub fn age(&self, now: Now) -> f64 {
        self.observations(now).map(|seen| seen.age(now)).fold(f64::NEG_INFINITY, f64::greater)
    }

    /// Time (s) by which the newest stamp is later than this time; negative if all are earlier.
    pub fn lead(&self, ros: Time) -> f64 {
        self.links.iter().map(|link| link.stamp.seconds_since(ros)).fold(f64::NEG_INFINITY, f64::greater)
    }
}
