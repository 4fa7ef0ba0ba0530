//! The last evaluation, handed over without a lock: whoever is slow sees the newest one, never a queue of old ones.

use std::time::Instant;

use arc_swap::{ArcSwapOption, Guard};
use clearance_monitor::{Evaluation, MonitorSettings};

/// A evaluation and when it was made.
#[derive(Debug)]
pub struct Said {
    pub evaluation: Evaluation,
    pub at: Instant,
    /// What it was made with: when it is stale, and when the next one comes at the latest.
    pub settings: MonitorSettings,
}

/// Holds what was said last.
#[derive(Debug, Default)]
pub struct Slot(ArcSwapOption<Said>);

impl Slot {
    /// Leaves a evaluation here.
    pub fn put(&self, evaluation: &Evaluation, settings: &MonitorSettings) {
        let said = Said { evaluation: evaluation.clone(), at: Instant::now(), settings: settings.clone() };
        self.0.store(Some(said.into()));
    }

    pub fn last(&self) -> Guard<Option<std::sync::Arc<Said>>> {
        self.0.load()
    }
}
