//! One pair in the middle of an interval: its distance, and a bound on the decrease of that distance towards either end.

use clearance_geometry::constants::MOTION_SLACK;
use clearance_geometry::math::{Extremes, MatrixPose, UnitVector, Vector};
use clearance_geometry::simd::dispatch;
use clearance_motion::{MotionSegment, MovingObstacle};
use clearance_proximity::Scratch;
use clearance_robot::{Deviation, Deviations, MotionBound, PlacedFrame, Reach, SideMotion};

use crate::bodies::RobotBody;
use crate::collision_checker::CollisionChecker;
use crate::nearby::capsule_bound;
use crate::numbers::PairNumber;
use crate::pair::Pair;
use clearance_scene::BodyId;

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

/// Deviation of joint positions within an interval.
pub fn of_whole_interval(segment: &MotionSegment, [from, to]: [f64; 2]) -> impl Deviations + '_ {
    Around { segment, middle: 0.5 * (from + to), half_width: 0.5 * (to - from) }
}

/// A pair in the middle of an interval.
pub struct IntervalMidpoint<'c> {
    pub pair: Pair<'c>,
    pub approach: MotionBound,
    /// Lower bound (m) on the bodies' distance, padding not subtracted, from their capsules.
    pub lower: f64,
}

/// A pair placed at one time, with the bounding volumes of its bodies.
pub struct PlacedPair<'c> {
    pub pair: Pair<'c>,
    reaches: [Reach; 2],
}

impl CollisionChecker {
    /// Pair number `index` at t.
    pub(super) fn placed_pair<'c>(
        &'c self,
        index: usize,
        segment: &MotionSegment,
        t: f64,
        frames: &mut [PlacedFrame],
        positions: &mut [f64],
        scratch: &Scratch,
    ) -> PlacedPair<'c> {
        let (info, between) = (self.info(index), self.between(index));
        segment.positions_at(t, positions);
        dispatch!(scratch.level(), simd => self.chain.frames_between(simd, &between, positions, frames));
        let a = &self.robot_bodies[info.bodies.0];
        let pose_ra = MatrixPose::from(&frames[a.body]);
        let (solid, pose_rb, reach) = if let BodyId::Obstacle(_) = info.ids.1 {
            let b = self.obstacles.at(info.bodies.1);
            match self.mover(segment, index) {
                Some(mover) => {
                    let pose = MatrixPose::from(&(mover.displacement(t) * b.pose()));
                    (&b.solid, pose, b.reach_at(&pose))
                }
                None => (&b.solid, b.pose_ro, b.reach),
            }
        } else {
            let b = &self.robot_bodies[info.bodies.1];
            let pose = MatrixPose::from(&frames[b.body]);
            (&b.solid, pose, b.reach_at(&pose))
        };
        PlacedPair {
            reaches: [a.reach_at(&pose_ra), reach],
            pair: Pair { info, bodies: (&a.solid, solid), pose_ra, pose_ab: pose_ra.relative(&pose_rb) },
        }
    }

    /// Pair number `index` at `middle`, with a bound on its motion within `half_width` of it.
    pub(super) fn moment<'c>(
        &'c self,
        index: usize,
        segment: &MotionSegment,
        (middle, half_width): (f64, f64),
        frames: &mut [PlacedFrame],
        positions: &mut [f64],
        scratch: &Scratch,
    ) -> IntervalMidpoint<'c> {
        let PlacedPair { pair, reaches } =
            self.placed_pair(index, segment, middle, frames, positions, scratch);
        let around = Around { segment, middle, half_width };
        let between = self.between(index);
        let mover = self.mover(segment, index);
        let lower = if reaches.iter().all(|reach| reach.radius.is_finite()) {
            capsule_bound(&reaches)
        } else {
            pair.bodies.0.sphere_bound(pair.bodies.1, &pair.pose_ab)
        };
        let reaches = moving_reaches(reaches);
        let side = |i: usize| self.chain.side_motion(between.side(i), &reaches[i], frames, &around);
        let second = match mover {
            Some(mover) => of_obstacle(mover, &reaches[1], &around),
            None => side(1),
        };
        let approach = MotionBound::new(&[side(0), second], &reaches, half_width, segment.size());
        IntervalMidpoint { pair, approach, lower }
    }

    /// The motion of the pair's obstacle, if it moves.
    fn mover<'s>(&self, segment: &'s MotionSegment, index: usize) -> Option<&'s MovingObstacle> {
        if segment.obstacles().is_empty() {
            return None;
        }
        let PairNumber::WithObstacle { place, .. } = self.number(index) else { return None };
        let name = self.obstacles.at(place).name();
        segment.obstacles().iter().find(|mover| mover.name == name)
    }

    /// The places of moving obstacles, ascending.
    pub(super) fn moving_places(&self, segment: &MotionSegment) -> Vec<usize> {
        let ids = segment.obstacles().iter().filter_map(|mover| self.world().id(&mover.name));
        let mut places: Vec<_> = ids.map(|id| id.0 as usize).collect();
        places.sort_unstable();
        places
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
fn of_obstacle(mover: &MovingObstacle, reach: &Reach, around: &Around) -> SideMotion {
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

impl RobotBody {
    /// Its capsule, transformed to the root frame.
    pub fn reach_at(&self, pose: &MatrixPose) -> Reach {
        self.capsule.reach_at(pose)
    }

    /// Radius (m) around its body's origin that contains it.
    pub fn reach(&self) -> f64 {
        let ends = [self.capsule.a, self.capsule.b].map(|p| p.coords.norm());
        (ends[0].greater(ends[1]) + self.capsule.radius) * (1.0 + MOTION_SLACK) + MOTION_SLACK
    }
}
