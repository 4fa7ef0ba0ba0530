//! Handle to observe and stop a check from another thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Progress of a check; clones refer to the same check.
#[derive(Clone, Debug, Default)]
pub struct Watch(Arc<Watched>);

#[derive(Debug, Default)]
struct Watched {
    is_stopped: AtomicBool,
    segments_free: AtomicUsize,
}

impl PartialEq for Watch {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Watch {
    /// Stops the check soon; it then returns its results so far.
    pub fn stop(&self) {
        self.0.is_stopped.store(true, Ordering::Relaxed);
    }

    /// True if the check is to stop.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.0.is_stopped.load(Ordering::Relaxed)
    }

    /// Number of segments of the trajectory proven free, from the first on.
    #[must_use]
    pub fn segments_free(&self) -> usize {
        self.0.segments_free.load(Ordering::Relaxed)
    }

    /// Records the number of segments proven free so far.
    pub(super) fn record_free(&self, segments: usize) {
        self.0.segments_free.store(segments, Ordering::Relaxed);
    }
}
