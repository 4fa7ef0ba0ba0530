//! Evaluates single pairs of one state: contact and distance, within tolerances and until a deadline.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_proximity::Effort;

use super::queried_state::QueriedState;
use super::stream::Due;
use crate::collision_report::{CollisionReport, PairDistance};
use crate::pairs::{PairMemory, RememberedPair, RoughDistance};
use crate::robot::CandidatePair;

/// Evaluation of the pairs of one state; pairs that a deadline leaves open are added to the report.
pub struct PairEvaluation<'a> {
    pub state: QueriedState<'a>,
    pub effort: &'a Effort,
    pub report: &'a mut CollisionReport,
}

impl PairEvaluation<'_> {
    /// Lower bound on a distance that is reported as `upper`, with the work of this state so far.
    pub fn lower_bound(&self, upper: f64) -> f64 {
        self.effort.lower_after(&self.state.scratch.work, upper)
    }

    /// Result for a pair, with contact decided where a tolerance left it open.
    pub fn decide_contact(&mut self, pair: CandidatePair, found: PairDistance) -> PairDistance {
        if found.lower == found.distance || found.lower > CONTACT_DISTANCE {
            return found;
        }
        if self.effort.deadline.is_none() {
            return match self.contact_or_bound(pair.index, found.distance) {
                Ok(contact) => contact,
                Err(lower) => {
                    PairDistance { lower: lower.greater(f64::MIN_POSITIVE).lesser(found.distance), ..found }
                }
            };
        }
        let open = self.report.undecided.len();
        if self.touches(pair) {
            PairDistance { distance: 0.0, lower: 0.0, ..found }
        } else if self.report.undecided.len() == open {
            PairDistance { lower: f64::MIN_POSITIVE.lesser(found.distance), ..found }
        } else {
            found
        }
    }

    /// True if a padded candidate pair touches; if the deadline passes before this is decided, the pair is undecided.
    pub fn touches(&mut self, CandidatePair { lower, index }: CandidatePair) -> bool {
        let pair = &self.state.pair(index);
        let QueriedState { scratch, stream, .. } = &mut self.state;
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
        match stream {
            Some(stream) => {
                let touches = RememberedPair { pair, memory: stream.memory(index) }.touches(scratch);
                stream.record_bound_of_memory(index, pair);
                touches
            }
            None => pair.touches(scratch),
        }
    }

    /// The padded distance of a candidate pair, unless it is proven larger than `limit`.
    pub fn distance(&mut self, candidate: CandidatePair, limit: f64) -> Option<PairDistance> {
        let CandidatePair { lower, index } = candidate;
        if self.effort.is_exact() {
            return self.exact_distance(candidate, limit);
        }
        if let Some(contact) = self.known_contact(index) {
            return Some(contact);
        }
        if self.attempts_exact_distance(index) {
            return self.distance_within_cost(candidate, limit);
        }
        let exact_within = self.effort.exact_within;
        if exact_within <= 0.0 || lower > exact_within || self.effort.deadline.is_some() {
            return self.distance_within_tolerance(candidate, limit);
        }
        let near = self.exact_distance(candidate, exact_within.lesser(limit));
        if near.is_some() || limit <= exact_within {
            return near;
        }
        self.distance_within_tolerance(CandidatePair { lower: exact_within, index }, limit)
    }

    fn exact_distance(&mut self, candidate: CandidatePair, limit: f64) -> Option<PairDistance> {
        let index = candidate.index;
        let pair = &self.state.pair(index);
        let QueriedState { scratch, stream, .. } = &mut self.state;
        // rounded up, so that of equally near ones none is left out
        let limit = (limit + pair.info.padding).next_up();
        let found = match stream {
            Some(stream) => {
                let exact_cost = self.effort.exact_cost;
                let mut remembered = RememberedPair { pair, memory: stream.memory(index) };
                let found = remembered.separation(limit, exact_cost, scratch);
                stream.record_bound_of_memory(index, pair);
                let effort = Effort { exact_cost, ..Effort::default() };
                stream.record_due(Due { index, limit, effort });
                found
            }
            None => pair.separation(limit, scratch),
        };
        Some(pair.reported(&found?, scratch))
    }

    /// Contact of the elements that touched in the last state.
    fn known_contact(&mut self, index: usize) -> Option<PairDistance> {
        // the pair is placed only if needed
        self.state.stream.as_mut()?.memory(index).as_ref().filter(|memory| memory.touched())?;
        let pair = &self.state.pair(index);
        let QueriedState { scratch, stream, .. } = &mut self.state;
        let found = RememberedPair { pair, memory: stream.as_mut()?.memory(index) }.still_touches(scratch)?;
        Some(pair.padded(&found))
    }

    /// Contact of a pair, or a lower bound on the padded distance of a pair that is apart; `near` (m) is an upper bound.
    fn contact_or_bound(&mut self, index: usize, near: f64) -> Result<PairDistance, f64> {
        let pair = &self.state.pair(index);
        let QueriedState { scratch, stream, .. } = &mut self.state;
        let padding = pair.info.padding;
        let found = match stream {
            Some(stream) => {
                let mut remembered = RememberedPair { pair, memory: stream.memory(index) };
                let found = remembered.contact_or_bound(near + padding, scratch);
                stream.record_bound_of_memory(index, pair);
                found
            }
            None => pair.contact_or_bound(near + padding, scratch).map(|(contact, _)| contact),
        };
        found.map(|contact| pair.padded(&contact)).map_err(|lower| lower - padding)
    }

    /// True if the state has cost so little that a pair is measured exactly, unless this is known to be useless.
    fn attempts_exact_distance(&mut self, index: usize) -> bool {
        let QueriedState { scratch, stream, .. } = &mut self.state;
        self.effort.deadline.is_none()
            && self.effort.exact_cost > 0
            && scratch.work.cost() < self.effort.exact_cost
            && stream
                .as_mut()
                .and_then(|stream| stream.memory(index).as_mut())
                .is_none_or(PairMemory::attempts_exact_distance)
    }

    /// As [`Self::exact_distance`], but within the tolerances once the state has cost too much.
    fn distance_within_cost(&mut self, candidate: CandidatePair, limit: f64) -> Option<PairDistance> {
        let index = candidate.index;
        let pair = &self.state.pair(index);
        let effort = &self.raw_effort(pair.info.padding);
        let QueriedState { scratch, stream, .. } = &mut self.state;
        let limit = (limit + pair.info.padding).next_up();
        let found = match stream {
            Some(stream) => {
                let mut remembered = RememberedPair { pair, memory: stream.memory(index) };
                let found = remembered.separation_or_bounds(limit, effort, scratch);
                stream.record_bound_of_memory(index, pair);
                stream.record_due(Due { index, limit, effort: *effort });
                found
            }
            None => pair.separation_or_bounds(limit, effort, scratch),
        };
        match found {
            Ok(exact) => Some(pair.reported(&exact?, scratch)),
            // a distance certainly beyond the limit is not reported: others may be nearer that have only this bound
            Err(RoughDistance { lower, .. }) if lower > limit => None,
            Err(RoughDistance { lower, upper }) => {
                Some(PairDistance { lower: (lower - pair.info.padding).greater(0.0), ..pair.padded(&upper) })
            }
        }
    }

    fn distance_within_tolerance(
        &mut self,
        CandidatePair { lower, index }: CandidatePair,
        limit: f64,
    ) -> Option<PairDistance> {
        let pair = &self.state.pair(index);
        if self.effort.is_over() {
            self.report.undecided.push(pair.undecided(lower + pair.info.padding, None));
            return None;
        }
        let effort = &Effort { exact_cost: 0, ..self.raw_effort(pair.info.padding) };
        let QueriedState { scratch, stream, .. } = &mut self.state;
        let limit = (limit + pair.info.padding).greater(CONTACT_DISTANCE);
        let found = match stream {
            Some(stream) => {
                // bounds below zero were cut off there
                let certain =
                    if lower > 0.0 { (lower + pair.info.padding).next_down() } else { f64::NEG_INFINITY };
                let mut remembered = RememberedPair { pair, memory: stream.memory(index) };
                let found = remembered.separation_bounds(certain, limit, effort, scratch);
                stream.record_bound(index, found.lower - pair.info.padding);
                stream.record_due(Due { index, limit, effort: *effort });
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
