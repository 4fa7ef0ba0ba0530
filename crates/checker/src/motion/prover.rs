//! Proves pairs of one motion free in intervals, and collects open intervals and contacts.
//!
//! A pair that level 0 leaves open in an interval is evaluated in the middle. Its distance proves a part of the
//! interval around the middle free; the remainders on either side are evaluated next (two-sided conservative
//! advancement; Schwarzer, Saha & Latombe 2005 bisect). The hierarchies are searched only where capsules do not
//! suffice, and only where the motion is small enough for the result to be useful.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, Point};
use clearance_motion::Proof;
use clearance_proximity as query;
use clearance_proximity::{Effort, Scratch};

use super::checked_motion::{CheckedMotion, PlacedPair, PoseScratch};
use super::interval_midpoint::IntervalMidpoint;
use super::level_zero::{LevelZero, NearPair};
use super::motion_report::{MotionOptions, MotionVerdict, UndecidedReason};
use super::motion_scratch::{MotionWorkspace, PairInterval};
use crate::pairs::PosedPair;
use crate::state::ContactSearch;

/// Motion (m) within an interval above which the hierarchies are not searched: the result would rarely prove anything.
const WORTH_SEARCHING: f64 = 0.04;

/// Relative tolerance of a distance: leaving a small part unproven costs less than an exact distance.
const DISTANCE_TOLERANCE: f64 = 0.15;

/// Smallest fraction of an interval that becomes an interval of its own.
const LEAST_SHARE: f64 = 0.15;

/// Motion (m) within an interval below which it is not split further: about where contact and its absence cannot be
/// distinguished.
const FLOOR: f64 = 4e-9;

/// For a widening motion: an interval that is short relative to the time before it need not be split.
const SHORT_SHARE: f64 = 0.03;

/// For obstacles that may move: intervals that end before this t are not split for a robot at rest.
const LEAST_END: f64 = 1e-3;

/// Number of evaluations between two reads of the clock.
const EVALUATIONS_PER_CLOCK_READ: u64 = 16;

/// Number of evaluations spent on a pair nearer than the tolerance, to try to decide it.
const MOST_BELOW_TOLERANCE: u32 = 2000;

/// An interval that stays undecided.
#[derive(Clone, Copy, Debug)]
struct OpenInterval {
    interval: PairInterval,
    distance: [f64; 2],
    reason: UndecidedReason,
}

/// A pair that touches.
#[derive(Clone, Copy, Debug)]
struct PairContact {
    pair: usize,
    t: f64,
    /// A common point (root frame).
    point: Point,
}

/// Result of one evaluation of a pair in an interval.
enum Evaluation {
    /// The pair touches at a point (root frame); the second value is its motion (m) in the whole interval.
    Contact(Point, f64),
    /// A part of the interval around its middle is free: its fraction, and the bounds that prove it.
    Proven { share: f64, lower: f64, bound: f64 },
    /// Undecided: bounds on the distance, and the largest motion of the pair.
    Open { distance: [f64; 2], motion: f64 },
}

/// The check of one motion, with its results so far.
pub struct Prover<'a, 'w> {
    motion: CheckedMotion<'a>,
    options: &'a MotionOptions,
    workspace: &'a mut MotionWorkspace<'w>,
    /// All of the motion before this time has been searched.
    searched_until: f64,
    /// Nothing after this time matters: a collision there is known.
    cutoff: f64,
    contact: Option<PairContact>,
    /// The earliest undecided interval, and the end of the last one.
    open: Option<OpenInterval>,
    open_until: f64,
    /// Evaluations that are left for pairs nearer than the tolerance.
    below_tolerance_left: u32,
    evaluations: u64,
    /// The proofs, if they are to be kept.
    proofs: Option<Vec<Proof>>,
    /// True if intervals too long for a distance to be useful are still tested for contact in the middle.
    seeks_contacts: bool,
    stopped: Option<UndecidedReason>,
}

impl<'a, 'w> Prover<'a, 'w> {
    /// `keep_proofs` collects the proofs.
    pub fn new(
        motion: CheckedMotion<'a>,
        options: &'a MotionOptions,
        workspace: &'a mut MotionWorkspace<'w>,
        keep_proofs: bool,
    ) -> Self {
        let positions = motion.segment.position_count();
        workspace.motion.positions.resize(positions, 0.0);
        workspace.motion.level_zero.resize(positions);
        workspace.motion.stack.clear();
        Self {
            motion,
            options,
            workspace,
            searched_until: 0.0,
            cutoff: f64::INFINITY,
            contact: None,
            open: None,
            open_until: 0.0,
            below_tolerance_left: MOST_BELOW_TOLERANCE,
            evaluations: 0,
            proofs: keep_proofs.then(Vec::new),
            seeks_contacts: false,
            stopped: None,
        }
    }

