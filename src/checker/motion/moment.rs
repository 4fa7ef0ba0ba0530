//! One pair in the middle of an interval: how far apart, and how much nearer it can come on the way to either end.

use super::MotionScratch;
use crate::checker::bodies::Rider;
use crate::checker::capsules::LinkCapsule;
use crate::checker::collision_checker::CollisionChecker;
use crate::checker::pair::Pair;
use crate::math::{MatrixPose, Point, UnitVector, Vector};
use crate::motion::{MotionSegment, MovingObstacle};
use crate::query::Scratch;
use crate::robot::{Deviation, Deviations, Frame, Reach, SideMotion};
use crate::simd::dispatch_lean;

/// Room (m) for the rounding of kinematics, bounds and distances: 1e-14 m a metre, many times over.
pub const SLACK: f64 = 1e-9;

/// The positions of a segment around a moment.
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

/// How much nearer a pair can come within an interval, and parts of it around its middle.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// W, without tolerances.
    way: f64,
    /// Half the width times the relative speed.
    speed: f64,
    /// Remainders of the bound of first order.
    bent: f64,
    /// What tolerances let it be nearer, in both bounds.
    off: f64,
    /// Remainders that do not shrink with the interval, since tolerances do not.
    stiff: f64,
}

impl Approach {
    fn new(sides: &[SideMotion; 2], reaches: &[Reach; 2], half_width: f64) -> Self {
        let [a, b] = sides;
        let (velocity, angular) = (b.velocity - a.velocity, b.angular - a.angular);
        let speed =
            reaches.iter().map(|reach| reach.speed(&velocity, &angular)).fold(f64::INFINITY, f64::min);
        let off = a.off + b.off;
        let remainder = a.remainder + b.remainder;
        let (bent, stiff) = if off > 0.0 { (0.0, remainder) } else { (remainder, 0.0) };
        Self { way: a.way + b.way, speed: half_width * speed, bent: bent + a.bent + b.bent, off, stiff }
    }

    /// The most (m) that the pair comes nearer in the part of the interval that has this share of its width.
    pub fn within(&self, share: f64) -> f64 {
        let first = share * (self.speed + share * self.bent) + self.stiff;
        ((share * self.way).min(first) + self.off) * (1.0 + SLACK) + SLACK
    }

    /// The share of the interval in which the pair comes nearer by less than `room` (m).
    pub fn share(&self, room: f64) -> f64 {
        let room = room * (1.0 - 2.0 * SLACK) - 2.0 * SLACK - self.off;
        if room <= 0.0 {
            return 0.0;
        }
        let of_way = room / self.way;
        let rest = room - self.stiff;
        // the positive root of bent s² + speed s = rest, stable for small bent
        let root = (self.speed * self.speed + 4.0 * self.bent * rest).sqrt();
        let of_first = if rest > 0.0 { 2.0 * rest / (self.speed + root) } else { 0.0 };
        // where nothing moves, all of it; and no number proves nothing
        let share = if self.way > 0.0 { of_way.max(of_first) } else { 1.0 };
        if share >= 0.0 { share.min(1.0) } else { 0.0 }
    }
}

/// A pair in the middle of an interval.
pub struct Moment<'c> {
    pub pair: Pair<'c>,
    pub approach: Approach,
    /// A number (m) never larger than the bodies' distance, padding not taken off, by their capsules.
    pub lower: f64,
}

impl CollisionChecker {
    /// Pair number `index` at `middle`, and what it can do within `half_width` of it.
    pub(super) fn moment<'c>(
        &'c self,
        index: usize,
        segment: &MotionSegment,
        (middle, half_width): (f64, f64),
        frames: &mut [Frame<f64>],
        motion: &mut MotionScratch,
        scratch: &Scratch,
    ) -> Moment<'c> {
        let (info, between) = (&self.infos[index], &self.between[index]);
        let rider = |i: usize| self.riders[i].as_ref().expect("pairs name only bodies with geometry");
        let (a, b) = (rider(info.bodies.0), rider(info.bodies.1));
        segment.positions_at(middle, &mut motion.positions);
        let positions = &motion.positions;
        dispatch_lean!(scratch.level(), simd => self.chain.frames_between(simd, between, positions, frames));
        let around = Around { segment, middle, half_width };
        let mover = self.mover(segment, info.bodies.1);
        let (pose_ra, mut pose_rb) = (MatrixPose::from(&frames[a.body]), MatrixPose::from(&frames[b.body]));
        if let Some(mover) = mover {
            pose_rb = mover.matrix(middle);
        }
        let reaches = [a.reach_at(&pose_ra), b.reach_at(&pose_rb)];
        let side = |i: usize| self.chain.side_motion(between.side(i), &reaches[i], frames, &around);
        let second = mover.map_or_else(|| side(1), |mover| of_obstacle(mover, &reaches[1], &around));
        let approach = Approach::new(&[side(0), second], &reaches, half_width);
        let lower = capsule_bound(&reaches);
        Moment {
            pair: Pair { info, bodies: (&a.solid, &b.solid), pose_ra, pose_ab: pose_ra.relative(&pose_rb) },
            approach,
            lower,
        }
    }

    /// How a body moves, if it is an obstacle that does.
    pub(super) fn mover<'s>(&self, segment: &'s MotionSegment, body: usize) -> Option<&'s MovingObstacle> {
        if segment.obstacles().is_empty() {
            return None;
        }
        let obstacle = body.checked_sub(self.robot().links().len())?;
        let name = &self.world().obstacles()[obstacle].name;
        segment.obstacles().iter().find(|mover| mover.name == *name)
    }
}

/// How an obstacle moves: a turn about its centre, which shifts.
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

impl Rider {
    /// Its capsule, seen from outside.
    fn reach_at(&self, pose: &MatrixPose) -> Reach {
        let LinkCapsule { a, b, radius } = self.capsule;
        let seen = |p: Point| (pose * p).coords;
        Reach { ends: [seen(a), seen(b)], radius: radius * (1.0 + SLACK) + SLACK }
    }

    /// How far (m) it reaches from its body's origin.
    pub fn reach(&self) -> f64 {
        let ends = [self.capsule.a, self.capsule.b].map(|p| p.coords.norm());
        (ends[0].max(ends[1]) + self.capsule.radius) * (1.0 + SLACK) + SLACK
    }
}

/// A number (m) never larger than the distance of two capsules: that of their axes along the line between about nearest
/// points, as at level 0, but in f64.
fn capsule_bound([a, b]: &[Reach; 2]) -> f64 {
    let (c, u) = ((a.ends[0] + a.ends[1]) * 0.5, (a.ends[1] - a.ends[0]) * 0.5);
    let (d, v) = ((b.ends[0] + b.ends[1]) * 0.5, (b.ends[1] - b.ends[0]) * 0.5);
    let w = d - c;
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let over = |numerator: f64, denominator: f64| {
        if denominator > 0.0 { (numerator / denominator).clamp(-1.0, 1.0) } else { 0.0 }
    };
    let determinant = uu * vv - uv * uv;
    let s = if determinant > 1e-12 * uu * vv { over(uw * vv - uv * vw, determinant) } else { 0.0 };
    let t = over(uv * s - vw, vv);
    let s = over(uv * t + uw, uu);
    let n = w + v * t - u * s;
    let length = n.norm();
    if length > 0.0 {
        (n.dot(&w) - n.dot(&u).abs() - n.dot(&v).abs()) / length - a.radius - b.radius - SLACK
    } else {
        -a.radius - b.radius
    }
}
