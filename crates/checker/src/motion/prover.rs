//! Continuous check of one motion: proves pairs free in intervals, and collects open intervals and contacts.
//!
//! A pair that level 0 leaves open in an interval is evaluated in the middle. Its distance proves a part of the interval around the
//! middle free; the remainders on either side are evaluated in turn (two-sided conservative advancement; Schwarzer, Saha & Latombe 2005
//! bisect). The hierarchies are searched only where capsules do not suffice, and only where the motion is small enough for the result to
//! be useful.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose};
use clearance_geometry::simd::LANES;
use clearance_motion::{MotionSegment, Proof};
use clearance_proximity as query;
use clearance_proximity::{Effort, Work};
use clearance_robot::{Configuration, LinkPoses};

use super::interval_midpoint::{IntervalMidpoint, PlacedPair};
use super::level_zero::NearPair;
use super::report::{MotionOptions, MotionOrder, MotionReport, MotionVerdict, UndecidedReason};
use crate::collision_checker::CollisionChecker;
use crate::pair::Pair;
use crate::workspace::Workspace;

/// Motion (m) within an interval above which the hierarchies are not searched: the result would rarely prove anything.
const WORTH_ASKING: f64 = 0.04;

/// Relative tolerance of a distance: leaving a small part unproven costs less than an exact distance.
const ROUGHLY: f64 = 0.15;

/// Smallest fraction of an interval that becomes a piece of its own.
const LEAST_SHARE: f64 = 0.15;

/// Motion (m) within an interval below which it is not split further: about where contact and its absence cannot be distinguished.
const FLOOR: f64 = 4e-9;

/// For a widening motion: an interval that is short relative to the time before it need not be split.
const KNOWN_WELL: f64 = 0.03;

/// Number of evaluations between two reads of the clock.
const LOOKS_A_GLANCE: u64 = 16;

/// Number of evaluations spent on a pair nearer than the tolerance, to try to decide it.
const PATIENCE: u32 = 2000;

/// Scratch memory for motions.
#[derive(Clone, Debug, Default)]
pub struct MotionScratch {
    pub(super) positions: Vec<f64>,
    /// By position, for eight states.
    pub(super) columns: Vec<[f64; LANES]>,
    /// Pairs that may touch, with a mask of the eight intervals.
    pub(super) near: Vec<NearPair>,
    pub(super) ways: Vec<f64>,
    pub(super) speeds: Vec<f32>,
    pub(super) off: Vec<f32>,
    pub(super) stack: Vec<Piece>,
}

/// An interval in which a pair is to be evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub pair: usize,
    pub from: f64,
    pub to: f64,
}

/// An interval that stays undecided.
#[derive(Clone, Copy, Debug)]
struct Open {
    piece: Piece,
    distance: [f64; 2],
    reason: UndecidedReason,
}

/// A pair that touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pair: usize,
    t: f64,
    point: Option<Point>,
}

/// Result of one evaluation of a pair in an interval.
enum Look {
    /// The pair touches; the second value is its motion (m) in the whole interval.
    Hit(Option<Point>, f64),
    /// A part of the interval around its middle is free: its fraction, and the bounds that prove it.
    Proven { share: f64, lower: f64, bound: f64 },
    /// Undecided: bounds on the distance, and the largest motion of the pair.
    Open { distance: [f64; 2], motion: f64 },
}

/// The check of one motion, with its results so far.
pub(super) struct Prover<'a> {
    pub(super) checker: &'a CollisionChecker,
    pub(super) segment: &'a MotionSegment,
    pub(super) options: &'a MotionOptions,
    pub(super) workspace: &'a mut Workspace,
    pub(super) motion: MotionScratch,
    /// All of the motion before this time has been searched.
    pub(super) seen_until: f64,
    /// Nothing after this time matters: a collision there is known.
    pub(super) cutoff: f64,
    pub(super) hit: Option<Hit>,
    /// The earliest undecided interval, and the end of the last one.
    open: Option<Open>,
    open_until: f64,
    patience: u32,
    looks: u64,
    /// The proofs, if they are to be kept.
    pub(super) proofs: Option<Vec<Proof>>,
    pub(super) stopped: Option<UndecidedReason>,
}

impl CollisionChecker {
    /// Checks whether the straight line in joint space between two configurations is free, with default options.
    #[must_use]
    pub fn check_motion(
        &self,
        from: &Configuration,
        to: &Configuration,
        workspace: &mut Workspace,
    ) -> MotionReport {
        let segment = MotionSegment::straight(self.robot(), from, to);
        self.check_motion_with(&segment, &MotionOptions::default(), workspace)
    }

