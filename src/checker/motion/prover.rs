//! One motion: which intervals are looked at, and what is found.
//!
//! Level 0 goes through the motion eight intervals at a time. A pair that it leaves open in an interval is looked at in the middle:
//! its distance proves a part of the interval around the middle free, and what remains on either side is looked at in turn
//! (two-sided conservative advancement; Schwarzer, Saha & Latombe 2005 bisect). The distance is only asked of the hierarchies where capsules
//! do not do, and only where the motion is small enough for an answer to be of use.

use std::time::Instant;

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

/// Motions (m) either way from the middle that are looked at as one interval.
const SHORT_MOTION: f32 = 0.07;

/// Most intervals at level 0.
const MOST_INTERVALS: usize = 1024;

/// How far a distance may be off, as a share of itself: what is left unproven costs less than exactness.
const ROUGHLY: f64 = 0.15;

/// A share of an interval that is not worth a piece of its own.
const LEAST_SHARE: f64 = 0.15;

/// The motion (m) in an interval below which nothing is cut further: about where contact and its absence look alike.
const FLOOR: f64 = 4e-9;

/// Where states are looked at when any contact will do: the end, where most that collide do, and then each as far as can be from those
/// before it.
const SAMPLES: [f64; LANES] = [1.0, 0.5, 0.75, 0.25, 0.875, 0.625, 0.375, 0.125];

/// How often the first interval of a motion that widens is doubled to make the whole.
const DOUBLINGS: i32 = 8;

/// Of a motion that widens: an interval that is short beside the time before it needs not be cut.
const KNOWN_WELL: f64 = 0.03;

/// Looks between two glances at the clock.
const LOOKS_A_GLANCE: u64 = 16;

/// Most pieces that wait in a queue; what comes beyond is looked at first.
const MOST_QUEUED: usize = 1 << 18;

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

/// A pair that touches.
#[derive(Clone, Copy, Debug)]
struct Hit {
    pair: usize,
    t: f64,
    point: Option<Point>,
}

/// What a look found.
enum Look {
    /// The pair touches; in the whole interval it moves by this much (m).
    Hit(Option<Point>, f64),
    /// A part of the interval around its middle is free: its share, and what proves it.
    Proven { share: f64, lower: f64, bound: f64 },
    /// Nothing: the distance is between these, and this is the most that the pair moves.
    Open { distance: [f64; 2], motion: f64 },
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
    hit: Option<Hit>,
    /// The earliest interval that stays open, and where the last of them ends.
    open: Option<Open>,
    open_until: f64,
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

    /// What would stand where it is although it is to move must not be taken for free.
    fn refusal(&self, segment: &MotionSegment) -> Option<MotionVerdict> {
        let known = |name: &str| self.world().obstacles().iter().any(|o| o.name == name);
        let unknown = segment.obstacles().iter().any(|mover| !known(&mover.name));
        let reason = UndecidedReason::UnknownObstacle;
        unknown.then_some(MotionVerdict::Undecided {
            t: [0.0, 1.0],
            pair: None,
            distance: [0.0, f64::INFINITY],
            reason,
        })
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
        proofs.sort_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)));
        (MotionReport { verdict, looks, work: workspace.scratch.work }, proofs)
    }
}

