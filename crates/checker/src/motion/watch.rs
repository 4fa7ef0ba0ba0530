//! Handle to observe and stop a check from another thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Progress of a check; clones refer to the same check.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    is_stopped: Arc<AtomicBool>,
    segments_free: Arc<AtomicUsize>,
}

impl PartialEq for Watch {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.segments_free, &other.segments_free)
    }
}

impl Watch {
    /// Stops the check soon; it then returns its results so far.
    pub fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    /// Handle of a further check, which stops together with this one and has its own progress.
    #[must_use]
    pub fn of_further_check(&self) -> Self {
        Self { is_stopped: Arc::clone(&self.is_stopped), segments_free: Arc::default() }
    }

    /// True if the check is to stop.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }

    /// Number of segments of the trajectory proven free, from the first on.
    #[must_use]
    pub fn segments_free(&self) -> usize {
        self.segments_free.load(Ordering::Relaxed)
    }

    /// Records the number of segments proven free so far.
    pub(super) fn record_free(&self, segments: usize) {
        self.segments_free.store(segments, Ordering::Relaxed);
    }
}
