//! Scratch memory of queries, owned by the caller.

use clearance_geometry::simd::{Level, baseline};

use super::Work;
use super::surface_surface::Candidates;
use crate::bvh::{Entry, NodeRef};

/// Scratch memory of one thread's queries: after the first queries they allocate nothing. Between queries only the counters are
/// meaningful.
#[derive(Clone, Debug)]
pub struct Scratch {
    /// What all queries so far have cost.
    pub work: Work,
    pub(super) stack: Vec<Entry>,
    pub(super) starts: Vec<NodeRef>,
    pub(super) candidates: Candidates,
    pub(super) level: Level,
}

impl Default for Scratch {
    /// Uses the best SIMD instructions of this machine.
    fn default() -> Self {
        Self {
            work: Work::default(),
            stack: Vec::new(),
            starts: Vec::new(),
            candidates: Candidates::default(),
            level: Level::new(),
        }
    }
}

impl Scratch {
    #[must_use]
    #[inline]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Uses only the baseline instructions of this architecture. Results are the same, bit by bit.
    #[must_use]
    #[inline]
    pub fn portable() -> Self {
        Self { level: baseline(), ..Self::default() }
    }
}