    /// Checks whether a motion is free: the result is proven free, contact, or undecided with a reason.
    #[must_use]
    pub fn check_motion_with(
        &self,
        segment: &MotionSegment,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> MotionReport {
        let report = self.prove(segment, options, workspace, false).0;
        self.sure_of_contact(report, segment, options, workspace)
    }

    /// Converts pair numbers to indices in the list of all pairs.
    fn number_in_order(&self, proofs: &mut [Proof]) {
        if proofs.is_empty() {
            return;
        }
        let all: Vec<usize> = self.all_pairs().collect();
        for proof in proofs {
            proof.0 = all.binary_search(&proof.0).expect("what is proven is about a pair");
        }
    }

    /// Rejects a motion of an unknown obstacle or of another robot: it would otherwise be checked at rest, and might wrongly be free.
    fn refusal(&self, segment: &MotionSegment) -> Option<MotionVerdict> {
        let known = |name: &str| self.world().id(name).is_some();
        let of_another = segment.position_count() != self.robot().position_names().len();
        let unknown = of_another || segment.obstacles().iter().any(|mover| !known(&mover.name));
        let reason = UndecidedReason::Mismatch;
        unknown.then_some(MotionVerdict::Undecided {
            t: [0.0, 1.0],
            pair: None,
            distance: [0.0, f64::INFINITY],
            reason,
        })
    }

    /// Where a tracking tolerance leaves the result undecided, the check without this tolerance may find a contact.
    pub(super) fn sure_of_contact(
        &self,
        report: MotionReport,
        segment: &MotionSegment,
        options: &MotionOptions,
        workspace: &mut Workspace,
    ) -> MotionReport {
        let MotionVerdict::Undecided { t: [open, _], reason: UndecidedReason::Tube, .. } = report.verdict
        else {
            return report;
        };
        let nominal = self.prove(&segment.nominal(), options, workspace, false).0;
        let looks = report.looks + nominal.looks;
        match nominal.verdict {
            MotionVerdict::Contact { t: [lo, hi], pair, witness } => {
                let verdict = MotionVerdict::Contact { t: [lo.lesser(open), hi], pair, witness };
                MotionReport { verdict, looks, ..report }
            }
            _ => MotionReport { looks, ..report },
        }
    }

    /// As [`Self::check_motion_with`], with all proofs if they are to be kept.
    pub(super) fn prove(
        &self,
        segment: &MotionSegment,
        options: &MotionOptions,
        workspace: &mut Workspace,
        keep: bool,
    ) -> (MotionReport, Vec<Proof>) {
        self.suit(workspace);
        workspace.scratch.work = Work::default();
        if let Some(verdict) = self.refusal(segment) {
            return (MotionReport { verdict, looks: 0, work: Work::default() }, Vec::new());
        }
        let mut motion = std::mem::take(&mut workspace.motion);
        motion.positions.resize(segment.position_count(), 0.0);
        let mut prover = Prover {
            checker: self,
            segment,
            options,
            workspace,
            motion,
            seen_until: 0.0,
            cutoff: f64::INFINITY,
            hit: None,
            open: None,
            open_until: 0.0,
            patience: PATIENCE,
            looks: 0,
            proofs: keep.then(Vec::new),
            stopped: None,
        };
        prover.run();
        if options.order == MotionOrder::Earliest {
            prover.look_at_the_ends();
        }
        let verdict = prover.verdict();
        let Prover { motion, looks, proofs, workspace, .. } = prover;
        workspace.motion = motion;
        let mut proofs = proofs.unwrap_or_default();
        self.number_in_order(&mut proofs);
        proofs.sort_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)));
        (MotionReport { verdict, looks, work: workspace.scratch.work }, proofs)
    }
}

