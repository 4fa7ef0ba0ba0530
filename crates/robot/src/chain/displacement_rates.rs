//! Upper bounds on the motion of bodies from joint motion, independent of poses.
//!
//! When one joint moves, the bodies beyond it move rigidly relative to the rest. A revolute joint moves their points by at most the angle
//! times their largest possible distance from the axis, a prismatic joint by its own motion. No distance between two points changes by
//! more. Joints can be considered to move one after the other, so a change of all positions changes no distance by more than the sum.
//! (The bound of conservative advancement: Zhang, Redon, Lee & Kim 2007, *Continuous collision detection for articulated models using
//! Taylor models and temporal culling*, section 4, with reaches that hold for all positions.)

use clearance_geometry::math::Extremes;

use super::{Chain, Source, Step};

/// Distance (m) beyond the limits of a prismatic joint up to which there are bounds: encoders report such positions.
const BEYOND_LIMITS: f64 = 0.01;

/// For each position of a robot: maximum change (m) of any distance per unit of the position.
#[derive(Clone, Debug, Default)]
pub struct DisplacementRates {
    /// Position index, and rate in metres per radian or per metre.
    rates: Vec<(usize, f64)>,
    /// Positions that lengthen the chain, and the ranges in which the rates hold.
    ranges: Vec<(usize, [f64; 2])>,
}

impl DisplacementRates {
    /// Upper bound (m) on the change of any distance between two points of the robot or its world between two states; infinite where
    /// there is no bound.
    #[must_use]
    #[inline]
    pub fn between(&self, from: &[f64], to: &[f64]) -> f64 {
        let held =
            |i: usize, [low, high]: [f64; 2]| [from[i], to[i]].iter().all(|q| (low..=high).contains(q));
        if !self.ranges.iter().all(|&(i, range)| held(i, range)) {
            return f64::INFINITY;
        }
        let steps = self.rates.iter().map(|&(i, rate)| (rate, (to[i] - from[i]).abs()));
        let travel: f64 = steps.filter(|(_, step)| *step != 0.0).map(|(rate, step)| rate * step).sum();
        // NaN is no bound
        if travel.is_nan() { f64::INFINITY } else { travel * (1.0 + 1e-12) }
    }
}

impl Chain {
    /// The rates for bodies whose points are within `reach` (m, by body) of the bodies' origins; `range` gives the limits of a position,
    /// `None` where there are none.
    #[must_use]
    pub fn displacement_rates(
        &self,
        reach: &[f64],
        range: impl Fn(usize) -> Option<[f64; 2]>,
    ) -> DisplacementRates {
        let mut travel = DisplacementRates::default();
        // maximum distance of all points beyond a body from its origin, for any joint positions
        let mut extent = reach.to_vec();
        for (i, body) in self.bodies.iter().enumerate().rev() {
            let below = extent[i + 1];
            let mut stretch = 0.0;
            match &body.step {
                Step::Turn(_, source) => travel.add(source.index, source.multiplier.abs() * below),
                Step::Shift(_, source) => {
                    travel.add(source.index, source.multiplier.abs());
                    stretch = range(source.index).map_or(f64::INFINITY, |range| {
                        let range = [range[0] - BEYOND_LIMITS, range[1] + BEYOND_LIMITS];
                        travel.ranges.push((source.index, range));
                        farthest(source, range)
                    });
                }
                Step::Float(_, first) => {
                    (0..3).for_each(|k| travel.add(first + k, 1.0));
                    // unit quaternions differ by twice the sine of a quarter of the angle
                    (3..7).for_each(|k| travel.add(first + k, 2.0 * below));
                    stretch = f64::INFINITY;
                }
            }
            let offset = body.origin.iter().map(|c| c * c).sum::<f64>().sqrt();
            extent[body.parent] = extent[body.parent].greater(offset + stretch + below);
        }
        travel
    }
}

impl DisplacementRates {
    fn add(&mut self, index: usize, rate: f64) {
        match self.rates.iter_mut().find(|(i, _)| *i == index) {
            Some((_, known)) => *known += rate,
            None => self.rates.push((index, rate)),
        }
    }
}

/// The maximum translation of a position in `range`.
fn farthest(source: &Source, range: [f64; 2]) -> f64 {
    range.iter().map(|q| (q * source.multiplier + source.offset).abs()).fold(0.0, f64::greater)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::tests::{frames, random_positions, random_tree};
    use crate::{ChainJoint, Frame, Motion};
    use clearance_geometry::math::Vector;
    use clearance_geometry::testing::Random;

    /// The distance of points of any two bodies changes by no more than the rates allow.
    #[test]
    fn no_distance_changes_by_more() {
        let mut random = Random::new(77);
        let mut tightest = f64::INFINITY;
        for _ in 0..400 {
            let (joints, count, needed) = random_tree(&mut random, 9);
            let chain = Chain::compile(0, &joints, &needed);
            let reach: Vec<f64> = (0..chain.body_count()).map(|_| random.within(0.3).abs()).collect();
            let rates = chain.displacement_rates(&reach, |_| Some([-5.0, 5.0]));
            let from = random_positions(&mut random, &joints, count);
            let to = near(&from, &joints, &mut random);
            let bound = rates.between(&from, &to);
            let (before, after) = (frames(&chain, &from), frames(&chain, &to));
            for a in 0..chain.body_count() {
                for b in 0..chain.body_count() {
                    let [p, q] = [a, b].map(|i| (random.direction().into_inner() * reach[i]).into());
                    let apart =
                        |f: &[Frame<f64>]| (Vector::from(f[a].point(p)) - Vector::from(f[b].point(q))).norm();
                    let change = (apart(&after) - apart(&before)).abs();
                    assert!(change <= bound + 1e-12, "{change} > {bound}");
                    tightest = tightest.lesser((bound + 1e-12) / (change + 1e-12));
                }
            }
        }
        assert!(tightest < 1.3, "some bound is nearly reached: {tightest}");
    }

    #[test]
    fn beyond_the_range_nothing_is_known() {
        let slide = Source { index: 0, multiplier: 1.0, offset: 0.0 };
        let motion = Motion::Prismatic(Vector::x_axis(), slide);
        let joint =
            ChainJoint { parent: 0, child: 1, pose_pj: clearance_geometry::math::Pose::identity(), motion };
        let rates =
            Chain::compile(0, &[joint], &[true; 2]).displacement_rates(&[1.0; 2], |_| Some([0.0, 1.0]));
        assert!((rates.between(&[0.25], &[0.75]) - 0.5).abs() < 1e-9);
        assert_eq!(rates.between(&[0.25], &[1.25]), f64::INFINITY);
        assert_eq!(rates.between(&[0.25], &[f64::NAN]), f64::INFINITY);
    }

    /// Positions near other positions; quaternions keep their length.
    fn near(from: &[f64], joints: &[ChainJoint], random: &mut Random) -> Vec<f64> {
        let step = 10f64.powf(random.within(2.0) - 2.0);
        let mut to: Vec<f64> = from.iter().map(|q| q + random.within(step)).collect();
        for joint in joints {
            if let Motion::Floating(first) = joint.motion {
                let turn = nalgebra::Vector4::from_column_slice(&to[first + 3..first + 7]).normalize();
                to[first + 3..first + 7].copy_from_slice(turn.as_slice());
            }
        }
        to
    }
}
