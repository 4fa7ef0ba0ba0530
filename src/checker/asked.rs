//! One state that something is asked about: what is looked at, in which order, and what is found.

use super::collision_checker::CollisionChecker;
use super::nearby::Near;
use super::nearest_first::QueuedNear;
use super::report::{Body, CollisionReport, PairDistance, Question};
use super::stream::Due;
use super::workspace::{QueuedPair, Workspace};
use crate::constants::CONTACT_DISTANCE;
use crate::math::Extremes;
use crate::query::{Effort, Piece, Scratch};
use crate::robot::Configuration;
use crate::simd::LANES;

/// A state that something is asked about, and what is known so far.
pub(super) struct Asked<'a> {
    pub checker: &'a CollisionChecker,
    pub q: &'a Configuration,
    pub effort: &'a Effort,
    pub workspace: &'a mut Workspace,
    pub report: &'a mut CollisionReport,
}

impl Asked<'_> {
    pub fn answer(&mut self, question: Question) {
        match question {
            Question::Free => self.first_hits(),
            Question::Pairs => self.all_hits(),
            Question::Distance { limit } => {
                self.least_distance(limit);
                // pairs that touch are looked for where there are any
                if self.report.nearest.is_some_and(|nearest| nearest.lower <= CONTACT_DISTANCE) {
                    self.first_hits();
                    self.report.believe_contact();
                    self.report.nearest_beyond(0.0);
                }
            }
            Question::PairDistances { limit } => self.distances(limit),
            Question::Survey { influence_distance, limit } => {
                self.distances(influence_distance);
                if self.report.nearest.is_none() && limit > influence_distance.greater(0.0) {
                    let proven = self.report.undecided.is_empty();
                    self.report.undecided.clear();
                    self.least_distance(limit);
                    self.report.believe_contact();
                    if proven {
                        self.report.nearest_beyond(influence_distance);
                    }
                }
            }
        }
    }

    fn queue(&mut self, limit: f64) {
        self.checker.candidates(self.q, limit, self.workspace);
    }

    /// The first colliding pair of links, and the first of a link and an obstacle.
    fn first_hits(&mut self) {
        self.queue(CONTACT_DISTANCE);
        for k in 0..self.workspace.queue.len() {
            let pair = self.workspace.queue[k];
            let known = if pair.index < self.checker.infos.len() {
                self.report.self_collision
            } else {
                self.report.world_collision
            };
            if !known && self.touches(pair) {
                self.report.add_hit(self.checker.info(pair.index).ids);
            }
        }
    }

    fn all_hits(&mut self) {
        self.queue(CONTACT_DISTANCE);
        for k in 0..self.workspace.queue.len() {
            let pair = self.workspace.queue[k];
            if self.touches(pair) {
                self.report.add_hit(self.checker.info(pair.index).ids);
            }
        }
    }

    /// The least distance of all pairs; what may be nearer is looked at first, and each pair only up to the least so far.
    fn least_distance(&mut self, limit: f64) {
        let limit = limit.greater(CONTACT_DISTANCE);
        let mut queue = std::mem::take(&mut self.workspace.nearest_first);
        queue.clear();
        if self.checker.self_candidates(self.q, limit, self.workspace) {
            for pair in &self.workspace.queue {
                queue.push(QueuedNear { lower: pair.lower, near: Near::Pair(pair.index) });
            }
            if self.checker.pairs().world_len() > 0 {
                self.place_capsules();
            }
            for near in (0..self.checker.riders.len()).flat_map(|part| self.checker.whole_world(part)) {
                queue.push(QueuedNear { lower: 0.0, near });
            }
        }
        self.workspace.asked.clear();
        let mut nearest: Option<(usize, PairDistance)> = None;
        let mut least_lower = f64::INFINITY;
        while let Some(QueuedNear { lower, near }) = queue.pop() {
            let bound = nearest.map_or(limit, |(_, n)| self.effort.lower(n.distance));
            if lower > bound || bound <= 0.0 {
                break;
            }
            let (index, part_and_piece) = match near {
                Near::Boxed { part, piece } => {
                    let found = self.looked_at(part, piece, lower).filter(|found| found.lower <= bound);
                    if let Some(found) = found {
                        queue.push(found);
                    }
                    continue;
                }
                Near::Node { part, node } => {
                    for found in self.opened(part, node).filter(|found| found.lower <= bound) {
                        queue.push(found);
                    }
                    continue;
                }
                Near::Piece { part, piece } => {
                    (self.checker.world_pair(part, self.checker.place_of(piece)), Some((part, piece)))
                }
                Near::Pair(index) => (index, None),
            };
            if !self.is_first(index) {
                continue;
            }
            let found = match part_and_piece.filter(|_| self.asks_pieces()) {
                Some((part, piece)) => self.distance_by_pieces(index, (part, piece), bound),
                None => self.distance(QueuedPair { lower, index }, bound),
            };
            let Some(found) = found else { continue };
            least_lower = found.lower.lesser(least_lower);
            if nearest.is_none_or(|(other, n)| (found.distance, index) < (n.distance, other)) {
                nearest = Some((index, found));
            }
        }
        self.workspace.nearest_first = queue;
        self.report.nearest = nearest.map(|(_, found)| PairDistance {
            // of others it is only known that they are not nearer than the tolerance allows
            lower: least_lower.lesser(self.effort.lower(found.distance).greater(0.0)),
            ..found
        });
    }

    /// Whether a pair, to which several pieces may lead, was not asked before.
    fn is_first(&mut self, index: usize) -> bool {
        let of_parts = index < self.checker.infos.len();
        let first = of_parts || !self.workspace.asked.contains(&index);
        if first && !of_parts {
            self.workspace.asked.push(index);
        }
        first
    }

    /// Whether obstacles are asked by their pieces: tolerances, deadlines and streams are about whole pairs.
    fn asks_pieces(&self) -> bool {
        self.effort.is_exact()
            && !self.workspace.stream.as_ref().is_some_and(|stream| stream.is_of(self.checker.revision))
    }

    /// The padded distance of a pair, unless it is proven larger than `limit`: first of the piece that may be nearest, then of
    /// those that may be nearer.
    fn distance_by_pieces(
        &mut self,
        index: usize,
        (part, piece): (usize, u32),
        limit: f64,
    ) -> Option<PairDistance> {
        let checker = self.checker;
        let pair = checker.pair(index, &self.workspace.frames);
        let ask = |pieces: &[Piece], limit: f64, scratch: &mut Scratch| {
            // rounded up, so that of equal ones none is left out
            let raw = pair.separation_of_pieces(pieces, (limit + pair.info.padding).next_up(), scratch)?;
            Some(pair.padded(&raw))
        };
        let Workspace { frames, scratch, nearby, .. } = &mut *self.workspace;
        let first = ask(&[checker.piece(piece)], limit, scratch);
        let limit = first.map_or(limit, |first| first.distance);
        let capsule = checker.capsule_of(part, &frames[checker.riders[part].body]);
        checker.pieces_near((part, checker.place_of(piece)), &capsule, limit, (scratch, nearby));
        ask(&nearby.pieces, limit, scratch).or(first)
    }

    /// Capsules around all parts, where they are.
    fn place_capsules(&mut self) {
        let Workspace { frames, nearby, .. } = &mut *self.workspace;
        let riders = self.checker.riders.iter().enumerate();
        nearby.capsules.clear();
        nearby
            .capsules
            .extend(riders.map(|(part, rider)| self.checker.capsule_of(part, &frames[rider.body])));
    }

    /// What to ask of a piece of the world.
    fn looked_at(&mut self, part: usize, piece: u32, known: f64) -> Option<QueuedNear> {
        let Workspace { nearby, scratch, .. } = &mut *self.workspace;
        scratch.work.volume_tests += 1;
        let (lower, near) = self.checker.looked_at(part, piece, &nearby.capsules[part])?;
        Some(QueuedNear { lower: lower.greater(known), near })
    }

    /// What a node of the tree of pieces holds.
    fn opened(&mut self, part: usize, node: u32) -> impl Iterator<Item = QueuedNear> + use<> {
        let Workspace { nearby, scratch, .. } = &mut *self.workspace;
        scratch.work.volume_tests += LANES as u64;
        let opened = self.checker.opened(part, node, (&nearby.capsules[part], scratch.level()));
        opened.map(|(lower, near)| QueuedNear { lower: lower.greater(0.0), near })
    }

    /// Every pair's distance up to `limit`.
    fn distances(&mut self, limit: f64) {
        // what touches is within any limit
        let limit = limit.greater(0.0);
        self.queue(limit);
        for k in 0..self.workspace.queue.len() {
            let pair = self.workspace.queue[k];
            let Some(found) = self.distance(pair, limit) else { continue };
            let found = self.decided(pair, found);
            if found.distance == 0.0 {
                self.report.add_hit(self.checker.info(pair.index).ids);
            }
            if self.report.nearest.is_none_or(|n| found.distance < n.distance) {
                self.report.nearest = Some(found);
            }
            self.report.pair_distances.push(found);
        }
    }

    /// What was found of a pair, with contact decided where a tolerance left it open.
    fn decided(&mut self, pair: QueuedPair, found: PairDistance) -> PairDistance {
        if found.lower == found.distance || found.lower > CONTACT_DISTANCE {
            return found;
        }
        let open = self.report.undecided.len();
        if self.touches(pair) {
            let exact = if self.effort.deadline.is_none() { self.exact_distance(pair, 0.0) } else { None };
            let witness_points = exact.map_or(found.witness_points, |exact| exact.witness_points);
            PairDistance { distance: 0.0, lower: 0.0, witness_points, ..found }
        } else if self.report.undecided.len() == open {
            PairDistance { lower: f64::MIN_POSITIVE.lesser(found.distance), ..found }
        } else {
            found
        }
    }

    /// Whether a padded pair of the queue touches; if the deadline comes before that is known, the pair is undecided.
    pub fn touches(&mut self, QueuedPair { lower, index }: QueuedPair) -> bool {
        let Workspace { frames, scratch, stream, .. } = &mut *self.workspace;
        let pair = self.checker.pair(index, frames);
        if self.effort.deadline.is_some() {
            let over = self.effort.is_over();
            let found = (!over).then(|| pair.contact_bounds(self.effort, scratch));
            let touches = found.is_some_and(|found| found.upper.is_some());
            if over || found.is_some_and(|found| found.interrupted) {
                let lower = found.map_or(lower + pair.info.padding, |found| found.lower);
                self.report.undecided.push(pair.undecided(lower, None));
            }
            return touches;
        }
        match stream.as_mut().filter(|s| s.is_of(self.checker.revision)) {
            Some(stream) => {
                let touches = pair.touches_remembering(stream.memory(index), scratch);
                stream.learn_from_memory(index, &pair);
                touches
            }
            None => pair.touches(scratch),
        }
    }

    /// The padded distance of a pair of the queue, unless it is proven larger than `limit`.
    fn distance(&mut self, queued: QueuedPair, limit: f64) -> Option<PairDistance> {
        let QueuedPair { lower, index } = queued;
        if self.effort.is_exact() {
            return self.exact_distance(queued, limit);
        }
        let exact_within = self.effort.exact_within;
        if exact_within <= 0.0 || lower > exact_within || self.effort.deadline.is_some() {
            return self.distance_with_effort(queued, limit);
        }
        let near = self.exact_distance(queued, exact_within.lesser(limit));
        if near.is_some() || limit <= exact_within {
            return near;
        }
        self.distance_with_effort(QueuedPair { lower: exact_within, index }, limit)
    }

    fn exact_distance(&mut self, queued: QueuedPair, limit: f64) -> Option<PairDistance> {
        let index = queued.index;
        let Workspace { frames, scratch, stream, .. } = &mut *self.workspace;
        let pair = self.checker.pair(index, frames);
        // rounded up, so that of equal ones none is left out
        let limit = (limit + pair.info.padding).next_up();
        let found = match stream.as_mut().filter(|s| s.is_of(self.checker.revision)) {
            Some(stream) => {
                let found = pair.separation_remembering(limit, stream.memory(index), scratch);
                stream.learn_from_memory(index, &pair);
                found
            }
            None => pair.separation(limit, scratch),
        };
        let raw = found?;
        if raw.distance == 0.0 {
            // which common point is found depends on the limit, which must not tell what was asked before
            return Some(pair.padded(&pair.separation(CONTACT_DISTANCE, scratch).unwrap_or(raw)));
        }
        Some(pair.padded(&raw))
    }

    fn distance_with_effort(
        &mut self,
        QueuedPair { lower, index }: QueuedPair,
        limit: f64,
    ) -> Option<PairDistance> {
        let pair = self.checker.pair(index, &self.workspace.frames);
        if self.effort.is_over() {
            self.report.undecided.push(pair.undecided(lower + pair.info.padding, None));
            return None;
        }
        let effort = &self.raw_effort(pair.info.padding);
        let Workspace { scratch, stream, .. } = &mut *self.workspace;
        let limit = (limit + pair.info.padding).greater(CONTACT_DISTANCE);
        let found = match stream.as_mut().filter(|s| s.is_of(self.checker.revision)) {
            Some(stream) => {
                let memory = stream.memory(index);
                // bounds below zero were cut off there
                let certain =
                    if lower > 0.0 { (lower + pair.info.padding).next_down() } else { f64::NEG_INFINITY };
                let found = pair.separation_bounds_remembering((certain, limit), effort, memory, scratch);
                stream.learn(index, found.lower - pair.info.padding);
                stream.note_due(Due { index, limit, effort: *effort });
                found
            }
            None => pair.separation_bounds(limit, effort, scratch),
        };
        if found.interrupted {
            self.report.undecided.push(pair.undecided(found.lower, found.upper.map(|upper| upper.distance)));
        }
        let upper = found.upper.filter(|_| found.lower <= limit)?;
        Some(PairDistance { lower: (found.lower - pair.info.padding).greater(0.0), ..pair.padded(&upper) })
    }

    /// The effort for bodies without the padding that their distance is told without.
    fn raw_effort(&self, padding: f64) -> Effort {
        let exact_within = self.effort.exact_within;
        Effort { exact_within: if exact_within > 0.0 { exact_within + padding } else { 0.0 }, ..*self.effort }
    }
}

