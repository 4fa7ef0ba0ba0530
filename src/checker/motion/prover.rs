//! One motion: which intervals are looked at, and what is found.
//!
//! Level 0 goes through the motion eight intervals at a time. A pair that it leaves open in an interval is looked at in the middle:
//! its distance proves a part of the interval around the middle free, and what remains on either side is looked at in turn
//! (two-sided conservative advancement; Schwarzer, Saha & Latombe 2005 bisect). The distance is only asked of the hierarchies where capsules
//! do not do, and only where the motion is small enough for an answer to be of use.

use super::moment::{Moment, PlacedPair};
use super::report::{MotionOptions, MotionOrder, MotionReport, MotionVerdict, UndecidedReason};
use crate::checker::Body;
use crate::checker::collision_checker::CollisionChecker;
use crate::checker::pair::Pair;
use crate::checker::workspace::Workspace;
use crate::constants::CONTACT_DISTANCE;
use crate::math::{MatrixPose, Point, Pose};
use crate::motion::{MotionSegment, Proof};
use crate::query::{self, Effort, Work};
use crate::robot::{Configuration, LinkPoses};
use crate::simd::LANES;

/// Above this motion (m) within an interval the hierarchies are not asked: the answer would rarely prove anything.
const WORTH_ASKING: f64 = 0.04;

/// The motion (m) in an interval at level 0 that is aimed at.
const LEVEL_ZERO_MOTION: f32 = 0.1;

/// Most intervals at level 0.
const MOST_INTERVALS: usize = 1024;

/// How far a distance may be off, as a share of itself: what is left unproven costs less than exactness.
const ROUGHLY: f64 = 0.15;

/// A share of an interval that is not worth a piece of its own.
const LEAST_SHARE: f64 = 0.15;

/// The motion (m) in an interval below which nothing is cut further: about where contact and its absence look alike.
const FLOOR: f64 = 4e-9;

/// Where states are looked at when any contact will do: each as far as can be from those before it.
const SAMPLES: [f64; LANES] = [0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875, 1.0];

/// Looks spent on what is nearer than the tolerance, in the hope to decide it.
const PATIENCE: u32 = 2000;

/// Memory for motions.
#[derive(Clone, Debug, Default)]
pub struct MotionScratch {
    pub(super) positions: Vec<f64>,
    pub(super) columns: Vec<[f64; LANES]>,
    /// By pair: in which of eight intervals it may touch.
    pub(super) near: Vec<u8>,
    ways: Vec<f64>,
    speeds: Vec<f32>,
    off: Vec<f32>,
    stack: Vec<Piece>,
}

/// An interval in which a pair is to be looked at.
#[derive(Clone, Copy, Debug)]
struct Piece {
    pair: usize,
    from: f64,
    to: f64,
}

/// An interval that stays open.
#[derive(Clone, Copy, Debug)]
struct Open {
    piece: Piece,
    distance: [f64; 2],
    reason: UndecidedReason,
}

/// What a look found.
enum Look {
    Hit(Option<Point>),
    /// A part of the interval around its middle is free: its share, and what proves it.
    Proven {
        share: f64,
        lower: f64,
        bound: f64,
    },
    /// Nothing: the distance is between these, and this is the most that the pair moves.
    Open {
        distance: [f64; 2],
        motion: f64,
    },
}

/// A motion that is looked at, and what is known so far.
pub(super) struct Prover<'a> {
    checker: &'a CollisionChecker,
    segment: &'a MotionSegment,
    options: &'a MotionOptions,
    workspace: &'a mut Workspace,
    motion: MotionScratch,
    /// All that comes before has been looked at.
    seen_until: f64,
    /// Nothing after this matters: something is known to collide there.
    cutoff: f64,
    hit: Option<(usize, Option<Point>)>,
    open: Option<Open>,
    patience: u32,
    looks: u64,
    /// What was proven, if it is to be kept.
    proofs: Option<Vec<Proof>>,
    stopped: Option<UndecidedReason>,
}

impl CollisionChecker {
    /// Whether the straight way in joint space from one configuration to another is free, with the usual options.
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

    /// Whether a motion is free: proven, contact, or undecided and why.
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