impl Prover<'_> {
    fn run(&mut self) {
        self.motion.stack.clear();
        if self.proofs.is_some() {
            return self.all_pairs_alone();
        }
        if self.segment.widens() {
            return self.soonest();
        }
        self.checker.approach_speeds(self.segment, &mut self.motion.ways, &mut self.motion.speeds);
        self.checker.tolerated(self.segment, &mut self.motion.ways, &mut self.motion.off);
        let fastest = self.motion.speeds.iter().copied().fold(0.0, f32::max);
        let blocks = blocks(fastest);
        match self.options.order {
            MotionOrder::Earliest if 0.5 * fastest <= SHORT_MOTION => self.short(),
            MotionOrder::Earliest => self.earliest(blocks),
            MotionOrder::Any => self.any(blocks),
        }
    }

    /// A motion that is not proven free from its start on, or to its end, may collide there.
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

    /// One pair after the other, each from the whole motion to smaller pieces: the fewest proofs.
    fn all_pairs_alone(&mut self) {
        for pair in 0..self.checker.infos.len() {
            self.pair_in(Piece { pair, from: 0.0, to: 1.0 });
        }
    }

    /// What may be more and more off is looked at in intervals each as long as all before it: where nothing is proven any more,
    /// nothing after it matters.
    fn soonest(&mut self) {
        let mut from = 0.0;
        for doubling in (0..DOUBLINGS).rev() {
            let to = 0.5_f64.powi(doubling);
            for pair in 0..self.checker.infos.len() {
                self.pair_in(Piece { pair, from, to });
            }
            if self.cutoff <= to || self.stopped.is_some() {
                return;
            }
            from = to;
            self.seen_until = to;
        }
    }

    /// Where little moves, the middle tells enough of all but a few pairs.
    fn short(&mut self) {
        let MotionScratch { speeds, off, positions, .. } = &mut self.motion;
        self.checker.screen_whole(self.segment, (speeds, off), positions, self.workspace);
        for pair in 0..self.checker.infos.len() {
            let near = self.workspace.near[pair / LANES] & (1 << (pair % LANES)) != 0;
            if near || self.checker.mover(self.segment, self.checker.infos[pair].bodies.1).is_some() {
                self.pair_in(Piece { pair, from: 0.0, to: 1.0 });
            }
        }
    }

    /// Blocks of eight intervals in their order, and where a run of intervals begins in which level 0 leaves a pair, that pair in all of
    /// the run: what is always near often moves little.
    fn earliest(&mut self, blocks: usize) {
        for block in 0..blocks {
            let ends = self.screen(block, blocks);
            for lane in 0..LANES {
                self.seen_until = ends[lane];
                if ends[lane] >= self.cutoff || self.stopped.is_some() {
                    return;
                }
                for pair in 0..self.motion.near.len() {
                    if let Some(end) = run_from(self.motion.near[pair], lane) {
                        self.pair_in(Piece { pair, from: ends[lane], to: ends[end] });
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
            for lane in 0..LANES {
                for (pair, near) in self.motion.near.iter().enumerate() {
                    if let Some(end) = run_from(*near, lane) {
                        queue.push_back(Piece { pair, from: ends[lane], to: ends[end] });
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
            if queue.len() < MOST_QUEUED {
                queue.extend(self.motion.stack.drain(..));
            } else {
                self.motion.stack.drain(..).for_each(|piece| queue.push_front(piece));
            }
        }
    }

    /// Whether the robot collides at one of eight fractions.
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
        let point = self.checker.in_root(&pair, &found.witness_points[0], self.segment, t);
        self.hit = Some(Hit { pair: index, t, point });
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

    /// Cuts a piece in two unless there is no use.
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

    /// The motion (m) in an interval that may stay open.
    fn tolerance(&self) -> f64 {
        self.options.tolerance.max(FLOOR)
    }

    fn leave_open(&mut self, piece: Piece, distance: [f64; 2], reason: UndecidedReason) {
        self.open_until = self.open_until.max(piece.to);
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
        let Moment { pair, approach, lower } = &moment;
        let padding = pair.info.padding;
        let (bound, motion) = (approach.within(1.0), approach.motion());
        if lower - padding > bound {
            return Look::Proven { share: 1.0, lower: *lower, bound };
        }
        let unknown = [(lower - padding).max(0.0), f64::INFINITY];
        if motion > WORTH_ASKING {
            return moment.proven(*lower).unwrap_or(Look::Open { distance: unknown, motion });
        }
        // of a distance that padding and tolerances take most of, a share is too much
        let effort = if padding > 0.0 || self.segment.is_loose() {
            Effort { absolute_tolerance: ROUGHLY * motion, ..Effort::default() }
        } else {
            Effort { relative_tolerance: ROUGHLY, ..Effort::default() }
        };
        let limit = bound + padding + CONTACT_DISTANCE;
        let found = pair.separation_bounds(limit, &effort, &mut self.workspace.scratch);
        let Some(near) = found.upper else { return Look::Proven { share: 1.0, lower: limit, bound } };
        if near.distance <= padding.max(CONTACT_DISTANCE) {
            let point = self.checker.in_root(pair, &near.witness_points[0], self.segment, middle);
            return Look::Hit(point, motion);
        }
        let distance = [(found.lower - padding).max(0.0), near.distance - padding];
        moment.proven(found.lower).unwrap_or(Look::Open { distance, motion })
    }

    /// Whether to stop here.
    fn is_over(&mut self) -> bool {
        if self.stopped.is_none() {
            if self.looks > self.options.budget {
                self.stopped = Some(UndecidedReason::Budget);
            } else if self.looks % LOOKS_A_GLANCE == 1
                && self.options.deadline.is_some_and(|deadline| Instant::now() >= deadline)
            {
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
        if let Some(Hit { pair, t, point }) = self.hit {
            return MotionVerdict::Contact { t: [free_until.min(t), t], pair: ids(pair), witness: point };
        }
        match (open, self.stopped) {
            (None, None) => MotionVerdict::Free,
            (open, Some(reason)) => MotionVerdict::Undecided {
                t: [free_until.min(1.0), 1.0],
                pair: open.map(|open| ids(open.piece.pair)),
                distance: open.map_or([0.0, f64::INFINITY], |open| open.distance),
                reason,
            },
            (Some(open), None) => MotionVerdict::Undecided {
                // who may touch within a tolerance ends the search
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
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)] // clamped
fn blocks(fastest: f32) -> usize {
    let intervals = (0.5 * fastest / LEVEL_ZERO_MOTION).min(MOST_INTERVALS as f32);
    (intervals.max(1.0) as usize).div_ceil(LANES)
}

/// Where the run of set bits that begins at a lane ends; `None` if none begins there.
fn run_from(near: u8, lane: usize) -> Option<usize> {
    let begins = near & (1 << lane) != 0 && (lane == 0 || near & (1 << (lane - 1)) == 0);
    begins.then(|| lane + (near >> lane).trailing_ones() as usize)
}
