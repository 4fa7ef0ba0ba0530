//! Revision number of a checker or a world, unique in the process.

use std::sync::atomic::{AtomicU64, Ordering};

/// Unique in this process: equal revisions mean equal content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Revision(u64);

impl Revision {
    /// A revision that was never used before.
    pub fn next() -> Self {
        static USED: AtomicU64 = AtomicU64::new(0);
        Self(USED.fetch_add(1, Ordering::Relaxed))
    }
}
