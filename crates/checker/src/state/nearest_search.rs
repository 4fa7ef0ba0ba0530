//! Best-first search for the nearest pair of a state. The nearest candidates are bounded first, for triangles in single
//! precision. Only candidates that may still be the nearest at the end are measured exactly.

use clearance_geometry::math::Extremes;
use clearance_geometry::simd::LANES;
use clearance_proximity::{Piece, Scratch};

use super::nearest_first_queue::{NearestFirstQueue, QueuedNode};
use super::pair_evaluation::PairEvaluation;
use super::queried_state::QueriedState;
use crate::capsules::RootCapsule;
use crate::collision_report::PairDistance;
use crate::pair_kind::PairKind;
use crate::pairs::{MeasuredPair, PosedPair, PostponedPair, SearchedBodies};
use crate::robot::CandidatePair;
use crate::world::{PartQuery, SearchNode};

/// Scratch memory of the search.
#[derive(Clone, Debug, Default)]
pub struct DistanceScratch {
    queue: NearestFirstQueue,
    /// Pairs with obstacles that this search has already bounded or measured.
    visited: Vec<usize>,
    /// Candidates that this search measures at the end.
    postponed: Vec<PostponedPair>,
    /// By part: its capsule with its padding, in the root frame.
    capsules: Vec<RootCapsule>,
}

/// State of the search: bounds on the least distance.
#[derive(Clone, Copy, Debug)]
struct Least {
    /// Larger distances (m) are not reported.
    limit: f64,
    /// Upper bound (m) on the least distance.
    upper: f64,
    /// The nearest candidate that was measured at the end.
    measured: Option<MeasuredPair>,
    /// The nearest pair that was measured at once or is to be reported; of equally near pairs the first.
    nearest: Option<(usize, PairDistance)>,
    /// Lower bound (m) on the distances of the pairs measured at once.
    lower: f64,
    /// Number of candidates that were bounded so far.
    bounded: usize,
}

/// Elements of a pair among which the nearest are searched.
struct PairElements<'p> {
    /// Number of the pair.
    index: usize,
    pair: &'p PosedPair<'p>,
    /// Some pieces of the obstacle, or `None` for the whole pair.
    pieces: Option<&'p [Piece]>,
}

/// Search for the nearest pair of a placed robot.
pub struct NearestSearch<'s, 'a> {
    evaluation: &'s mut PairEvaluation<'a>,
    scratch: &'s mut DistanceScratch,
    least: Least,
}

impl<'s, 'a> NearestSearch<'s, 'a> {
    /// An empty search; distances beyond `limit` (m) do not matter.
    pub fn new(evaluation: &'s mut PairEvaluation<'a>, scratch: &'s mut DistanceScratch, limit: f64) -> Self {
        scratch.queue.clear();
        scratch.visited.clear();
        scratch.postponed.clear();
        Self { evaluation, scratch, least: Least::within(limit) }
    }

