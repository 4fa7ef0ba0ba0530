//! Rust part of a `Checker`, which queries use without Python.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use clearance::CollisionChecker;
use clearance_bindings::JointSpace;

/// The library's checker, and the joints of its states. Threads share it.
#[derive(Debug)]
pub struct CheckerCore {
    /// Unique in this process.
    pub id: u64,
    pub checker: CollisionChecker,
    pub space: Arc<JointSpace>,
}

impl CheckerCore {
    pub fn new(checker: CollisionChecker, space: Arc<JointSpace>) -> Arc<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Arc::new(Self { id: NEXT.fetch_add(1, Ordering::Relaxed), checker, space })
    }
}