    /// From now on, tests for contact wherever capsules overlap in the middle of an interval.
    pub fn seek_contacts(&mut self) {
        self.seeks_contacts = true;
    }

    pub fn motion(&self) -> CheckedMotion<'a> {
        self.motion
    }

    pub fn options(&self) -> &'a MotionOptions {
        self.options
    }

    /// Level 0 of the motion.
    pub fn level_zero(&mut self) -> LevelZero<'_> {
        let MotionWorkspace { robot, obstacles, scratch, motion, .. } = &mut *self.workspace;
        let broad_phase = &mut obstacles.broad_phase;
        let margins = [self.motion.margin; 2];
        LevelZero {
            motion: self.motion,
            margins,
            robot,
            broad_phase,
            scratch,
            memory: &mut motion.level_zero,
        }
    }

    /// Pairs that level 0 left open.
    pub fn near(&self) -> &[NearPair] {
        self.workspace.motion.level_zero.near()
    }

    /// Intervals that the last evaluation left open, the earliest last.
    pub fn stack(&mut self) -> &mut Vec<PairInterval> {
        &mut self.workspace.motion.stack
    }

    pub fn keeps_proofs(&self) -> bool {
        self.proofs.is_some()
    }

    /// True if the check was stopped by the deadline, the budget or another thread.
    pub fn is_stopped(&self) -> bool {
        self.stopped.is_some()
    }

    pub fn has_contact(&self) -> bool {
        self.contact.is_some()
    }

    /// False once the whole motion cannot be proven free any more.
    pub fn finds_free(&self) -> bool {
        self.contact.is_none() && self.open.is_none() && self.stopped.is_none()
    }

    /// Nothing after this time matters: a collision there is known.
    pub fn cutoff(&self) -> f64 {
        self.cutoff
    }

    /// Records that all of the motion before this time has been searched.
    pub fn set_searched_until(&mut self, t: f64) {
        self.searched_until = t;
    }

    /// Number of evaluations so far, and the proofs that were kept.
    pub fn finish(self) -> (u64, Vec<Proof>) {
        (self.evaluations, self.proofs.unwrap_or_default())
    }

    /// If no proof covers the start or the end of a motion, it may collide there.
    pub fn test_ends(&mut self) {
        let Some(open) = self.open.filter(|_| self.stopped.is_none()) else { return };
        let pairs = [Some(open.interval.pair), self.contact.map(|contact| contact.pair)];
        for pair in pairs.into_iter().flatten() {
            let collides_at_start = open.interval.from == 0.0 && self.touches(pair, 0.0);
            if collides_at_start
                || (self.contact.is_none() && open.interval.to == 1.0 && self.touches(pair, 1.0))
            {
                return;
            }
        }
    }

    /// True if a pair touches at t; the contact is recorded.
    pub fn touches(&mut self, index: usize, t: f64) -> bool {
        let MotionWorkspace { robot, scratch, motion, .. } = &mut *self.workspace;
        let mut poses = PoseScratch {
            frames: robot.frames_mut(),
            positions: &mut motion.positions,
            level: scratch.level(),
        };
        let PlacedPair { pair, .. } = self.motion.placed_pair(index, t, &mut poses);
        self.evaluations += 1;
        let Some(point) = common_point(&pair, scratch) else { return false };
        self.cutoff = t;
        let point = self.point_in_root(&pair, &point, t);
        self.contact = Some(PairContact { pair: index, t, point });
        true
    }

    /// True if any pair touches at t, as in a query on that state; `None` if obstacles move. Overwrites the pairs that
    /// level 0 left open.
    pub fn collides_at(&mut self, t: f64) -> Option<bool> {
        let CheckedMotion { pairs, segment, .. } = self.motion;
        if !segment.obstacles().is_empty() {
            return None;
        }
        let MotionWorkspace { robot, priority, obstacles, scratch, motion, .. } = &mut *self.workspace;
        segment.positions_at(t, &mut motion.positions);
        let mut search = ContactSearch { pairs, robot, priority, obstacles, scratch, start: None };
        Some(search.any_contact_at(&motion.positions))
    }

    /// Evaluates a pair until nothing of the interval before the cutoff is left, the earliest part first.
    pub fn search_interval(&mut self, interval: PairInterval) {
        self.stack().clear();
        self.stack().push(interval);
        while let Some(mut interval) = self.stack().pop() {
            if interval.from >= self.cutoff {
                continue;
            }
            interval.to = interval.to.lesser(self.cutoff);
            if let Some(reason) = self.stopped {
                self.leave_open(interval, [0.0, f64::INFINITY], reason);
                continue;
            }
            self.evaluate_interval(interval);
        }
    }

    /// Evaluates an interval; the remainders are pushed on the stack, the earlier one on top.
    pub fn evaluate_interval(&mut self, interval: PairInterval) {
        let PairInterval { pair, from, to } = interval;
        let (middle, half_width) = (0.5 * (from + to), 0.5 * (to - from));
        let cut = |from: f64, to: f64| PairInterval { pair, from, to };
        match self.evaluate_midpoint(interval, middle, half_width) {
            Evaluation::Contact(point, motion) => {
                self.cutoff = middle;
                self.contact = Some(PairContact { pair, t: middle, point });
                if motion <= self.tolerance() {
                    self.leave_open(cut(from, middle), [0.0; 2], UndecidedReason::Tolerance);
                } else {
                    self.stack().push(cut(from, middle));
                }
            }
            Evaluation::Proven { share, lower, bound } if share >= 1.0 => {
                self.keep_proof(interval, lower, bound);
            }
            Evaluation::Proven { share, lower, bound } => {
                let (low, high) = (middle - share * half_width, middle + share * half_width);
                self.keep_proof(cut(low, high), lower, bound);
                for rest in [cut(high, to), cut(from, low)] {
                    if rest.from < rest.to {
                        self.stack().push(rest);
                    }
                }
            }
            Evaluation::Open { distance, motion } => self.split(interval, distance, motion),
        }
    }

    /// Splits an interval in two, unless this is useless.
    fn split(&mut self, interval: PairInterval, distance: [f64; 2], motion: f64) {
        let PairInterval { pair, from, to } = interval;
        let middle = 0.5 * (from + to);
        let cannot_be_split = !(from < middle && middle < to);
        let segment = self.motion.segment;
        if !motion.is_finite() {
            return self.leave_open(interval, distance, UndecidedReason::Overflow);
        }
        let is_short = to - from <= SHORT_SHARE * to;
        // what is not known about an obstacle is less in the first half, even if the robot stands
        let grows = self.motion.uncertainty(pair, to) > 0.0 && to > LEAST_END && !is_short;
        let is_still = motion <= self.tolerance() && !grows;
        let is_short = segment.widens() && is_short;
        if is_still || cannot_be_split || is_short {
            if segment.is_loose() {
                self.leave_open(interval, distance, UndecidedReason::Tube);
                self.cutoff = self.cutoff.lesser(from);
                return;
            }
            if to >= self.cutoff || motion <= FLOOR || self.below_tolerance_left == 0 || cannot_be_split {
                return self.leave_open(interval, distance, UndecidedReason::Tolerance);
            }
            self.below_tolerance_left -= 1;
        }
        self.stack().push(PairInterval { pair, from: middle, to });
        self.stack().push(PairInterval { pair, from, to: middle });
    }

    /// Motion (m) in an interval below which it may stay undecided.
    fn tolerance(&self) -> f64 {
        self.options.tolerance.greater(FLOOR)
    }

    /// Records an interval as undecided, with bounds (m) on the pair's distance.
    pub fn leave_open(&mut self, interval: PairInterval, distance: [f64; 2], reason: UndecidedReason) {
        self.open_until = self.open_until.greater(interval.to);
        if self.open.is_none_or(|open| interval.from < open.interval.from) {
            self.open = Some(OpenInterval { interval, distance, reason });
        }
    }

    fn keep_proof(&mut self, PairInterval { pair, from, to }: PairInterval, lower: f64, bound: f64) {
        if let Some(proofs) = &mut self.proofs {
            proofs.push(Proof(pair, from, to, lower, bound));
        }
    }

    /// Evaluates a pair in the middle of an interval.
    fn evaluate_midpoint(&mut self, interval: PairInterval, middle: f64, half_width: f64) -> Evaluation {
        self.evaluations += 1;
        if self.is_over() {
            return Evaluation::Open { distance: [0.0, f64::INFINITY], motion: 0.0 };
        }
        let MotionWorkspace { robot, scratch, motion, .. } = &mut *self.workspace;
        let mut poses = PoseScratch {
            frames: robot.frames_mut(),
            positions: &mut motion.positions,
            level: scratch.level(),
        };
        let midpoint = IntervalMidpoint::new(self.motion, interval.pair, [middle, half_width], &mut poses);
        scratch.work.volume_tests += 1;
        let IntervalMidpoint { pair, approach, lower } = &midpoint;
        // the padding includes the margin
        let (padding, margin) = (pair.info.padding, self.motion.margin);
        let without_padding = |distance: f64| (distance - padding + margin).greater(0.0);
        let (bound, motion) = (approach.within(1.0), approach.motion());
        if lower - padding > bound {
            return Evaluation::Proven { share: 1.0, lower: *lower, bound };
        }
        let unknown = [without_padding(*lower), f64::INFINITY];
        if motion > WORTH_SEARCHING {
            if self.seeks_contacts
                && *lower <= padding
                && let Some(point) = common_point(pair, scratch)
            {
                return Evaluation::Contact(self.point_in_root(pair, &point, middle), motion);
            }
            return proven_by(&midpoint, *lower).unwrap_or(Evaluation::Open { distance: unknown, motion });
        }
        // if padding and tolerances use up most of a distance, a relative tolerance is too large
        let effort = if padding > 0.0 || self.motion.segment.is_loose() {
            Effort { absolute_tolerance: DISTANCE_TOLERANCE * motion, ..Effort::default() }
        } else {
            Effort { relative_tolerance: DISTANCE_TOLERANCE, ..Effort::default() }
        };
        let limit = bound + padding + CONTACT_DISTANCE;
        let found = pair.separation_bounds(limit, &effort, scratch);
        let Some(near) = found.upper else { return Evaluation::Proven { share: 1.0, lower: limit, bound } };
        if near.distance <= padding.greater(CONTACT_DISTANCE) {
            let point = self.point_in_root(pair, &near.witness_points[0], middle);
            return Evaluation::Contact(point, motion);
        }
        let distance = [without_padding(found.lower), near.distance - padding + margin];
        proven_by(&midpoint, found.lower).unwrap_or(Evaluation::Open { distance, motion })
    }

    /// True if the check is to stop here.
    fn is_over(&mut self) -> bool {
        if self.stopped.is_none() {
            if self.evaluations > self.options.budget {
                self.stopped = Some(UndecidedReason::Budget);
            } else if self.evaluations % EVALUATIONS_PER_CLOCK_READ == 1 {
                self.stopped = self.options.stopped_by();
            }
        }
        self.stopped.is_some()
    }

    /// Transforms a point from the frame of a pair's first body to the root frame.
    fn point_in_root(&self, pair: &PosedPair, point: &Point, t: f64) -> Point {
        let CheckedMotion { pairs, segment, .. } = self.motion;
        pairs.robot().point_in_root(pair.info.bodies.0, point, &segment.at(t))
    }

    /// The result so far.
    pub fn verdict(&self) -> MotionVerdict {
        let ids = |pair: usize| self.motion.pairs.info(pair).ids;
        let open = self.open.filter(|open| open.interval.from <= self.cutoff);
        let free_until = open.map_or(self.cutoff, |open| open.interval.from);
        // a check that stops early has not searched everything before `free_until`
        let free_until =
            if self.stopped.is_some() { free_until.lesser(self.searched_until) } else { free_until };
        if let Some(PairContact { pair, t, point }) = self.contact {
            let t = [free_until.lesser(t), t];
            return MotionVerdict::Contact { t, pair: ids(pair), witness: Some(point) };
        }
        match (open, self.stopped) {
            (None, None) => MotionVerdict::Free,
            (open, Some(reason)) => MotionVerdict::Undecided {
                t: [free_until.lesser(1.0), 1.0],
                pair: open.map(|open| ids(open.interval.pair)),
                distance: open.map_or([0.0, f64::INFINITY], |open| open.distance),
                reason,
            },
            (Some(open), None) => MotionVerdict::Undecided {
                // a possible contact within the tracking tolerance ends the search
                t: [
                    open.interval.from,
                    if open.reason == UndecidedReason::Tube { 1.0 } else { self.open_until },
                ],
                pair: Some(ids(open.interval.pair)),
                distance: open.distance,
                reason: open.reason,
            },
        }
    }
}

/// A point of the first body (in its frame) where a pair touches.
fn common_point(pair: &PosedPair, scratch: &mut Scratch) -> Option<Point> {
    let (a, b) = pair.bodies;
    let found = query::within_margin(a, b, pair.pose_ab, pair.info.padding, scratch)?;
    Some(found.witness_points[0])
}

/// The interval that a distance (m) proves free, if it is long enough.
fn proven_by(midpoint: &IntervalMidpoint, lower: f64) -> Option<Evaluation> {
    let share = midpoint.approach.share(lower - midpoint.pair.info.padding);
    let bound = || midpoint.approach.within(share);
    (share >= LEAST_SHARE).then(|| Evaluation::Proven { share, lower, bound: bound() })
}
