//! Regions that bodies can reach, over all joint positions.

use std::ops::RangeInclusive;

use clearance_geometry::math::{Extremes, Vector};

use super::{Chain, Source, Step};

/// Rounding error allowed for sums of lengths.
const GRANTED: f64 = 1e-9;

/// A ball (root frame) that contains all positions of a point or body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachableRegion {
    /// Centre (m).
    pub centre: Vector,
    /// Radius (m). Infinite where a joint floats, or is prismatic without a range.
    pub radius: f64,
}

impl Chain {
    /// Balls around all positions of the bodies' origins, by body, as long as prismatic positions are in their ranges (m). Revolute
    /// joints are not limited.
    #[must_use]
    #[inline]
    pub fn territories(
        &self,
        range_of: impl Fn(usize) -> Option<RangeInclusive<f64>>,
    ) -> Vec<ReachableRegion> {
        let mut all = vec![ReachableRegion { centre: Vector::zeros(), radius: 0.0 }];
        for body in &self.bodies {
            let ReachableRegion { centre, radius } = all[body.parent];
            let offset = Vector::from(body.origin);
            let farther = match &body.step {
                Step::Turn(..) if body.parent == Self::ROOT => {
                    all.push(ReachableRegion { centre: offset, radius: 0.0 });
                    continue;
                }
                Step::Turn(..) => offset.norm(),
                Step::Shift(axis, source) => {
                    let slides =
                        range_of(source.index).map_or(f64::INFINITY, |range| source.farthest(&range));
                    offset.norm() + Vector::from(*axis).norm() * slides
                }
                Step::Float(..) => f64::INFINITY,
            };
            all.push(ReachableRegion { centre, radius: (radius + farther) * (1.0 + GRANTED) + GRANTED });
        }
        all
    }

    /// The positions of prismatic joints.
    #[inline]
    pub fn sliding_positions(&self) -> impl Iterator<Item = usize> {
        self.bodies.iter().filter_map(|body| match &body.step {
            Step::Shift(_, source) => Some(source.index),
            Step::Turn(..) | Step::Float(..) => None,
        })
    }
}

impl Source {
    /// The largest absolute value of a joint position over a range.
    fn farthest(&self, range: &RangeInclusive<f64>) -> f64 {
        let [lower, upper] = [range.start(), range.end()].map(|q| (self.multiplier * q + self.offset).abs());
        lower.greater(upper)
    }
}