impl Prover<'_> {
    /// If no proof covers the start or the end of a motion, it may collide there.
    fn look_at_the_ends(&mut self) {
        let Some(open) = self.open.filter(|_| self.stopped.is_none()) else { return };
        let pairs = [Some(open.piece.pair), self.hit.map(|hit| hit.pair)];
        for pair in pairs.into_iter().flatten() {
            let collides_at_start = open.piece.from == 0.0 && self.touches(pair, 0.0);
            if collides_at_start || (self.hit.is_none() && open.piece.to == 1.0 && self.touches(pair, 1.0)) {
                return;
            }
        }
    }

    /// True if a pair touches at t; the contact is recorded.
    pub(super) fn touches(&mut self, index: usize, t: f64) -> bool {
        let Workspace { frames, scratch, .. } = &mut *self.workspace;
        let positions = &mut self.motion.positions;
        let PlacedPair { pair, .. } =
            self.checker.placed_pair(index, self.segment, t, frames, positions, scratch);
        self.looks += 1;
        let (a, b) = pair.bodies;
        let Some(found) = query::within_margin(a, b, pair.pose_ab, pair.info.padding, scratch) else {
            return false;
        };
        self.cutoff = t;
        let point = self.checker.in_root(&pair, &found.witness_points[0], self.segment, t);
        self.hit = Some(Hit { pair: index, t, point });
        true
    }

    /// Evaluates a pair until nothing of the piece before the cutoff is left, the earliest part first.
    pub(super) fn pair_in(&mut self, piece: Piece) {
        self.motion.stack.clear();
        self.motion.stack.push(piece);
        while let Some(mut piece) = self.motion.stack.pop() {
            if piece.from >= self.cutoff {
                continue;
            }
            piece.to = piece.to.lesser(self.cutoff);
            if self.stopped.is_some() {
                self.leave_open(piece, [0.0, f64::INFINITY], self.stopped.unwrap_or(UndecidedReason::Budget));
                continue;
            }
            self.look_at(piece);
        }
    }

    /// Evaluates a piece; the remainders are pushed on the stack, the earlier one on top.
    pub(super) fn look_at(&mut self, piece: Piece) {
        let Piece { pair, from, to } = piece;
        let (middle, half_width) = (0.5 * (from + to), 0.5 * (to - from));
        let cut = |from: f64, to: f64| Piece { pair, from, to };
        match self.look(piece, middle, half_width) {
            Look::Hit(point, motion) => {
                self.cutoff = middle;
                self.hit = Some(Hit { pair, t: middle, point });
                if motion <= self.tolerance() {
                    self.leave_open(cut(from, middle), [0.0; 2], UndecidedReason::Tolerance);
                } else {
                    self.motion.stack.push(cut(from, middle));
                }
            }
            Look::Proven { share, lower, bound } if share >= 1.0 => self.keep(piece, lower, bound),
            Look::Proven { share, lower, bound } => {
                let (low, high) = (middle - share * half_width, middle + share * half_width);
                self.keep(cut(low, high), lower, bound);
                for rest in [cut(high, to), cut(from, low)] {
                    if rest.from < rest.to {
                        self.motion.stack.push(rest);
                    }
                }
            }
            Look::Open { distance, motion } => self.push_open(piece, distance, motion),
        }
    }

    /// Splits a piece in two, unless this is useless.
    fn push_open(&mut self, piece: Piece, distance: [f64; 2], motion: f64) {
        let Piece { pair, from, to } = piece;
        let middle = 0.5 * (from + to);
        let cannot_be_cut = !(from < middle && middle < to);
        if !motion.is_finite() {
            return self.leave_open(piece, distance, UndecidedReason::Overflow);
        }
        let known_well = self.segment.widens() && to - from <= KNOWN_WELL * to;
        if motion <= self.tolerance() || cannot_be_cut || known_well {
            if self.segment.is_loose() {
                self.leave_open(piece, distance, UndecidedReason::Tube);
                self.cutoff = self.cutoff.lesser(from);
                return;
            }
            if to >= self.cutoff || motion <= FLOOR || self.patience == 0 || cannot_be_cut {
                return self.leave_open(piece, distance, UndecidedReason::Tolerance);
            }
            self.patience -= 1;
        }
        self.motion.stack.push(Piece { pair, from: middle, to });
        self.motion.stack.push(Piece { pair, from, to: middle });
    }

    /// Motion (m) in an interval below which it may stay undecided.
    fn tolerance(&self) -> f64 {
        self.options.tolerance.greater(FLOOR)
    }

    pub(super) fn leave_open(&mut self, piece: Piece, distance: [f64; 2], reason: UndecidedReason) {
        self.open_until = self.open_until.greater(piece.to);
        if self.open.is_none_or(|open| piece.from < open.piece.from) {
            self.open = Some(Open { piece, distance, reason });
        }
    }

    fn keep(&mut self, Piece { pair, from, to }: Piece, lower: f64, bound: f64) {
        if let Some(proofs) = &mut self.proofs {
            proofs.push(Proof(pair, from, to, lower, bound));
        }
    }

    /// Evaluates a pair in the middle of a piece.
    fn look(&mut self, piece: Piece, middle: f64, half_width: f64) -> Look {
        self.looks += 1;
        if self.is_over() {
            return Look::Open { distance: [0.0, f64::INFINITY], motion: 0.0 };
        }
        let Workspace { frames, scratch, .. } = &mut *self.workspace;
        let interval = (middle, half_width);
        let moment = self.checker.moment(
            piece.pair,
            self.segment,
            interval,
            frames,
            &mut self.motion.positions,
            scratch,
        );
        scratch.work.volume_tests += 1;
        let IntervalMidpoint { pair, approach, lower } = &moment;
        let padding = pair.info.padding;
        let (bound, motion) = (approach.within(1.0), approach.motion());
        if lower - padding > bound {
            return Look::Proven { share: 1.0, lower: *lower, bound };
        }
        let unknown = [(lower - padding).greater(0.0), f64::INFINITY];
        if motion > WORTH_ASKING {
            return moment.proven(*lower).unwrap_or(Look::Open { distance: unknown, motion });
        }
        // if padding and tolerances use up most of a distance, a relative tolerance is too large
        let effort = if padding > 0.0 || self.segment.is_loose() {
            Effort { absolute_tolerance: ROUGHLY * motion, ..Effort::default() }
        } else {
            Effort { relative_tolerance: ROUGHLY, ..Effort::default() }
        };
        let limit = bound + padding + CONTACT_DISTANCE;
        let found = pair.separation_bounds(limit, &effort, &mut self.workspace.scratch);
        let Some(near) = found.upper else { return Look::Proven { share: 1.0, lower: limit, bound } };
        if near.distance <= padding.greater(CONTACT_DISTANCE) {
            let point = self.checker.in_root(pair, &near.witness_points[0], self.segment, middle);
            return Look::Hit(point, motion);
        }
        let distance = [(found.lower - padding).greater(0.0), near.distance - padding];
        moment.proven(found.lower).unwrap_or(Look::Open { distance, motion })
    }

    /// True if the check is to stop here.
    fn is_over(&mut self) -> bool {
        if self.stopped.is_none() {
            if self.looks > self.options.budget {
                self.stopped = Some(UndecidedReason::Budget);
            } else if self.looks % LOOKS_A_GLANCE == 1 {
                self.stopped = self.options.stopped_by();
            }
        }
        self.stopped.is_some()
    }

    fn verdict(&mut self) -> MotionVerdict {
        let ids = |pair: usize| self.checker.info(pair).ids;
        let open = self.open.filter(|open| open.piece.from <= self.cutoff);
        let free_until = open.map_or(self.cutoff, |open| open.piece.from);
        // a check that stops early has not searched everything before `free_until`
        let free_until = if self.stopped.is_some() { free_until.lesser(self.seen_until) } else { free_until };
        if let Some(Hit { pair, t, point }) = self.hit {
            return MotionVerdict::Contact { t: [free_until.lesser(t), t], pair: ids(pair), witness: point };
        }
        match (open, self.stopped) {
            (None, None) => MotionVerdict::Free,
            (open, Some(reason)) => MotionVerdict::Undecided {
                t: [free_until.lesser(1.0), 1.0],
                pair: open.map(|open| ids(open.piece.pair)),
                distance: open.map_or([0.0, f64::INFINITY], |open| open.distance),
                reason,
            },
            (Some(open), None) => MotionVerdict::Undecided {
                // a possible contact within the tracking tolerance ends the search
                t: [
                    open.piece.from,
                    if open.reason == UndecidedReason::Tube { 1.0 } else { self.open_until },
                ],
                pair: Some(ids(open.piece.pair)),
                distance: open.distance,
                reason: open.reason,
            },
        }
    }
}

impl CollisionChecker {
    /// Transforms a point from the frame of a pair's first body to the root frame.
    fn in_root(&self, pair: &Pair, point: &Point, segment: &MotionSegment, t: f64) -> Option<Point> {
        let link = self.robot_bodies[pair.info.bodies.0].link;
        let mut poses = LinkPoses::new(self.robot());
        self.robot().forward_kinematics(&segment.at(t), &mut poses);
        let seat = self.chain.seat(link.index())?;
        // the pose of the link in its body gives the frame of the body
        let pose_lb = Pose::from(&MatrixPose::from(&seat.place)).inverse();
        Some(poses.pose(link) * pose_lb * point)
    }
}

impl IntervalMidpoint<'_> {
    /// The interval that a distance (m) proves free, if it is long enough.
    fn proven(&self, lower: f64) -> Option<Look> {
        let share = self.approach.share(lower - self.pair.info.padding);
        (share >= LEAST_SHARE).then(|| Look::Proven { share, lower, bound: self.approach.within(share) })
    }
}
