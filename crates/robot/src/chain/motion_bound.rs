//! Upper bound on the approach of two robot bodies during a motion, as derived in `docs/derivations/motion-bound.md`.

use clearance_geometry::constants::{KINEMATICS_ROUNDING, MOTION_SLACK};
use clearance_geometry::math::Extremes;

use super::{Reach, SideMotion};

/// Upper bound on the decrease of a pair's distance within an interval, and within parts of the interval around its middle.
#[derive(Clone, Copy, Debug)]
pub struct MotionBound {
    /// W, without tolerances.
    path_length: f64,
    /// Half the width times the relative speed.
    speed: f64,
    /// Remainders of the bound of first order.
    curvature: f64,
    /// Contribution of tolerances to both bounds.
    tolerance: f64,
    /// Remainders that do not shrink with the interval, since tolerances do not.
    fixed_remainder: f64,
    /// Error of the kinematics.
    rounding: f64,
}

impl MotionBound {
    /// Bound for two bodies with these motions and reaches, in an interval of this half width; no position is ever larger than `size`
    /// (rad, m). Where numbers overflow the bound is infinite.
    #[must_use]
    #[inline]
    pub fn new(sides: &[SideMotion; 2], reaches: &[Reach; 2], half_width: f64, size: f64) -> Self {
        let [a, b] = sides;
        let (velocity, angular) = (b.velocity - a.velocity, b.angular - a.angular);
        let speed =
            reaches.iter().map(|reach| reach.speed(&velocity, &angular)).fold(f64::INFINITY, f64::lesser);
        let tolerance = a.tolerance + b.tolerance;
        let remainder = a.remainder + b.remainder;
        let (curvature, fixed_remainder) = if tolerance > 0.0 { (0.0, remainder) } else { (remainder, 0.0) };
        let extent = reaches.iter().map(Reach::extent).sum::<f64>() + a.extent + b.extent;
        // before the offset of a mimic joint or the displacement of an obstacle cancels large values, these were rounded
        let rounding = KINEMATICS_ROUNDING * ((10.0 + size) * extent + 10.0 * size);
        let found = Self {
            path_length: a.path_length + b.path_length,
            speed: half_width * speed,
            curvature: curvature + a.curvature + b.curvature,
            tolerance,
            fixed_remainder,
            rounding,
        };
        let Self { path_length, speed, curvature, tolerance, fixed_remainder, rounding } = found;
        if (path_length + speed + curvature + tolerance + fixed_remainder + rounding).is_finite() {
            found
        } else {
            Self::ANY
        }
    }

    /// Infinite: there is no bound.
    const ANY: Self = Self {
        path_length: f64::INFINITY,
        speed: f64::INFINITY,
        curvature: 0.0,
        tolerance: 0.0,
        fixed_remainder: 0.0,
        rounding: 0.0,
    };

    /// The maximum decrease (m) of the pair's distance within a central part of the interval, given as a fraction of its width.
    #[must_use]
    #[inline]
    pub fn within(&self, share: f64) -> f64 {
        let first = share * (self.speed + share * self.curvature) + self.fixed_remainder;
        ((share * self.path_length).lesser(first) + self.tolerance) * (1.0 + MOTION_SLACK)
            + MOTION_SLACK
            + self.rounding
    }

    /// The part of that bound (m) that shrinks with the interval.
    #[must_use]
    #[inline]
    pub fn motion(&self) -> f64 {
        self.path_length.lesser(self.speed + self.curvature)
    }

