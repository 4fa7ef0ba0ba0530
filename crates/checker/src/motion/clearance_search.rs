//! Search for the least distance along a motion: branch and bound on intervals of single pairs.
//!
//! A pair's distance in an interval is at least its distance in the middle minus the bound on its motion. The least
//! distance that was measured so far, minus the tolerance, is the *target*: where a lower bound exceeds the target, an
//! interval is done. Other intervals are divided, the one with the least lower bound first. The target only ever decreases,
//! so that everything that was done before stays done.
//!
//! Points of the pair that were near each other in another interval show how much the distance in the middle can prove at
//! most. If that is little, it is not measured, and the interval is divided into as many parts as it takes.
//!
//! 1. One state is measured, and then its nearest pair along the whole motion: the target is then near the result.
//! 2. Level 0 excludes the pairs whose capsules stay farther apart than the target.
//! 3. The other pairs are searched in the intervals that level 0 left open.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_proximity::{Effort, Separation};

use super::checked_motion::{CheckedMotion, PlacedPair, PoseScratch};
use super::interval_midpoint::IntervalMidpoint;
use super::least_bounds::{LeastBounds, NearestSoFar};
use super::level_zero::LevelZero;
use super::level_zero_intervals::{Intervals, is_beyond_level_zero, open_runs, screen_block};
use super::motion_clearance::MotionClearanceOptions;
use super::motion_report::UndecidedReason;
use super::motion_scratch::{BoundedInterval, MotionWorkspace, PairInterval};
use crate::collision_report::CollisionReport;
use crate::pair_kind::PairKind;
use crate::pairs::{NearPoints, PosedPair, RoughDistance, hardly_less_than};
use crate::question::Question;
use crate::state::{PairEvaluation, QueriedState, StateQuery};

/// Motion (m) within an interval above which the hierarchies are not searched, and its share of the target.
const WORTH_SEARCHING: [f64; 2] = [0.04, 0.5];

/// Tolerances of a distance: shares of the motion in the interval and of the tolerance of the result.
const DISTANCE_TOLERANCE: [f64; 2] = [0.05, 0.05];

/// Smallest fraction of an interval that becomes an interval of its own.
const LEAST_SHARE: f64 = 0.15;

/// Largest number of parts of equal length into which an interval is divided.
const MOST_PARTS: f64 = 8.0;

/// An interval in which the pair moves less than this share of the tolerance cannot be refined: the rest of its bound comes
/// from tracking tolerances or rounding.
const LEAST_MOTION: f64 = 0.05;

/// Largest number of intervals that wait for their evaluation (about 0.1 GB), besides one for each pair.
const MOST_WAITING: usize = 1 << 20;

/// Number of evaluations between two reads of the clock.
const EVALUATIONS_PER_CLOCK_READ: u64 = 16;

/// Progress of a search over all segments of a trajectory.
pub struct SearchProgress {
    /// Of self pairs, and of world pairs.
    pub least: [LeastBounds; 2],
    pub evaluations: u64,
    /// Why the search was stopped, or why parts could not be refined.
    pub unfinished: Option<UndecidedReason>,
    stopped: bool,
}

impl SearchProgress {
    pub fn new() -> Self {
        Self { least: [LeastBounds::new(); 2], evaluations: 0, unfinished: None, stopped: false }
    }

    /// Records that nothing is proven of what has not been searched.
    pub fn stop(&mut self, reason: UndecidedReason) {
        self.stopped = true;
        self.unfinished = Some(reason);
        self.least.iter_mut().for_each(|least| least.prove(0.0));
    }

    pub fn is_stopped(&self) -> bool {
        self.stopped
    }
}

