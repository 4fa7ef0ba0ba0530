//! Pair in the middle of an interval: its distance, and a bound on the decrease of that distance towards either end.

use clearance_geometry::math::{UnitVector, Vector};
use clearance_motion::{MotionSegment, MovingObstacle};
use clearance_robot::{Deviation, Deviations, MotionBound, Reach, SideMotion};

use super::checked_motion::{CheckedMotion, PlacedPair, PoseScratch};
use crate::capsules::capsule_distance_bound;
use crate::pairs::PosedPair;

/// Joint positions of a segment around a time.
struct Around<'s> {
    segment: &'s MotionSegment,
    middle: f64,
    half_width: f64,
}

impl Deviations for Around<'_> {
    #[inline]
    fn of(&self, position: usize) -> Deviation {
        self.segment.deviation(position, self.middle, self.half_width)
    }

    fn half_width(&self) -> f64 {
        self.half_width
    }

    fn turn(&self, first: usize) -> Option<(UnitVector, f64)> {
        self.segment.turn_of(first)
    }
}

/// Deviation of joint positions within an interval of t from its middle.
pub fn deviations_within(segment: &MotionSegment, [from, to]: [f64; 2]) -> impl Deviations + '_ {
    Around { segment, middle: 0.5 * (from + to), half_width: 0.5 * (to - from) }
}

/// A pair in the middle of an interval.
pub struct IntervalMidpoint<'c> {
    pub pair: PosedPair<'c>,
    pub approach: MotionBound,
    /// Lower bound (m) on the bodies' distance, padding not subtracted, from their capsules.
    pub lower: f64,
}

impl<'c> IntervalMidpoint<'c> {
    /// A pair at `middle`, with a bound on its motion within `half_width` of it.
    pub fn new(
        motion: CheckedMotion<'c>,
        index: usize,
        [middle, half_width]: [f64; 2],
        poses: &mut PoseScratch,
    ) -> Self {
        let PlacedPair { pair, reaches } = motion.placed_pair(index, middle, poses);
        let around = Around { segment: motion.segment, middle, half_width };
        let (chain, path) = (motion.pairs.robot().chain(), motion.pairs.path_between(index));
        let mover = motion.mover(index);
        let lower = if reaches.iter().all(|reach| reach.radius.is_finite()) {
            capsule_distance_bound(&reaches)
        } else {
            pair.bodies.0.sphere_bound(pair.bodies.1, &pair.pose_ab)
        };
        let reaches = moving_reaches(reaches);
        let side = |i: usize| chain.side_motion(path.side(i), &reaches[i], poses.frames, &around);
        let mut second = match mover {
            Some(mover) => motion_of_obstacle(mover, &reaches[1], &around),
            None => side(1),
        };
        // what is not known grows with time: its end is at the end of the interval
        second.tolerance += motion.uncertainty(index, middle + half_width);
        let approach = MotionBound::new(&[side(0), second], &reaches, half_width, motion.segment.size());
        Self { pair, approach, lower }
    }
}

/// Regions in which points of moving bodies have to be bounded. An infinite body takes the region of the other body.
fn moving_reaches([a, b]: [Reach; 2]) -> [Reach; 2] {
    match (a.radius.is_finite(), b.radius.is_finite()) {
        (true, false) => [a, a],
        (false, true) => [b, b],
        _ => [a, b],
    }
}

/// Motion of an obstacle: a rotation about its centre, and a translation of the centre.
fn motion_of_obstacle(mover: &MovingObstacle, reach: &Reach, around: &Around) -> SideMotion {
    let mut motion = SideMotion::default();
    let (linear, angular) = (Vector::from(mover.linear), Vector::from(mover.angular));
    let centre = Vector::from(mover.centre) + linear * around.middle;
    let deviation = |velocity: f64| Deviation {
        velocity,
        most: around.half_width * velocity.abs(),
        ..Deviation::default()
    };
    if let Some(axis) = UnitVector::try_new(angular, 0.0) {
        motion.turn(&axis, &centre, &deviation(angular.norm()), reach);
    }
    motion.shift(linear, &deviation(linear.norm()));
    motion
}
