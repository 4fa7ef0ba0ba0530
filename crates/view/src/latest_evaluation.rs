//! Slot with the last evaluation, exchanged without a lock: a slow reader receives only the newest one.

use std::time::Instant;

use arc_swap::{ArcSwapOption, Guard};
use clearance_monitor::{Evaluation, MonitorSettings};

/// An evaluation and its time.
#[derive(Debug)]
pub struct TimedEvaluation {
    pub evaluation: Evaluation,
    pub at: Instant,
    /// Settings in use: they define when the evaluation is stale, and the latest time of the next one.
    pub settings: MonitorSettings,
}

/// Slot with the last evaluation.
#[derive(Debug, Default)]
pub struct EvaluationSlot(ArcSwapOption<TimedEvaluation>);

impl EvaluationSlot {
    /// Stores an evaluation.
    pub fn put(&self, evaluation: &Evaluation, settings: &MonitorSettings) {
        let timed_evaluation = TimedEvaluation {
            evaluation: evaluation.clone(),
            at: Instant::now(),
            settings: settings.clone(),
        };
        self.0.store(Some(timed_evaluation.into()));
    }

    pub fn last(&self) -> Guard<Option<std::sync::Arc<TimedEvaluation>>> {
        self.0.load()
    }
}
