//! Stamps of the transforms that give positions of a joint state, and the time between them.

use clearance_geometry::math::Extremes;

use super::Time;

/// Frames and stamps of the transforms that positions are from.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TransformStamps(Vec<(String, Time)>);

impl FromIterator<(String, Time)> for TransformStamps {
    fn from_iter<I: IntoIterator<Item = (String, Time)>>(stamps: I) -> Self {
        Self(stamps.into_iter().collect())
    }
}

impl TransformStamps {
    /// Longest time (s) between a stamp and another time; a stamp ahead of the clock counts as that of the clock.
    pub fn spread(&self, stamp: Time, ros: Option<Time>) -> f64 {
        let apart = |of: Time| ros.map_or(of, |ros| of.min(ros)).seconds_since(stamp).abs();
        self.0.iter().map(|(_, of)| apart(*of)).fold(0.0, f64::greater)
    }

    /// Longest time (s) between two stamps of a transform; `None` if there are none, or not of the same transforms.
    pub fn longest_interval(&self, before: &Self) -> Option<f64> {
        let are_same = self.0.iter().map(|(frame, _)| frame).eq(before.0.iter().map(|(frame, _)| frame));
        if self.0.is_empty() || !are_same {
            return None;
        }
        let intervals =
            self.0.iter().zip(&before.0).map(|((_, now), (_, then))| now.seconds_since(*then).abs());
        Some(intervals.fold(0.0, f64::greater))
    }
}
