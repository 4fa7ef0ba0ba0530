//! Evaluates one query on one state: selects candidate pairs, orders them, collects results.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;

use super::least_distance::least_distance;
use super::nearest_search::DistanceScratch;
use super::pair_evaluation::PairEvaluation;
use crate::collision_report::{PairDistance, Question};

/// One query on one state, with the results so far.
pub struct StateQuery<'a> {
    pub evaluation: PairEvaluation<'a>,
    pub distance: &'a mut DistanceScratch,
}

impl StateQuery<'_> {
    /// Writes the results to the report, and updates the memory of a stream.
    pub fn evaluate(mut self, question: Question) {
        match question {
            Question::Free => self.first_collisions(),
            Question::Pairs => self.all_collisions(),
            Question::Distance { limit } => {
                self.least_distance(limit);
                // touching pairs are searched for where there are any
                if self.evaluation.report.nearest.is_some_and(|nearest| nearest.lower <= CONTACT_DISTANCE) {
                    self.first_collisions();
                    self.evaluation.report.include_contact_of_nearest();
                    self.evaluation.report.raise_nearest_lower_bound(0.0);
                }
            }
            Question::PairDistances { limit } => self.distances(limit),
            Question::Survey { influence_distance, limit } => {
                self.distances(influence_distance);
                if self.evaluation.report.nearest.is_none() && limit > influence_distance.greater(0.0) {
                    let proven = self.evaluation.report.undecided.is_empty();
                    self.evaluation.report.undecided.clear();
                    self.least_distance(limit);
                    self.evaluation.report.include_contact_of_nearest();
                    if proven {
                        self.evaluation.report.raise_nearest_lower_bound(influence_distance);
                    }
                }
            }
        }
        self.finish();
    }

    /// True if any pair touches; updates the memory of a stream.
    pub fn any_contact(mut self) -> bool {
        self.evaluation.state.queue_candidates(CONTACT_DISTANCE);
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

    fn least_distance(&mut self, limit: f64) {
        self.evaluation.report.nearest = least_distance(&mut self.evaluation, self.distance, limit);
    }

    /// The first colliding pair of robot bodies, and the first of a robot body and an obstacle.
    fn first_collisions(&mut self) {
        let evaluation = &mut self.evaluation;
        evaluation.state.queue_candidates(CONTACT_DISTANCE);
        for k in 0..evaluation.state.candidates.len() {
            let pair = evaluation.state.candidates[k];
            let known = if evaluation.state.pairs.is_self_pair(pair.index) {
                evaluation.report.self_collision
            } else {
                evaluation.report.world_collision
            };
            if !known && evaluation.touches(pair) {
                evaluation.report.add_collision(evaluation.state.pairs.info(pair.index).ids);
            }
        }
    }

    fn all_collisions(&mut self) {
        let evaluation = &mut self.evaluation;
        evaluation.state.queue_candidates(CONTACT_DISTANCE);
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
        evaluation.state.queue_candidates(limit);
        for k in 0..evaluation.state.candidates.len() {
            let pair = evaluation.state.candidates[k];
            let Some(found) = evaluation.distance(pair, limit) else { continue };
            let found: PairDistance = evaluation.decide_contact(pair, found);
            if found.distance == 0.0 {
                evaluation.report.add_collision(evaluation.state.pairs.info(pair.index).ids);
            }
            if evaluation.report.nearest.is_none_or(|n| found.distance < n.distance) {
                evaluation.report.nearest = Some(found);
            }
            evaluation.report.pair_distances.push(found);
        }
    }
}
