//! Evaluates one query on one state: selects candidate pairs, orders them, collects results.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;

use super::least_distance::least_distance;
use super::nearest_search::DistanceScratch;
use super::pair_evaluation::PairEvaluation;
use crate::collision_report::{PairDistance, UndecidedPair};
use crate::pair_kind::{PairKind, SearchedPairs};
use crate::question::Question;

/// One query on one state, with the results so far.
pub struct StateQuery<'a> {
    pub evaluation: PairEvaluation<'a>,
    pub distance: &'a mut DistanceScratch,
}

impl StateQuery<'_> {
    /// Writes the results to the report, and updates the memory of a stream.
    pub fn evaluate(mut self, question: Question) {
        match question {
            Question::Free => self.first_collisions(SearchedPairs::All),
            Question::Pairs => self.all_collisions(),
            Question::Distance { limit } => self.least_distance_and_contact(SearchedPairs::All, limit),
            Question::SelfAndWorldDistance { limit } => {
                for kind in PairKind::ALL {
                    self.least_distance_and_contact(SearchedPairs::Only(kind), limit);
                }
                self.evaluation.report.set_nearest_of_both_kinds();
            }
            Question::PairDistances { limit } => self.distances(limit),
            Question::Survey { influence_distance, limit } => {
                self.distances(influence_distance);
                if limit > influence_distance.greater(0.0) {
                    self.distances_beyond(influence_distance, limit);
                }
            }
        }
        self.finish();
    }

    /// True if any pair touches; updates the memory of a stream.
    pub fn any_contact(mut self) -> bool {
        self.evaluation.state.queue_candidates(SearchedPairs::All, CONTACT_DISTANCE);
        let count = self.evaluation.state.candidates.len();
        let hit = (0..count).any(|k| self.evaluation.touches(self.evaluation.state.candidates[k]));
        self.finish();
        hit
    }

    fn finish(self) {
        if let Some(stream) = self.evaluation.state.stream {
            stream.apply_bounds();
        }
    }

    /// The least distance of some of the pairs, and the first collisions among them if it proves no contact impossible.
    fn least_distance_and_contact(&mut self, pairs: SearchedPairs, limit: f64) {
        self.least_distance(pairs, limit);
        // touching pairs are searched for where there are any
        if self.evaluation.report.nearest_mut(pairs).is_some_and(|nearest| nearest.lower <= CONTACT_DISTANCE)
        {
            self.first_collisions(pairs);
            self.evaluation.report.include_contact_of_nearest(pairs);
            self.evaluation.report.raise_nearest_lower_bound(pairs, 0.0);
        }
    }

    fn least_distance(&mut self, pairs: SearchedPairs, limit: f64) {
        let nearest = least_distance(&mut self.evaluation, self.distance, pairs, limit);
        *self.evaluation.report.nearest_mut(pairs) = nearest;
    }

    /// Completes the least distances after all distances up to `influence_distance` (m): searches each kind of pairs that
    /// has none so far, up to `limit` (m).
    fn distances_beyond(&mut self, influence_distance: f64, limit: f64) {
        let report = &mut *self.evaluation.report;
        let is_nearest_known = report.nearest.is_some();
        let undecided = std::mem::take(&mut report.undecided);
        for kind in PairKind::ALL {
            let is_known = self.evaluation.report.nearest_of(kind).is_some();
            if is_known || !self.evaluation.state.pairs.include(kind) {
                continue;
            }
            if is_nearest_known && self.evaluation.effort.is_over() {
                self.evaluation.report.unfinished = Some(kind);
                continue;
            }
            let pairs = SearchedPairs::Only(kind);
            self.least_distance(pairs, limit);
            self.evaluation.report.include_contact_of_nearest(pairs);
            if undecided.is_empty() {
                self.evaluation.report.raise_nearest_lower_bound(pairs, influence_distance);
            }
        }
        if is_nearest_known {
            self.set_apart_what_is_unfinished(undecided);
        } else {
            self.evaluation.report.set_nearest_of_both_kinds();
        }
    }

    /// Where the deadline interrupted the search for the farther kind of pairs, only its least distance is unknown:
    /// restores the pairs that were undecided before.
    fn set_apart_what_is_unfinished(&mut self, undecided: Vec<UndecidedPair>) {
        let report = &mut *self.evaluation.report;
        report.unfinished = report.unfinished.or(report.undecided.first().map(UndecidedPair::kind));
        if let Some(kind) = report.unfinished {
            *report.nearest_mut(SearchedPairs::Only(kind)) = None;
        }
        report.undecided = undecided;
    }

    /// Among some of the pairs: the first colliding pair of robot bodies, and the first of a robot body and an obstacle.
    fn first_collisions(&mut self, pairs: SearchedPairs) {
        let evaluation = &mut self.evaluation;
        evaluation.state.queue_candidates(pairs, CONTACT_DISTANCE);
        for k in 0..evaluation.state.candidates.len() {
            let pair = evaluation.state.candidates[k];
            let kind = evaluation.state.pairs.kind(pair.index);
            if !evaluation.report.has_collision(kind) && evaluation.touches(pair) {
                evaluation.report.add_collision(evaluation.state.pairs.info(pair.index).ids);
            }
        }
    }

    fn all_collisions(&mut self) {
        let evaluation = &mut self.evaluation;
        evaluation.state.queue_candidates(SearchedPairs::All, CONTACT_DISTANCE);
        for k in 0..evaluation.state.candidates.len() {
            let pair = evaluation.state.candidates[k];
            if evaluation.touches(pair) {
                evaluation.report.add_collision(evaluation.state.pairs.info(pair.index).ids);
            }
        }
    }

    /// Every pair's distance up to `limit`.
    fn distances(&mut self, limit: f64) {
        // touching pairs are within any limit
        let limit = limit.greater(0.0);
        let evaluation = &mut self.evaluation;
        evaluation.state.queue_candidates(SearchedPairs::All, limit);
        for k in 0..evaluation.state.candidates.len() {
            let pair = evaluation.state.candidates[k];
            let Some(found) = evaluation.distance(pair, limit) else { continue };
            let found: PairDistance = evaluation.decide_contact(pair, found);
            if found.lower > limit {
                // proven to be beyond the limit after all: others may be nearer that have only this bound
                continue;
            }
            if found.distance == 0.0 {
                evaluation.report.add_collision(evaluation.state.pairs.info(pair.index).ids);
            }
            evaluation.report.note_distance(&found);
            evaluation.report.pair_distances.push(found);
        }
    }
}

#[cfg(test)]
mod tests;
