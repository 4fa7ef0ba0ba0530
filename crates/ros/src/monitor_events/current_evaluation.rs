//! The last evaluation, shared between threads, and its update to the present time.

use std::sync::{Arc, Mutex, PoisonError};

use clearance_monitor::{Evaluation, Now};
pub use clearance_view::Observer;

/// The last evaluation, for services that evaluate requests about the same robot and world.
pub type CurrentEvaluation = Arc<Mutex<Option<Evaluation>>>;

/// The evaluation, updated to the time `now`: it may have become stale while the monitor was busy.
pub fn newest(current: &CurrentEvaluation, now: Now) -> Option<Evaluation> {
    let evaluation = current.lock().unwrap_or_else(PoisonError::into_inner).clone();
    evaluation.map(|evaluation| evaluation.aged(now))
}
