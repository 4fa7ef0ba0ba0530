//! Contact counter since the start, and summary of contacts and distances since the last heartbeat message.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use clearance_checker::CollisionReport;
use clearance_scene::BodyId;

use super::motion_since_previous::{MotionSincePrevious, NoMotion};
use super::named_pair::{NamedPair, named};
use super::{Evaluation, MonitorSettings, Revision, Status, Time};

/// Contacts counted since the start, and what happened since the last heartbeat message.
#[derive(Clone, Debug, Default)]
pub struct ContactHistory {
    /// Number of contacts that have begun: a pair collides that did not collide before.
    pub begun: u64,
    /// Number of contacts that have ended: the pair does not collide any more.
    pub ended: u64,
    /// Summary of the evaluations since the last heartbeat message.
    pub since_heartbeat: SinceHeartbeat,
    /// Whether this evaluation is one for the heartbeat topic.
    pub is_heartbeat: bool,
    /// Number of the current or next heartbeat message, counted from 1.
    pub heartbeat: u64,
}

/// Summary of the evaluations since the last heartbeat message, the current one included: a slow subscriber receives it instead of them.
#[derive(Clone, Debug)]
pub struct SinceHeartbeat {
    /// Number of evaluations.
    pub evaluations: u32,
    /// Whether each was FREE, and the motion between any two successive states was proven free. It says nothing about the
    /// time after the last state.
    pub all_free: bool,
    /// The least known distance; `None` if none was known.
    pub least: Option<LeastKnown>,
    /// Pairs that collided, or were proven to touch between two states.
    pub touched: Arc<BTreeSet<NamedPair>>,
}

/// The least distance of several evaluations.
#[derive(Clone, Debug, PartialEq)]
pub struct LeastKnown {
    /// The distance (m): 0 if a pair touched, infinite if nothing was within the distance limit.
    pub distance: f64,
    /// Its pair, where the distance is finite.
    pub pair: Option<Arc<NamedPair>>,
    /// Stamp of the state.
    pub stamp: Time,
}

impl Default for SinceHeartbeat {
    fn default() -> Self {
        Self { evaluations: 0, all_free: true, least: None, touched: Arc::default() }
    }
}

impl SinceHeartbeat {
    fn add(&mut self, evaluation: &Evaluation, checks_between_states: bool) {
        self.evaluations = self.evaluations.saturating_add(1);
        let proves_motion = checks_between_states
            && matches!(
                evaluation.motion_since_previous,
                MotionSincePrevious::ProvenFree | MotionSincePrevious::NotChecked(NoMotion::NoNewState)
            );
        self.all_free &= evaluation.status == Status::Free && proves_motion;
        let Some(revision) = &evaluation.revision else { return };
        let report = evaluation.checked_state.as_ref().map(|checked_state| &checked_state.report);
        let colliding = report.and_then(|report| report.colliding_pairs.first().copied());
        let (distance, pair) = match (colliding.or(passed_pair(evaluation)), report) {
            (Some(pair), _) => (0.0, Some(pair)),
            (None, None) => return,
            (None, Some(CollisionReport { nearest: Some(nearest), .. })) => {
                (nearest.distance, Some((nearest.a, nearest.b)))
            }
            (None, Some(_)) => (f64::INFINITY, None),
        };
        if self.least.as_ref().is_none_or(|least| distance < least.distance) {
            let pair = pair.map(|pair| Arc::new(named(pair, &revision.checker)));
            self.least = Some(LeastKnown { distance, pair, stamp: evaluation.stamp.unwrap_or_default() });
        }
    }

    fn touch(&mut self, pair: &NamedPair) {
        if !self.touched.contains(pair) {
            Arc::make_mut(&mut self.touched).insert(pair.clone());
        }
    }
}

/// The pair that is proven to have touched since the previous state, also if the status is UNKNOWN.
fn passed_pair(evaluation: &Evaluation) -> Option<(BodyId, BodyId)> {
    evaluation.motion_since_previous.passed_through()?.pair
}

/// Counts contacts from evaluation to evaluation.
#[derive(Debug, Default)]
pub(super) struct ContactCounter {
    history: ContactHistory,
    /// Pairs in contact.
    open: BTreeSet<NamedPair>,
    /// When the next heartbeat message is due; `None`: at once.
    due: Option<Duration>,
}

impl ContactCounter {
    /// Adds an evaluation that is published at this time (steady clock).
    pub fn add(
        &mut self,
        evaluation: &Evaluation,
        now: Duration,
        settings: &MonitorSettings,
    ) -> ContactHistory {
        if self.history.is_heartbeat || self.history.heartbeat == 0 {
            self.history.since_heartbeat = SinceHeartbeat::default();
            self.history.heartbeat += 1;
        }
        self.history.since_heartbeat.add(evaluation, settings.check_between_states);
        self.count(evaluation);
        self.history.is_heartbeat = self.is_due(now, settings.heartbeat_period());
        self.history.clone()
    }

    /// Whether a heartbeat message is due: in the mean once in each period.
    fn is_due(&mut self, now: Duration, period: Duration) -> bool {
        let due = self.due.unwrap_or(now);
        // a longer period that was set before does not delay the next message
        if now < due.min(now + period) {
            self.due = Some(due.min(now + period));
            return false;
        }
        let next = due + period;
        self.due = Some(if next > now { next } else { now + period });
        true
    }

    /// Contacts of an UNKNOWN state are not known: they neither begin nor end.
    fn count(&mut self, evaluation: &Evaluation) {
        let Some(revision) = &evaluation.revision else { return };
        let name = |pair| named(pair, &revision.checker);
        let passage = passed_pair(evaluation).map(name);
        let Some(checked_state) = &evaluation.checked_state else {
            return self.count_passage(passage, &BTreeSet::new());
        };
        let report = &checked_state.report;
        if report.colliding_pairs.is_empty() && passage.is_none() && self.open.is_empty() {
            return;
        }
        let colliding: BTreeSet<NamedPair> = report.colliding_pairs.iter().copied().map(name).collect();
        self.count_passage(passage, &colliding);
        self.end_contacts(&colliding, revision, report);
        for pair in colliding {
            self.history.since_heartbeat.touch(&pair);
            self.history.begun += u64::from(self.open.insert(pair));
        }
    }

    /// A pair that touched between two states, and at neither, has had a contact of its own.
    fn count_passage(&mut self, pair: Option<NamedPair>, colliding: &BTreeSet<NamedPair>) {
        let Some(pair) = pair else { return };
        self.history.since_heartbeat.touch(&pair);
        if !self.open.contains(&pair) && !colliding.contains(&pair) {
            self.history.begun += 1;
            self.history.ended += 1;
        }
    }

    /// Ends the contacts of pairs that are decided and do not collide.
    fn end_contacts(
        &mut self,
        colliding: &BTreeSet<NamedPair>,
        revision: &Revision,
        report: &CollisionReport,
    ) {
        let undecided = report.undecided.iter().map(|pair| named((pair.a, pair.b), &revision.checker));
        let undecided: BTreeSet<NamedPair> = undecided.collect();
        let before = self.open.len();
        self.open.retain(|pair| colliding.contains(pair) || undecided.contains(pair));
        self.history.ended += (before - self.open.len()) as u64;
    }
}
