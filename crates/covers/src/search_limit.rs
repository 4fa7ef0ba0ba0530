//! Search limit: ends a search at a deadline or on request.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// When a search ends early: at a deadline, or when [`Self::stop`] is called on any copy. The default ends no search.
///
/// A search that ends early returns the best cover that is proven so far.
#[derive(Clone, Debug, Default)]
pub struct SearchLimit {
    deadline: Option<Instant>,
    is_stopped: Arc<AtomicBool>,
    /// Number of calls of [`Self::is_over`] that return false, for tests that end a search at every place.
    #[cfg(test)]
    calls_left: Option<Arc<std::sync::atomic::AtomicUsize>>,
}

impl SearchLimit {
    /// A limit that ends searches at this time.
    #[must_use]
    pub fn until(deadline: Instant) -> Self {
        Self { deadline: Some(deadline), ..Self::default() }
    }

    /// A limit that ends searches after a number of calls of [`Self::is_over`].
    #[cfg(test)]
    pub fn after(calls: usize) -> Self {
        let calls_left = Some(Arc::new(std::sync::atomic::AtomicUsize::new(calls)));
        Self { deadline: None, is_stopped: Arc::default(), calls_left }
    }

    /// Ends the searches that have a copy of this limit.
    pub fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    /// True if searches have to end.
    #[must_use]
    pub fn is_over(&self) -> bool {
        #[cfg(test)]
        if let Some(left) = &self.calls_left {
            return left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1)).is_err();
        }
        self.is_stopped.load(Ordering::Relaxed)
            || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// True if time ends searches.
    pub(crate) fn has_deadline(&self) -> bool {
        #[cfg(test)]
        if self.calls_left.is_some() {
            return true;
        }
        self.deadline.is_some()
    }

    /// The time at which searches have to end.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    /// A limit after this part of the time that is left, stopped by the same request.
    pub(crate) fn part(&self, part: f64) -> Self {
        let mut limit = self.clone();
        if let Some(deadline) = self.deadline {
            let now = Instant::now();
            limit.deadline = Some(now + deadline.saturating_duration_since(now).mul_f64(part));
        }
        #[cfg(test)]
        if let Some(left) = &self.calls_left {
            #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let part = (left.load(Ordering::Relaxed) as f64 * part) as usize;
            limit.calls_left = Some(Arc::new(part.into()));
        }
        limit
    }
}
