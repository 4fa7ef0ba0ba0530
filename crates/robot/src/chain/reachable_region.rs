//! Where bodies can ever be: known before any position is.

use std::ops::RangeInclusive;

use clearance_geometry::math::{Extremes, Vector};

use super::{Chain, Source, Step};

/// Rounding that is granted to sums of lengths.
const GRANTED: f64 = 1e-9;

/// A ball (root frame) that something never leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachableRegion {
    pub centre: Vector,
    /// Infinite where a joint floats, or slides by a position that has no range (m).
    pub radius: f64,
}

impl Chain {
    /// The territories of the origins of all bodies, by body, as long as positions by which joints slide are in their ranges (m).
    /// Joints turn as far as they like.
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

    /// The positions by which joints slide.
    #[inline]
    pub fn sliding_positions(&self) -> impl Iterator<Item = usize> {
        self.bodies.iter().filter_map(|body| match &body.step {
            Step::Shift(_, source) => Some(source.index),
            Step::Turn(..) | Step::Float(..) => None,
        })
    }
}

impl Source {
    /// The largest number that comes of positions in a range, of either sign.
    fn farthest(&self, range: &RangeInclusive<f64>) -> f64 {
        let [lower, upper] = [range.start(), range.end()].map(|q| (self.multiplier * q + self.offset).abs());
        lower.greater(upper)
    }
}