    /// Where a tracking tolerance leaves it open, the motion itself may tell.
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
                let verdict = MotionVerdict::Contact { t: [lo.min(open), hi], pair, witness };
                MotionReport { verdict, looks, ..report }
            }
            _ => MotionReport { looks, ..report },
        }
    }

    /// As [`Self::check_motion_with`], and all proofs if they are to be kept.
    pub(super) fn prove(
        &self,
        segment: &MotionSegment,
        options: &MotionOptions,
        workspace: &mut Workspace,
        keep: bool,
    ) -> (MotionReport, Vec<Proof>) {
        self.suit(workspace);
        workspace.scratch.work = Work::default();
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
            patience: PATIENCE,
            looks: 0,
            proofs: keep.then(Vec::new),
            stopped: None,
        };
        prover.run();
        if options.order == MotionOrder::Earliest {
            prover.look_at_the_start();
        }
        let verdict = prover.verdict();
        let Prover { motion, looks, proofs, workspace, .. } = prover;
        workspace.motion = motion;
        let mut proofs = proofs.unwrap_or_default();
        proofs.sort_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)));
        (MotionReport { verdict, looks, work: workspace.scratch.work }, proofs)
    }
}

impl Prover<'_> {
    fn run(&mut self) {
        if self.proofs.is_some() {
            return self.all_pairs_alone();
        }
        self.checker.approach_speeds(self.segment, &mut self.motion.ways, &mut self.motion.speeds);
        self.checker.tolerated(self.segment, &mut self.motion.ways, &mut self.motion.off);
        let fastest = self.motion.speeds.iter().copied().fold(0.0, f32::max);
        let blocks = blocks(fastest);
        match self.options.order {
            MotionOrder::Earliest => self.earliest(blocks),
            MotionOrder::Any => self.any(blocks),
        }
    }

    /// A motion that cannot be free from its start on may collide there.
    fn look_at_the_start(&mut self) {
        let first = self.open.filter(|open| open.piece.from == 0.0);
        let (Some((pair, _)), Some(open)) = (self.hit, first) else { return };
        for pair in [pair, open.piece.pair] {
            if let Look::Hit(point) = self.look(Piece { pair, from: 0.0, to: 0.0 }, 0.0, 0.0) {
                self.cutoff = 0.0;
                self.hit = Some((pair, point));
            }
        }
    }

    /// One pair after the other, each from the whole motion to smaller pieces: the fewest proofs.
    fn all_pairs_alone(&mut self) {
        for pair in 0..self.checker.infos.len() {
            self.pair_in(Piece { pair, from: 0.0, to: 1.0 });
        }
    }

    /// Blocks of eight intervals in their order, and in each interval all pairs that level 0 leaves.
    fn earliest(&mut self, blocks: usize) {
        for block in 0..blocks {
            let ends = self.screen(block, blocks);
            for lane in 0..LANES {
                self.seen_until = ends[lane];
                if ends[lane] >= self.cutoff || self.stopped.is_some() {
                    return;
                }
                for pair in 0..self.motion.near.len() {
                    if self.motion.near[pair] & (1 << lane) != 0 {
                        self.pair_in(Piece { pair, from: ends[lane], to: ends[lane + 1] });
                    }
                }
            }
        }
    }

    /// What collides mostly does so for long: eight states first, then all pieces that level 0 leaves, each looked at once before any of
    /// their parts is.
    fn any(&mut self, blocks: usize) {
        if self.some_state_collides() {
            self.nothing_known_before();
            return;
        }
        let mut queue = std::collections::VecDeque::new();
        for block in 0..blocks {
            let ends = self.screen(block, blocks);
            for lane in van_der_corput() {
                for (pair, near) in self.motion.near.iter().enumerate() {
                    if near & (1 << lane) != 0 {
                        queue.push_back(Piece { pair, from: ends[lane], to: ends[lane + 1] });
                    }
                }
            }
        }
        while let Some(piece) = queue.pop_front() {
            self.look_at(piece);
            if self.hit.is_some() || self.stopped.is_some() {
                self.nothing_known_before();
                return;
            }
            queue.extend(self.motion.stack.drain(..));
        }
    }

    /// Whether the robot collides at one of eight fractions, each as far as can be from those before it.
    fn some_state_collides(&mut self) -> bool {
        self.screen_at(SAMPLES, 0.0);
        for (lane, t) in SAMPLES.into_iter().enumerate() {
            for pair in 0..self.motion.near.len() {
                if self.motion.near[pair] & (1 << lane) != 0 && self.touches(pair, t) {
                    return true;
                }
            }
        }
        false
    }

    fn touches(&mut self, index: usize, t: f64) -> bool {
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
        self.hit = Some((index, self.checker.in_root(&pair, &found.witness_points[0], self.segment, t)));
        true
    }

    /// Of what comes before a hit nothing is known.
    fn nothing_known_before(&mut self) {
        let piece = Piece { pair: 0, from: 0.0, to: 1.0 };
        self.leave_open(piece, [0.0, f64::INFINITY], UndecidedReason::Tolerance);
    }

    /// Level 0 of a block; returns the ends of its eight intervals.
    fn screen(&mut self, block: usize, blocks: usize) -> [f64; LANES + 1] {
        #[allow(clippy::cast_precision_loss)] // small numbers
        let end = |i: usize| (block * LANES + i) as f64 / (blocks * LANES) as f64;
        let ends = std::array::from_fn(end);
        let middles = std::array::from_fn(|lane| 0.5 * (end(lane) + end(lane + 1)));
        #[allow(clippy::cast_precision_loss)]
        let half_width = 0.5 / (blocks * LANES) as f64;
        self.screen_at(middles, half_width);
        ends
    }

    /// Level 0 of eight intervals.
    fn screen_at(&mut self, middles: [f64; LANES], half_width: f64) {
        let (speeds, off) = (std::mem::take(&mut self.motion.speeds), std::mem::take(&mut self.motion.off));
        let level = self.workspace.scratch.level();
        self.checker.screen_intervals(
            self.segment,
            (middles, half_width),
            (&speeds, &off),
            &mut self.motion,
            level,
        );
        (self.motion.speeds, self.motion.off) = (speeds, off);
        self.workspace.scratch.work.volume_tests += (self.checker.infos.len() * LANES) as u64;
        self.mark_movers();
    }

    /// Level 0 knows nothing of obstacles that move.
    fn mark_movers(&mut self) {
        if self.segment.obstacles().is_empty() {
            return;
        }
        for (near, info) in self.motion.near.iter_mut().zip(&self.checker.infos) {
            if self.checker.mover(self.segment, info.bodies.1).is_some() {
                *near = u8::MAX;
            }
        }
    }

    /// Looks at a pair until nothing in the piece that comes before the cutoff is left, the earliest first.
    fn pair_in(&mut self, piece: Piece) {
        self.motion.stack.clear();
        self.motion.stack.push(piece);
        while let Some(mut piece) = self.motion.stack.pop() {
            if piece.from >= self.cutoff {
                continue;
            }
            piece.to = piece.to.min(self.cutoff);
            if self.stopped.is_some() {
                self.leave_open(piece, [0.0, f64::INFINITY], self.stopped.unwrap_or(UndecidedReason::Budget));
                continue;
            }
            self.look_at(piece);
        }
    }

    /// Looks at a piece; what it leaves is put on the stack, the earlier on top.
    fn look_at(&mut self, piece: Piece) {
        let Piece { pair, from, to } = piece;
        let (middle, half_width) = (0.5 * (from + to), 0.5 * (to - from));
        let cut = |from: f64, to: f64| Piece { pair, from, to };
        match self.look(piece, middle, half_width) {
            Look::Hit(point) => {
                self.cutoff = middle;
                self.hit = Some((pair, point));
                self.motion.stack.push(cut(from, middle));
            }
            Look::Proven { share, lower, bound } if share >= 1.0 => self.keep(piece, lower, bound),
            Look::Proven { share, lower, bound } => {
                let (low, high) = (middle - share * half_width, middle + share * half_width);
                self.keep(cut(low, high), lower, bound);
                self.motion.stack.push(cut(high, to));
                self.motion.stack.push(cut(from, low));
            }
            Look::Open { distance, motion } => self.push_open(piece, distance, motion),
        }
    }

    /// Cuts a piece in two unless there is no use.
    fn push_open(&mut self, piece: Piece, distance: [f64; 2], motion: f64) {
        let Piece { pair, from, to } = piece;
        let middle = 0.5 * (from + to);
        let cannot_be_cut = !(from < middle && middle < to);
        if motion <= self.options.tolerance || cannot_be_cut {
            if self.segment.is_loose() {
                self.leave_open(piece, distance, UndecidedReason::Tube);
                self.cutoff = self.cutoff.min(from);
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

    fn leave_open(&mut self, piece: Piece, distance: [f64; 2], reason: UndecidedReason) {
        if self.open.is_none_or(|open| piece.from < open.piece.from) {
            self.open = Some(Open { piece, distance, reason });
        }
    }

    fn keep(&mut self, Piece { pair, from, to }: Piece, lower: f64, bound: f64) {
        if let Some(proofs) = &mut self.proofs {
            proofs.push(Proof(pair, from, to, lower, bound));
        }
    }

    /// Looks at a pair in the middle of a piece.
    fn look(&mut self, piece: Piece, middle: f64, half_width: f64) -> Look {
        self.looks += 1;
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
        let Moment { pair, approach, lower } = &moment;
        let padding = pair.info.padding;
        let (bound, motion) = (approach.within(1.0), approach.motion());
        if lower - padding > bound {
            return Look::Proven { share: 1.0, lower: *lower, bound };
        }
        let unknown = [(lower - padding).max(0.0), f64::INFINITY];
        let far = (motion > WORTH_ASKING).then(|| moment.proven(*lower));
        if let Some(Some(proven)) = far {
            return proven;
        }
        if self.is_over() || far.is_some() {
            return Look::Open { distance: unknown, motion };
        }
        let effort = Effort { relative_tolerance: ROUGHLY, ..Effort::default() };
        let limit = bound + padding + CONTACT_DISTANCE;
        let found = pair.separation_bounds(limit, &effort, &mut self.workspace.scratch);
        let Some(near) = found.upper else { return Look::Proven { share: 1.0, lower: limit, bound } };
        if near.distance <= padding.max(CONTACT_DISTANCE) {
            return Look::Hit(self.checker.in_root(pair, &near.witness_points[0], self.segment, middle));
        }
        let distance = [(found.lower - padding).max(0.0), near.distance - padding];
        moment.proven(found.lower).unwrap_or(Look::Open { distance, motion })
    }

    /// Whether to stop here.
    fn is_over(&mut self) -> bool {
        if self.stopped.is_none() {
            if self.looks > self.options.budget {
                self.stopped = Some(UndecidedReason::Budget);
            } else if self.options.deadline.is_some_and(|deadline| std::time::Instant::now() >= deadline) {
                self.stopped = Some(UndecidedReason::Deadline);
            }
        }
        self.stopped.is_some()
    }

    fn verdict(&mut self) -> MotionVerdict {
        let ids = |pair: usize| self.checker.infos[pair].ids;
        let open = self.open.filter(|open| open.piece.from <= self.cutoff);
        let free_until = open.map_or(self.cutoff, |open| open.piece.from);
        // who stops early has not looked at everything before that
        let free_until = if self.stopped.is_some() { free_until.min(self.seen_until) } else { free_until };
        if let Some((pair, witness)) = self.hit {
            return MotionVerdict::Contact { t: [free_until, self.cutoff], pair: ids(pair), witness };
        }
        match (open, self.stopped) {
            (None, None) => MotionVerdict::Free,
            (open, Some(reason)) => MotionVerdict::Undecided {
                t: [free_until.min(1.0), 1.0],
                pair: ids(open.map_or(0, |open| open.piece.pair)),
                distance: open.map_or([0.0, f64::INFINITY], |open| open.distance),
                reason,
            },
            (Some(open), None) => MotionVerdict::Undecided {
                t: [open.piece.from, open.piece.to],
                pair: ids(open.piece.pair),
                distance: open.distance,
                reason: open.reason,
            },
        }
    }
}

impl CollisionChecker {
    /// A point in the frame of a pair's first body, as seen from the root.
    fn in_root(&self, pair: &Pair, point: &Point, segment: &MotionSegment, t: f64) -> Option<Point> {
        let Body::Link(link) = pair.info.ids.0 else { return None };
        let mut poses = LinkPoses::new(self.robot());
        self.robot().forward_kinematics(&segment.at(t), &mut poses);
        let seat = self.chain.seat(link.index())?;
        // the body's frame is where its link's seat comes from
        let pose_lb = Pose::from(&MatrixPose::from(&seat.place)).inverse();
        Some(poses.pose(link) * pose_lb * point)
    }
}

impl Moment<'_> {
    /// What a distance (m) proves, if it is worth it.
    fn proven(&self, lower: f64) -> Option<Look> {
        let share = self.approach.share(lower - self.pair.info.padding);
        (share >= LEAST_SHARE).then(|| Look::Proven { share, lower, bound: self.approach.within(share) })
    }
}

/// How many blocks of eight intervals make motions at level 0 small.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped
fn blocks(fastest: f32) -> usize {
    let intervals = (0.5 * fastest / LEVEL_ZERO_MOTION).min(MOST_INTERVALS as f32);
    (intervals.max(1.0) as usize).div_ceil(LANES)
}

/// The eight lanes, each as far as can be from those before it.
fn van_der_corput() -> [usize; LANES] {
    [4, 2, 6, 1, 5, 3, 7, 0]
}