    pub fn evaluation(&mut self) -> &mut PairEvaluation<'a> {
        self.evaluation
    }

    /// Adds the queued self pairs, except one that the search started from.
    pub fn add_self_pairs(&mut self) {
        for pair in &*self.evaluation.state.candidates {
            if self.scratch.visited.contains(&pair.index) {
                continue;
            }
            self.scratch.queue.push(QueuedNode { lower: pair.lower, node: SearchNode::Pair(pair.index) });
        }
    }

    /// Computes the capsules around all parts at their poses, which the search among obstacles uses.
    pub fn place_capsules(&mut self) {
        let QueriedState { pairs, robot, .. } = &self.evaluation.state;
        self.scratch.capsules.clear();
        self.scratch.capsules.extend(pairs.robot().padded_capsules(|body| robot.frame(body)));
    }

    /// Adds all obstacles, for a part.
    pub fn add_obstacles(&mut self, part: usize) {
        for node in self.evaluation.state.pairs.world().search_roots(part) {
            self.scratch.queue.push(QueuedNode { lower: 0.0, node });
        }
    }

    /// Bounds or measures the pairs of which the robot body is inside the obstacle.
    pub fn add_inside(&mut self, bodies: SearchedBodies) {
        self.evaluation.state.find_inside(bodies);
        let inside = std::mem::take(&mut self.evaluation.state.broad_phase.inside);
        for pair in &inside {
            let index = self.evaluation.state.pairs.world().number(*pair);
            if self.postpones() {
                let state = &mut self.evaluation.state;
                let pair = &state.pair(index);
                let elements = PairElements { index, pair, pieces: Some(&[Piece::Inside]) };
                self.least.bound_elements(&elements, state.scratch, &mut self.scratch.postponed);
            } else if self.is_first_visit(index) {
                self.measure_at_once(CandidatePair { lower: 0.0, index });
            }
        }
        self.evaluation.state.broad_phase.inside = inside;
    }

    /// Starts from a pair that was measured before.
    pub fn start_from(&mut self, nearest: MeasuredPair) {
        if !nearest.is_within(self.least.limit) {
            return;
        }
        if self.postpones() {
            (self.least.measured, self.least.upper) = (Some(nearest), nearest.padded);
        } else {
            let found = self.report(&nearest);
            self.least.offer(nearest.index, found);
            self.scratch.visited.push(nearest.index);
        }
    }

    /// Starts from the pair of this kind that was the nearest in the last state of the stream: probably little is nearer
    /// now. The choice among touching pairs depends on the order of the search, so it never starts from one of these.
    pub fn start_from_last_state(&mut self, kind: PairKind) {
        let last = self.evaluation.state.stream.as_ref().and_then(|stream| stream.last_nearest(kind));
        let Some(index) = last.filter(|index| !self.scratch.visited.contains(index)) else { return };
        let found = self.evaluation.distance(CandidatePair { lower: 0.0, index }, self.bound());
        if let Some(found) = found.filter(|found| found.distance > 0.0) {
            self.least.offer(index, found);
            self.scratch.visited.push(index);
        }
    }

    /// Searches the queue, then measures the candidates that may be the nearest.
    pub fn run(&mut self) {
        while let Some(queued) = self.scratch.queue.pop() {
            let bound = self.bound();
            if queued.lower > bound || bound <= 0.0 {
                break;
            }
            self.visit(queued);
        }
        self.measure_postponed();
    }

    /// The nearest candidate that was measured at the end.
    pub fn measured(&self) -> Option<MeasuredPair> {
        self.least.measured
    }

    /// The nearest pair, for the report.
    pub fn nearest(&mut self) -> Option<PairDistance> {
        if let Some(best) = self.least.measured {
            let found = self.report(&best);
            (self.least.lower, self.least.nearest) = (found.lower, Some((best.index, found)));
        }
        let (index, found) = self.least.nearest?;
        let state = &mut self.evaluation.state;
        if let Some(stream) = &mut state.stream {
            stream.record_nearest(state.pairs.kind(index), index);
        }
        Some(PairDistance {
            // for other pairs it is only proven that they are not nearer than the tolerance allows
            lower: self.least.lower.lesser(self.evaluation.lower_bound(found.distance).greater(0.0)),
            ..found
        })
    }

    /// Distances larger than this (m) do not matter.
    pub fn bound(&self) -> f64 {
        let Least { limit, upper, nearest, .. } = self.least;
        let measured = nearest.map_or(limit, |(_, n)| self.evaluation.lower_bound(n.distance));
        measured.lesser(upper)
    }

    /// Expands or bounds a node of the queue.
    fn visit(&mut self, QueuedNode { lower, node }: QueuedNode) {
        let bound = self.bound();
        match node {
            SearchNode::BoxedPiece { part, piece } => {
                let found = self.bounded_piece(part, piece, lower).filter(|found| found.lower <= bound);
                if let Some(found) = found {
                    self.scratch.queue.push(found);
                }
            }
            SearchNode::TreeNode { part, node } => {
                let QueriedState { pairs, scratch, .. } = &mut self.evaluation.state;
                scratch.work.volume_tests += LANES as u64;
                let capsule = &self.scratch.capsules[part];
                let (lowers, children) = pairs.world().node(node, capsule, scratch.level());
                self.scratch.queue.push_children(part, lowers, children);
            }
            SearchNode::Piece { part, piece } => {
                let world = self.evaluation.state.pairs.world();
                let index = world.number(world.pair_with_piece(part, piece));
                if self.is_first_visit(index) {
                    self.bound_or_measure(CandidatePair { lower, index }, Some((part, piece)));
                }
            }
            SearchNode::Pair(index) => {
                if self.evaluation.state.pairs.is_self_pair(index) || self.is_first_visit(index) {
                    self.bound_or_measure(CandidatePair { lower, index }, None);
                }
            }
        }
    }

    /// Bounds the pair, or the part and the obstacle's pieces, that a candidate belongs to; or measures the pair at
    /// once.
    fn bound_or_measure(&mut self, candidate: CandidatePair, nearest: Option<(usize, u32)>) {
        match nearest {
            _ if !self.postpones() => self.measure_at_once(candidate),
            Some((part, piece)) => self.bound_pieces(candidate.index, part, piece),
            None => self.bound_pair(candidate.index),
        }
    }

    /// False if the pair was visited before: several pieces may lead to one pair.
    fn is_first_visit(&mut self, index: usize) -> bool {
        let first = !self.scratch.visited.contains(&index);
        if first {
            self.scratch.visited.push(index);
        }
        first
    }

    /// True if candidates are bounded before any is measured, obstacles piece by piece. Tolerances, deadlines and
    /// streams need pair-by-pair measurement instead.
    fn postpones(&self) -> bool {
        self.evaluation.effort.is_exact() && self.evaluation.state.stream.is_none()
    }

    fn measure_at_once(&mut self, candidate: CandidatePair) {
        let bound = self.bound();
        if let Some(found) = self.evaluation.distance(candidate, bound) {
            self.least.offer(candidate.index, found);
        }
    }

    /// Bounds a whole pair.
    fn bound_pair(&mut self, index: usize) {
        let state = &mut self.evaluation.state;
        let pair = &state.pair(index);
        let elements = PairElements { index, pair, pieces: None };
        self.least.bound_elements(&elements, state.scratch, &mut self.scratch.postponed);
    }

    /// Bounds a part and the pieces of an obstacle: the nearest piece first, then the pieces that may be nearer.
    fn bound_pieces(&mut self, index: usize, part: usize, piece: u32) {
        let Self { evaluation: PairEvaluation { state, .. }, scratch: distance, least } = self;
        let pair = &state.pair(index);
        let world = state.pairs.world();
        let first = world.piece(piece);
        let elements = PairElements { index, pair, pieces: Some(&[first]) };
        least.bound_elements(&elements, state.scratch, &mut distance.postponed);
        let query = PartQuery::new(part, &distance.capsules[part], least.limit.lesser(least.upper));
        let place = world.pair_with_piece(part, piece).place;
        world.find_pieces_near(query, place, state.broad_phase, state.scratch);
        let pieces = &mut state.broad_phase.pieces;
        pieces.retain(|other| *other != first);
        if !pieces.is_empty() {
            let elements = PairElements { index, pair, pieces: Some(pieces) };
            least.bound_elements(&elements, state.scratch, &mut distance.postponed);
        }
    }

    /// Measures the candidates that may be the nearest.
    fn measure_postponed(&mut self) {
        let mut postponed = std::mem::take(&mut self.scratch.postponed);
        postponed.retain(|other| other.lower <= self.least.upper);
        postponed.sort_unstable_by(|p, q| p.lower.total_cmp(&q.lower).then(p.order.cmp(&q.order)));
        let mut best = self.least.measured;
        for candidate in postponed.drain(..) {
            if best.is_some_and(|best| candidate.lower > best.padded) {
                break;
            }
            let measured = self.measure(&candidate);
            if best.is_none_or(|best| measured.is_before(&best)) {
                best = Some(measured);
            }
        }
        self.scratch.postponed = postponed;
        self.least.measured = best.filter(|best| best.is_within(self.least.limit));
    }

    fn measure(&mut self, PostponedPair { order, index, elements, .. }: &PostponedPair) -> MeasuredPair {
        let state = &mut self.evaluation.state;
        let pair = state.pair(*index);
        let (raw, elements) = pair.measure(elements, state.scratch);
        let (padded, padding) = (pair.padded(&raw).distance, pair.info.padding);
        MeasuredPair { padded, padding, raw, elements, index: *index, order: *order }
    }

    /// The reported form of a measured pair.
    fn report(&mut self, best: &MeasuredPair) -> PairDistance {
        let state = &mut self.evaluation.state;
        state.pair(best.index).reported(&best.raw, state.scratch)
    }

    /// The node for a piece of an obstacle whose box has the lower bound `known` (m).
    fn bounded_piece(&mut self, part: usize, piece: u32, known: f64) -> Option<QueuedNode> {
        let QueriedState { pairs, scratch, .. } = &mut self.evaluation.state;
        scratch.work.volume_tests += 1;
        let (robot_body, capsule) = (&pairs.robot()[part], &self.scratch.capsules[part]);
        let (lower, node) = pairs.world().bounded_piece(part, piece, robot_body, capsule)?;
        Some(QueuedNode { lower: lower.greater(known), node })
    }
}