impl CollisionReport {
    /// Whether a collision with the same kind of body as `other` is known.
    fn hits_like(&self, other: Body) -> bool {
        match other {
            Body::Link(_) | Body::Attached(_) => self.self_collision,
            Body::Obstacle(_) => self.world_collision,
        }
    }

    /// Where two methods could differ, the one that saw contact is believed.
    fn believe_contact(&mut self) {
        if let Some(touching) = self.nearest.filter(|n| n.distance == 0.0)
            && !self.hits_like(touching.b)
        {
            self.add_hit((touching.a, touching.b));
        }
    }

    /// Notes that what is free is farther apart than this (m), whatever tolerances left open.
    fn nearest_beyond(&mut self, beyond: f64) {
        let is_free = self.is_free();
        if let Some(nearest) = self.nearest.as_mut().filter(|_| is_free) {
            let least = beyond.greater(f64::MIN_POSITIVE).lesser(nearest.distance);
            nearest.lower = nearest.lower.greater(least);
        }
    }

    fn add_hit(&mut self, pair: (Body, Body)) {
        match pair.1 {
            Body::Link(_) | Body::Attached(_) => self.self_collision = true,
            Body::Obstacle(_) => self.world_collision = true,
        }
        self.colliding_pairs.push(pair);
    }
}