    /// The fraction of the interval in which the pair's distance decreases by less than `room` (m).
    #[must_use]
    #[inline]
    pub fn share(&self, room: f64) -> f64 {
        let room = room * (1.0 - 2.0 * MOTION_SLACK) - 2.0 * MOTION_SLACK - self.rounding - self.tolerance;
        // NaN proves nothing
        if room.is_nan() || room <= 0.0 {
            return 0.0;
        }
        let by_path_length = room / self.path_length;
        let rest = room - self.fixed_remainder;
        // the positive root of curvature s² + speed s = rest, stable for small curvature
        let root = (self.speed * self.speed + 4.0 * self.curvature * rest).sqrt();
        let by_first_order = if rest > 0.0 { 2.0 * rest / (self.speed + root) } else { 0.0 };
        // without motion, the whole interval
        if self.path_length == 0.0 { 1.0 } else { by_path_length.greater(by_first_order).clamp(0.0, 1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::tests::{frames, random_positions, random_tree};
    use crate::{Chain, ChainJoint, Deviation, Deviations, Frame, Motion, PlacedFrame};
    use clearance_geometry::math::{UnitVector, Vector};
    use clearance_geometry::testing::Random;

    /// Positions that are cubic polynomials of t around a middle at 0, with small tolerances.
    struct Wave {
        middle: Vec<f64>,
        numbers: Vec<[f64; 3]>,
        tolerance: Vec<f64>,
        half_width: f64,
        /// By first position of a floating joint: its rotation.
        turns: Vec<(usize, UnitVector, f64)>,
    }

    impl Deviations for Wave {
        fn of(&self, position: usize) -> Deviation {
            let ([a, b, c], h) = (self.numbers[position].map(f64::abs), self.half_width);
            let curvature = b * h * h + c * h * h * h;
            Deviation {
                velocity: self.numbers[position][0],
                most: a * h + curvature,
                curvature,
                tolerance: self.tolerance[position],
            }
        }

        fn half_width(&self) -> f64 {
            self.half_width
        }

        fn turn(&self, first: usize) -> Option<(UnitVector, f64)> {
            self.turns.iter().find(|(at, ..)| *at == first).map(|(_, axis, angle)| (*axis, *angle))
        }
    }

    impl Wave {
        fn random(random: &mut Random, joints: &[ChainJoint], count: usize) -> Self {
            let middle = random_positions(random, joints, count);
            let size = 10f64.powf(random.within(1.0) - 1.0);
            let bend = if random.within(1.0) > 0.0 { size } else { 0.0 };
            let loose = if random.within(1.0) > 0.0 { 0.1 * size } else { 0.0 };
            let mut wave = Self {
                numbers: middle
                    .iter()
                    .map(|_| [random.within(size), random.within(bend), random.within(bend)])
                    .collect(),
                tolerance: middle.iter().map(|_| random.within(loose).abs()).collect(),
                middle,
                half_width: random.within(0.5).abs() + 0.01,
                turns: Vec::new(),
            };
            for joint in joints {
                if let Motion::Floating(first) = joint.motion {
                    wave.turns.push((first, random.direction(), random.within(2.0 * size)));
                    wave.numbers[first + 3..first + 7].fill([0.0; 3]);
                    wave.tolerance[first..first + 7].fill(0.0);
                }
            }
            wave
        }

        /// A random value of the positions at t, within the tolerances.
        fn at(&self, t: f64, random: &mut Random) -> Vec<f64> {
            let along = |(q, [a, b, c]): (&f64, &[f64; 3])| q + t * (a + t * (b + t * c));
            let mut positions: Vec<f64> = self.middle.iter().zip(&self.numbers).map(along).collect();
            for (position, tolerance) in positions.iter_mut().zip(&self.tolerance) {
                *position += random.within(*tolerance);
            }
            for (first, axis, angle) in &self.turns {
                let q = &self.middle[first + 3..first + 7];
                let from = clearance_geometry::math::Rotation::from_quaternion(nalgebra::Quaternion::new(
                    q[3], q[0], q[1], q[2],
                ));
                let turned =
                    (clearance_geometry::math::Rotation::from_axis_angle(axis, angle * t) * from).coords;
                positions[first + 3..first + 7].copy_from_slice(turned.as_slice());
            }
            positions
        }
    }

    fn follows_a_quaternion(joint: &ChainJoint, joints: &[ChainJoint]) -> bool {
        let Motion::Revolute(_, source) = joint.motion else { return false };
        let holds = |first: usize| (first + 3..first + 7).contains(&source.index);
        joints.iter().any(|other| matches!(other.motion, Motion::Floating(first) if holds(first)))
    }

    fn approach(chain: &Chain, bodies: [usize; 2], capsules: &[Reach; 2], wave: &Wave) -> MotionBound {
        let ways = chain.paths_to_root();
        let common = ways.common_depths(bodies[0])[bodies[1]];
        let between = ways.between(bodies, bodies.map(|body| ways.depth(body) - common));
        let mut seen = vec![PlacedFrame::IDENTITY; chain.body_count()];
        let level = clearance_geometry::simd::Level::new();
        clearance_geometry::simd::dispatch!(level, simd => {
            chain.frames_between(simd, &between, &wave.middle, &mut seen);
        });
        let reaches = [0, 1].map(|i| Reach {
            ends: capsules[i].ends.map(|p| Vector::from(seen[bodies[i]].frame().point(<[f64; 3]>::from(p)))),
            radius: capsules[i].radius,
        });
        let sides = [0, 1].map(|i| chain.side_motion(between.side(i), &reaches[i], &seen, wave));
        MotionBound::new(&sides, &reaches, wave.half_width, 10.0)
    }

    fn point_in(capsule: &Reach, random: &mut Random) -> Vector {
        let [p, q] = capsule.ends;
        p + (q - p) * (0.5 + random.within(0.5)) + random.direction().into_inner() * capsule.radius
    }

    /// No two points of two capsules approach by more than the bound, in any part of the interval; and the bound is nearly reached.
    #[test]
    fn no_points_come_nearer_than_the_bound() {
        let mut random = Random::new(4711);
        let mut tightest: f64 = 0.0;
        for _ in 0..1200 {
            let (joints, count, _) = random_tree(&mut random, 8);
            // no robot joint mimics a component of a quaternion
            if joints.iter().any(|joint| follows_a_quaternion(joint, &joints)) {
                continue;
            }
            let links = joints.len() + 1;
            let chain = Chain::compile(0, &joints, &vec![true; links]);
            let wave = Wave::random(&mut random, &joints, count);
            let body = |random: &mut Random| random.below(chain.body_count());
            let bodies = [body(&mut random), body(&mut random)];
            let capsules = [0, 1].map(|_| Reach {
                ends: [0, 1].map(|_| random.direction().into_inner() * random.within(0.4)),
                radius: random.within(0.2).abs(),
            });
            let approach = approach(&chain, bodies, &capsules, &wave);
            let middle = frames(&chain, &wave.middle);
            for _ in 0..30 {
                let share = random.within(1.0);
                let there = frames(&chain, &wave.at(share * wave.half_width, &mut random));
                let [x, y] = [0, 1].map(|i| point_in(&capsules[i], &mut random));
                let apart = |f: &[Frame<f64>]| {
                    let [x, y] =
                        [(0, x), (1, y)].map(|(i, p)| Vector::from(f[bodies[i]].point(<[f64; 3]>::from(p))));
                    (x - y).norm()
                };
                let nearer = apart(&middle) - apart(&there);
                let bound = approach.within(share.abs());
                assert!(nearer <= bound + 1e-12, "{nearer} > {bound} at {share}");
                tightest = tightest.greater(nearer / bound);
                let part = approach.share(bound);
                assert!(part >= 1.0 || approach.within(part) <= bound, "a share is proven by what it needs");
            }
        }
        assert!(tightest > 0.9, "some bound is nearly reached: {tightest}");
    }
}
