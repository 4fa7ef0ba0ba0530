//! What changes from query to query, owned by the caller: one per thread.

use crate::robot::LinkPoses;

/// Scratch memory of one thread's queries. Its contents mean nothing to the next query but save it allocations.
#[derive(Clone, Debug)]
pub struct Workspace {
    pub(super) poses: LinkPoses,
    /// Pairs in the order in which distances are asked: lower bound (m), index in the pair list.
    pub(super) queue: Vec<(f64, usize)>,
}
