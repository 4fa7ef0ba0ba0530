//! Scratch memory of queries, owned by the caller; counts their work and selects their SIMD level.

use clearance_geometry::simd::{Level, baseline};

use super::ties::Ties;
use super::tree_traversal::TreeTraversal;
use super::triangle_candidates::TriangleCandidates;
use super::work::Work;

/// Scratch memory of one thread's queries: after the first queries they allocate nothing. Between queries only the counters are
/// meaningful.
#[derive(Clone, Debug)]
pub struct Scratch {
    /// Cost of all queries so far.
    pub work: Work,
    traversal: TreeTraversal,
    candidates: TriangleCandidates,
    ties: Ties,
}

/// Parts of the scratch memory that a search uses at the same time.
pub(crate) struct ScratchParts<'s> {
    pub work: &'s mut Work,
    pub traversal: &'s mut TreeTraversal,
    pub candidates: &'s mut TriangleCandidates,
    pub ties: &'s mut Ties,
}

impl Default for Scratch {
    /// Uses the best SIMD instructions of this machine.
    fn default() -> Self {
        Self::at(Level::new())
    }
}

impl Scratch {
    /// The SIMD level that queries use.
    #[must_use]
    #[inline]
    pub fn level(&self) -> Level {
        self.traversal.level()
    }

    /// Uses only the baseline instructions of this architecture. Results are the same, bit by bit.
    #[must_use]
    #[inline]
    pub fn portable() -> Self {
        Self::at(baseline())
    }

    fn at(level: Level) -> Self {
        let (work, candidates, ties) = (Work::default(), TriangleCandidates::default(), Ties::default());
        Self { work, traversal: TreeTraversal::new(level), candidates, ties }
    }

    /// Begins a search.
    #[inline]
    pub(crate) fn begin(&mut self) -> ScratchParts<'_> {
        let Self { work, traversal, candidates, ties } = self;
        traversal.begin();
        ScratchParts { work, traversal, candidates, ties }
    }

    /// Whether searches use only the boxes of trees, whatever other volumes they have.
    #[inline]
    pub(crate) fn set_boxes_only(&mut self, boxes_only: bool) {
        self.traversal.set_boxes_only(boxes_only);
    }

    /// The pairs of elements that the last search found as near as the nearest.
    #[inline]
    pub(crate) fn ties(&mut self) -> &mut Ties {
        &mut self.ties
    }

    /// The pairs of triangles that a search left to the caller.
    #[inline]
    pub(crate) fn candidates(&mut self) -> &mut TriangleCandidates {
        &mut self.candidates
    }
}