/// Evaluation of an interval of one pair.
#[derive(Clone, Copy)]
struct IntervalBound {
    /// Lower bound (m) on the distance, padding subtracted, in the whole interval.
    lower: f64,
    /// Motion (m) of the pair in half of the interval.
    motion: f64,
    /// Allowed difference (m) of the bounds of the result.
    tolerance: f64,
    /// Fraction of the interval around its middle that is done.
    share: f64,
    /// The fraction that the exact distance in the middle could prove at most, as far as it is known.
    most_share: f64,
    /// Points of the pair that are near each other in the middle.
    near: Option<NearPoints>,
}

/// Bounds on the distance of a pair in the middle of an interval, without padding.
struct Middle {
    t: f64,
    /// Lower bound (m) on the distance.
    lower: f64,
    /// Points of the bodies.
    near: Option<Separation>,
}

/// Search along one segment.
pub struct ClearanceSearch<'p, 'a, 'w> {
    pub motion: CheckedMotion<'a>,
    pub options: &'a MotionClearanceOptions,
    pub workspace: &'p mut MotionWorkspace<'w>,
    pub progress: &'p mut SearchProgress,
    /// Index of the segment.
    pub segment: usize,
}

impl ClearanceSearch<'_, '_, '_> {
    /// Searches the whole segment.
    pub fn run(&mut self) {
        self.workspace.motion.positions.resize(self.motion.segment.position_count(), 0.0);
        self.workspace.motion.level_zero.resize(self.motion.segment.position_count());
        self.workspace.motion.queue.clear();
        let first = self.measure_middle();
        if self.progress.stopped {
            return;
        }
        for index in first.into_iter().flatten() {
            self.push(PairInterval { pair: index, from: 0.0, to: 1.0 });
        }
        self.search_queue();
        self.search_others(first);
        if self.progress.stopped {
            self.progress.least.iter_mut().for_each(|least| least.prove(0.0));
        }
        self.measure_nearest();
    }

    /// Measures the state in the middle; returns the nearest pairs, by kind.
    fn measure_middle(&mut self) -> [Option<usize>; 2] {
        if let Some(reason) = self.options.stopped_by() {
            self.progress.stop(reason);
            return [None; 2];
        }
        let CheckedMotion { pairs, segment, .. } = self.motion;
        let (q, effort, mut report) = (segment.at(0.5), Effort::default(), CollisionReport::default());
        let limit = PairKind::ALL.map(|kind| self.least(kind).upper().lesser(self.options.limit));
        let question = Question::SelfAndWorldDistance { limit: limit[0].greater(limit[1]) };
        let MotionWorkspace { robot, obstacles, scratch, candidates, distance, .. } = &mut *self.workspace;
        let broad_phase = &mut obstacles.broad_phase;
        let state = QueriedState { pairs, q: &q, robot, broad_phase, candidates, scratch, stream: None };
        let evaluation = PairEvaluation { state, effort: &effort, report: &mut report };
        StateQuery { evaluation, distance }.evaluate(question);
        PairKind::ALL.map(|kind| {
            // obstacles that move are elsewhere in this state
            let is_known = kind == PairKind::SelfPair || segment.obstacles().is_empty();
            let nearest = report.nearest_of(kind).filter(|_| is_known)?;
            let index = pairs.number_of((nearest.a, nearest.b))?;
            let found = NearestSoFar { segment: self.segment, t: 0.5, index, pair: *nearest, is_exact: true };
            self.least_mut(kind).offer(found);
            Some(index)
        })
    }

    /// Searches all pairs except those that were searched before.
    fn search_others(&mut self, searched: [Option<usize>; 2]) {
        let CheckedMotion { pairs, segment, .. } = self.motion;
        if is_beyond_level_zero(segment) || segment.widens() {
            for pair in pairs.numbers().filter(|pair| !searched.contains(&Some(*pair))) {
                self.push(PairInterval { pair, from: 0.0, to: 1.0 });
            }
            return self.search_queue();
        }
        let intervals = Intervals::of(&mut self.level_zero());
        for block in 0..intervals.blocks() {
            if self.progress.stopped {
                return;
            }
            if PairKind::ALL.iter().all(|kind| self.target(*kind) < 0.0) {
                break;
            }
            match intervals {
                Intervals::Whole => {
                    self.level_zero().screen_whole();
                    self.queue_runs(&[0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0], searched);
                }
                Intervals::Blocks(blocks) => {
                    let ends = screen_block(&mut self.level_zero(), block, blocks);
                    self.queue_runs(&ends, searched);
                }
            }
            self.search_queue();
        }
        // what level 0 excluded is at least as far apart as the last target
        for kind in PairKind::ALL {
            let target = self.target(kind);
            self.least_mut(kind).prove(target);
        }
    }

    /// Queues the intervals that level 0 left open.
    fn queue_runs(&mut self, ends: &[f64; 9], searched: [Option<usize>; 2]) {
        let scratch = &mut *self.workspace.motion;
        let open = open_runs(scratch.level_zero.near(), ends);
        let open = open.filter(|interval| !searched.contains(&Some(interval.pair)));
        scratch.queue.extend(open.map(|interval| BoundedInterval { lower: 0.0, interval, near: None }));
    }

    fn level_zero(&mut self) -> LevelZero<'_> {
        let margins = PairKind::ALL.map(|kind| self.target(kind).greater(0.0));
        let MotionWorkspace { robot, obstacles, scratch, motion, .. } = &mut *self.workspace;
        let broad_phase = &mut obstacles.broad_phase;
        LevelZero {
            motion: self.motion,
            margins,
            robot,
            broad_phase,
            scratch,
            memory: &mut motion.level_zero,
        }
    }

    /// Searches the queued intervals, and their parts, until all have reached the target.
    fn search_queue(&mut self) {
        while let Some(queued) = self.workspace.motion.queue.pop() {
            let kind = self.motion.pairs.kind(queued.interval.pair);
            if self.progress.stopped || queued.lower > self.target(kind) {
                self.least_mut(kind).prove(queued.lower);
            } else {
                self.evaluate(&queued, kind);
            }
        }
    }

    /// Evaluates an interval, and queues the parts of it that are not done.
    fn evaluate(&mut self, queued: &BoundedInterval, kind: PairKind) {
        self.progress.evaluations += 1;
        if self.is_over() {
            return self.least_mut(kind).prove(queued.lower);
        }
        let found = self.bound(queued, kind);
        let lower = found.lower.greater(queued.lower);
        if lower >= self.target(kind) {
            self.least_mut(kind).prove(lower);
        } else {
            self.divide(queued.interval, kind, &IntervalBound { lower, ..found });
        }
    }

    /// Bounds the pair's distance in an interval by its distance in the middle.
    fn bound(&mut self, queued: &BoundedInterval, kind: PairKind) -> IntervalBound {
        let PairInterval { pair: index, from, to } = queued.interval;
        let (middle, half_width) = (0.5 * (from + to), 0.5 * (to - from));
        let MotionWorkspace { robot, scratch, motion, .. } = &mut *self.workspace;
        let mut poses = PoseScratch {
            frames: robot.frames_mut(),
            positions: &mut motion.positions,
            level: scratch.level(),
        };
        let midpoint = IntervalMidpoint::new(self.motion, index, [middle, half_width], &mut poses);
        scratch.work.volume_tests += 1;
        let IntervalMidpoint { pair, approach, lower } = &midpoint;
        let (padding, motion) = (pair.info.padding, approach.motion());
        let mut middle = Middle { t: middle, lower: *lower, near: queued.near.map(|near| near.at(pair)) };
        self.offer(index, &middle, pair);
        if self.is_worth_measuring(&midpoint, &middle, kind) {
            self.measure(&midpoint, &mut middle, kind);
            self.offer(index, &middle, pair);
        }
        let (target, lower) = (self.target(kind), middle.lower - padding);
        let reached = middle.near.map_or(f64::INFINITY, |near| near.distance - padding);
        IntervalBound {
            lower: lower - approach.within(1.0),
            motion,
            tolerance: self.options.tolerance(self.least(kind).upper()),
            share: approach.share(lower - target),
            most_share: approach.share(reached - target),
            near: middle.near.map(|near| NearPoints::of(pair, &near)),
        }
    }

    /// True if the distance in the middle may prove a part of the interval that is worth it.
    fn is_worth_measuring(&self, midpoint: &IntervalMidpoint, middle: &Middle, kind: PairKind) -> bool {
        let (approach, padding) = (&midpoint.approach, midpoint.pair.info.padding);
        let (target, motion) = (self.target(kind), approach.motion());
        if middle.lower - padding - approach.within(1.0) > target {
            return false;
        }
        let is_short = motion <= WORTH_SEARCHING[0] + WORTH_SEARCHING[1] * target.greater(0.0);
        match &middle.near {
            // tracking tolerances may leave no share, and the bounds of what cannot be refined must be good all the same
            Some(_) if self.motion.segment.is_loose() => is_short,
            Some(near) => approach.share(near.distance - padding - target) >= LEAST_SHARE,
            None => is_short,
        }
    }

    /// Measures the distance in the middle of an interval, as far as the target needs it.
    fn measure(&mut self, midpoint: &IntervalMidpoint, middle: &mut Middle, kind: PairKind) {
        let IntervalMidpoint { pair, approach, .. } = midpoint;
        let (target, tolerance) = (self.target(kind), self.options.tolerance(self.least(kind).upper()));
        let absolute_tolerance =
            DISTANCE_TOLERANCE[0] * approach.motion() + DISTANCE_TOLERANCE[1] * tolerance.lesser(1.0);
        let effort = Effort { absolute_tolerance, ..Effort::default() };
        let limit = target.greater(0.0) + approach.within(1.0) + pair.info.padding + CONTACT_DISTANCE;
        let scratch = &mut *self.workspace.scratch;
        let lower = match pair.separation_bounds_from(middle.near.as_ref(), limit, &effort, scratch) {
            Ok(None) => limit,
            Ok(Some(exact)) => {
                middle.near = Some(exact);
                exact.distance
            }
            Err(RoughDistance { lower, upper }) => {
                middle.near = Some(upper);
                lower
            }
        };
        middle.lower = middle.lower.greater(lower);
    }

    /// Offers the near points in the middle of an interval of the pair with this number as the nearest so far.
    fn offer(&mut self, index: usize, middle: &Middle, pair: &PosedPair) {
        let Some(near) = &middle.near else { return };
        let mut near_pair = pair.padded(near);
        if near.distance <= pair.info.padding.greater(CONTACT_DISTANCE) {
            near_pair.distance = 0.0;
        }
        let (segment, kind) = (self.segment, self.motion.pairs.kind(index));
        let found = NearestSoFar { segment, t: middle.t, index, pair: near_pair, is_exact: false };
        self.least_mut(kind).offer(found);
    }

    /// Queues the parts of an interval that are not done, unless it cannot be refined.
    fn divide(&mut self, interval: PairInterval, kind: PairKind, found: &IntervalBound) {
        let PairInterval { from, to, .. } = interval;
        let (middle, half_width) = (0.5 * (from + to), 0.5 * (to - from));
        let IntervalBound { lower, motion, tolerance, share, most_share, .. } = *found;
        if share >= LEAST_SHARE {
            let target = self.target(kind);
            self.least_mut(kind).prove(target);
            let done = share * half_width;
            self.push_part(interval, [from, middle - done], found);
            self.push_part(interval, [middle + done, to], found);
        } else if !motion.is_finite() {
            self.progress.unfinished = Some(UndecidedReason::Overflow);
            self.least_mut(kind).leave(lower);
        } else if motion <= LEAST_MOTION * tolerance || !(from < middle && middle < to) {
            let is_loose = self.motion.segment.is_loose();
            let reason = if is_loose { UndecidedReason::Tube } else { UndecidedReason::Tolerance };
            self.progress.unfinished.get_or_insert(reason);
            self.least_mut(kind).leave(lower);
        } else {
            let parts =
                if most_share > 0.0 { (1.0 / most_share).ceil().clamp(2.0, MOST_PARTS) } else { MOST_PARTS };
            let (mut start, mut part) = (from, 1.0);
            while part <= parts {
                let end = if part < parts { from + (to - from) * (part / parts) } else { to };
                self.push_part(interval, [start, end], found);
                (start, part) = (end, part + 1.0);
            }
        }
    }

    /// Measures the nearest pairs of single intervals exactly, with witness points in the root frame.
    fn measure_nearest(&mut self) {
        let CheckedMotion { pairs, segment, .. } = self.motion;
        for kind in PairKind::ALL {
            let Some(nearest) = self.least(kind).nearest() else { continue };
            if nearest.is_exact || nearest.segment != self.segment {
                continue;
            }
            let MotionWorkspace { robot, scratch, motion, .. } = &mut *self.workspace;
            let mut poses = PoseScratch {
                frames: robot.frames_mut(),
                positions: &mut motion.positions,
                level: scratch.level(),
            };
            let PlacedPair { pair, .. } = self.motion.placed_pair(nearest.index, nearest.t, &mut poses);
            let distance = nearest.pair.distance + pair.info.padding;
            let limit =
                hardly_less_than(&Separation { distance, witness_points: nearest.pair.witness_points });
            if let Some(exact) = pair.separation(limit, scratch) {
                // the frames of a self pair are relative to the common ancestor of its bodies
                let q = segment.at(nearest.t);
                let in_root = |point| pairs.robot().point_in_root(pair.info.bodies.0, &point, &q);
                let mut pair = pair.padded(&exact);
                pair.witness_points = exact.witness_points.map(in_root);
                pair.distance = pair.distance.lesser(nearest.pair.distance);
                self.least_mut(kind).set_exact(NearestSoFar { pair, is_exact: true, ..nearest });
            }
        }
    }

    /// True if the search is to stop here.
    fn is_over(&mut self) -> bool {
        let pairs = self.motion.pairs;
        let most_waiting = MOST_WAITING + pairs.self_pairs().count() + pairs.world().number_count();
        let waiting = self.workspace.motion.queue.len();
        let SearchProgress { evaluations, stopped, unfinished, .. } = &mut *self.progress;
        let reason = if *evaluations > self.options.budget || waiting > most_waiting {
            Some(UndecidedReason::Budget)
        } else if *evaluations % EVALUATIONS_PER_CLOCK_READ == 1 {
            self.options.stopped_by()
        } else {
            None
        };
        if reason.is_some() {
            (*stopped, *unfinished) = (true, reason);
        }
        *stopped
    }

    fn push(&mut self, interval: PairInterval) {
        self.workspace.motion.queue.push(BoundedInterval { lower: 0.0, interval, near: None });
    }

    /// Queues a part of an interval, unless it is empty.
    fn push_part(&mut self, interval: PairInterval, [from, to]: [f64; 2], found: &IntervalBound) {
        let IntervalBound { lower, near, .. } = *found;
        if from < to {
            let interval = PairInterval { from, to, ..interval };
            self.workspace.motion.queue.push(BoundedInterval { lower, interval, near });
        }
    }

    fn least(&self, kind: PairKind) -> &LeastBounds {
        &self.progress.least[kind as usize]
    }

    fn least_mut(&mut self, kind: PairKind) -> &mut LeastBounds {
        &mut self.progress.least[kind as usize]
    }

    /// Lower bound (m) that suffices for pairs of this kind.
    fn target(&self, kind: PairKind) -> f64 {
        self.least(kind).target(self.options)
    }
}