impl Least {
    /// Start of a search; distances beyond `limit` (m) do not matter.
    fn within(limit: f64) -> Self {
        let none = f64::INFINITY;
        Self { limit, upper: none, measured: None, nearest: None, lower: none, bounded: 0 }
    }

    /// Adds a pair that was measured at once.
    fn offer(&mut self, index: usize, found: PairDistance) {
        self.lower = found.lower.lesser(self.lower);
        if self.nearest.is_none_or(|(other, n)| (found.distance, index) < (n.distance, other)) {
            self.nearest = Some((index, found));
        }
    }

    /// Bounds the distance of some elements, and postpones the candidates for the nearest ones.
    fn bound_elements(
        &mut self,
        PairElements { index, pair, pieces }: &PairElements,
        scratch: &mut Scratch,
        postponed: &mut Vec<PostponedPair>,
    ) {
        let (index, padding) = (*index, pair.info.padding);
        // rounded up, so that of equally near ones none is left out
        let limit = (self.limit.lesser(self.upper) + padding).next_up();
        let upper = pair.distance_candidates(*pieces, limit, scratch, |elements| {
            let lower = (elements.lower - padding).next_down().greater(0.0);
            postponed.push(PostponedPair { lower, order: self.bounded, index, elements });
        });
        // a touching padded pair is no nearer than a pair that touches without padding
        let padded = if upper <= padding { 0.0 } else { (upper - padding).next_up() };
        self.upper = self.upper.lesser(padded);
        self.bounded += 1;
    }
}
