//! Evaluates one query on one state: selects candidate pairs, orders them, collects results.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_proximity::Effort;
use clearance_robot::Configuration;
use clearance_scene::BodyId;

use super::collision_checker::CollisionChecker;
use super::memory::Memory;
use super::pair::Roughly;
use super::report::{CollisionReport, PairDistance, Question};
use super::stream::Due;
use super::workspace::{QueuedPair, Workspace};

/// One query on one state, with the results so far.
pub(super) struct StateQuery<'a> {
    pub checker: &'a CollisionChecker,
    pub q: &'a Configuration,
    pub effort: &'a Effort,
    pub workspace: &'a mut Workspace,
    pub report: &'a mut CollisionReport,
}

impl StateQuery<'_> {
    pub fn answer(&mut self, question: Question) {
        match question {
            Question::Free => self.first_hits(),
            Question::Pairs => self.all_hits(),
            Question::Distance { limit } => {
                self.least_distance(limit);
                // touching pairs are searched for where there are any
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

    /// The first colliding pair of robot bodies, and the first of a robot body and an obstacle.
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

    /// Every pair's distance up to `limit`.
    fn distances(&mut self, limit: f64) {
        // touching pairs are within any limit
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

    /// Lower bound on a distance that is reported as `upper`, with the work of this state so far.
    pub fn certain(&self, upper: f64) -> f64 {
        self.effort.lower_after(&self.workspace.scratch.work, upper)
    }

    /// Result for a pair, with contact decided where a tolerance left it open.
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

    /// True if a padded pair of the queue touches; if the deadline passes before this is decided, the pair is undecided.
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
    pub fn distance(&mut self, queued: QueuedPair, limit: f64) -> Option<PairDistance> {
        let QueuedPair { lower, index } = queued;
        if self.effort.is_exact() {
            return self.exact_distance(queued, limit);
        }
        if self.tries_exactly(index) {
            return self.distance_while_exact(queued, limit);
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
        // rounded up, so that of equally near ones none is left out
        let limit = (limit + pair.info.padding).next_up();
        let found = match stream.as_mut().filter(|s| s.is_of(self.checker.revision)) {
            Some(stream) => {
                let exact_cost = self.effort.exact_cost;
                let found = pair.separation_remembering((limit, exact_cost), stream.memory(index), scratch);
                stream.learn_from_memory(index, &pair);
                let effort = Effort { exact_cost, ..Effort::default() };
                stream.note_due(Due { index, limit, effort });
                found
            }
            None => pair.separation(limit, scratch),
        };
        Some(pair.told(&found?, scratch))
    }

    /// True if the state has cost so little that a pair is measured exactly, unless this is known to be useless.
    fn tries_exactly(&mut self, index: usize) -> bool {
        let Workspace { scratch, stream, .. } = &mut *self.workspace;
        let stream = stream.as_mut().filter(|s| s.is_of(self.checker.revision));
        self.effort.deadline.is_none()
            && self.effort.exact_cost > 0
            && scratch.work.cost() < self.effort.exact_cost
            && stream.and_then(|s| s.memory(index).as_mut()).is_none_or(Memory::tries_exactly)
    }

    /// As [`Self::exact_distance`], but within the tolerances once the state has cost too much.
    fn distance_while_exact(&mut self, queued: QueuedPair, limit: f64) -> Option<PairDistance> {
        let index = queued.index;
        let pair = self.checker.pair(index, &self.workspace.frames);
        let effort = &self.raw_effort(pair.info.padding);
        let Workspace { scratch, stream, .. } = &mut *self.workspace;
        let limit = (limit + pair.info.padding).next_up();
        let found = match stream.as_mut().filter(|s| s.is_of(self.checker.revision)) {
            Some(stream) => {
                let found = pair.separation_remembering_while(limit, effort, stream.memory(index), scratch);
                stream.learn_from_memory(index, &pair);
                stream.note_due(Due { index, limit, effort: *effort });
                found
            }
            None => pair.separation_while(limit, effort, scratch),
        };
        match found {
            Ok(exact) => Some(pair.told(&exact?, scratch)),
            // a distance certainly beyond the limit is not reported: others may be nearer that have only this bound
            Err(Roughly { lower, .. }) if lower > limit => None,
            Err(Roughly { lower, upper }) => {
                Some(PairDistance { lower: (lower - pair.info.padding).greater(0.0), ..pair.padded(&upper) })
            }
        }
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
        let effort = &Effort { exact_cost: 0, ..self.raw_effort(pair.info.padding) };
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

    /// Search options for bodies without the padding that is excluded from their reported distance.
    fn raw_effort(&self, padding: f64) -> Effort {
        let exact_within = self.effort.exact_within;
        Effort { exact_within: if exact_within > 0.0 { exact_within + padding } else { 0.0 }, ..*self.effort }
    }
}

impl CollisionReport {
    /// True if a collision with the same kind of body as `other` was already found.
    fn hits_like(&self, other: BodyId) -> bool {
        match other {
            BodyId::Link(_) | BodyId::Attached(_) => self.self_collision,
            BodyId::Obstacle(_) => self.world_collision,
        }
    }

    /// Where two methods could differ, contact takes precedence.
    fn believe_contact(&mut self) {
        if let Some(touching) = self.nearest.filter(|n| n.distance == 0.0)
            && !self.hits_like(touching.b)
        {
            self.add_hit((touching.a, touching.b));
        }
    }

    /// Records a lower bound (m) on the distances of free pairs, for what tolerances left open.
    fn nearest_beyond(&mut self, beyond: f64) {
        let is_free = self.is_free();
        if let Some(nearest) = self.nearest.as_mut().filter(|_| is_free) {
            let least = beyond.greater(f64::MIN_POSITIVE).lesser(nearest.distance);
            nearest.lower = nearest.lower.greater(least);
        }
    }

    fn add_hit(&mut self, pair: (BodyId, BodyId)) {
        match pair.1 {
            BodyId::Link(_) | BodyId::Attached(_) => self.self_collision = true,
            BodyId::Obstacle(_) => self.world_collision = true,
        }
        self.colliding_pairs.push(pair);
    }
}
