//! Per-thread state of queries, owned by the caller.

use clearance_geometry::simd::LANES;
use clearance_proximity::Scratch;
use clearance_robot::PlacedFrame;

use super::capsules::PlacedSegment;
use super::least_distance::InDoubt;
use super::motion::MotionScratch;
use super::nearby::NearbyScratch;
use super::nearest_first::NearestFirst;
use super::pair_priority::PairPriority;
use super::stream::Stream;
use super::within_reach::PartOrder;

/// Scratch memory of one thread's queries. Its contents save work in the next query and change no exact result. If it is passed to a
/// checker other than its creator, it is adapted to that checker.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Revision of the checker it belongs to.
    pub(super) checker: u64,
    /// Poses of the chain's bodies in the root frame.
    pub(super) frames: Vec<PlacedFrame>,
    /// Segments of the capsules around bodies.
    pub(super) segments: Vec<PlacedSegment>,
    /// For each group of eight pairs, a bit mask of the pairs that may be near.
    pub(super) near: Vec<u8>,
    /// For each group of eight pairs, lower bounds (m) on their distances.
    pub(super) bounds: Vec<[f32; LANES]>,
    /// Pairs to test.
    pub(super) queue: Vec<QueuedPair>,
    /// Queue of the search for the least distance.
    pub(super) nearest_first: NearestFirst,
    /// Pairs with obstacles that this search has already measured.
    pub(super) asked: Vec<usize>,
    /// Candidates that this search measures at the end.
    pub(super) in_doubt: Vec<InDoubt>,
    pub(super) part_order: PartOrder,
    pub(super) likely: PairPriority,
    pub(super) nearby: NearbyScratch,
    pub(super) scratch: Scratch,
    /// Scratch memory for motions.
    pub(super) motion: MotionScratch,
    /// Memory for streams of states.
    pub(super) stream: Option<Stream>,
}

impl Workspace {
    /// The memory of the last states, if it belongs to this checker.
    pub(super) fn stream_of(&mut self, checker: u64) -> Option<&mut Stream> {
        self.stream.as_mut().filter(|stream| stream.is_of(checker))
    }
}

/// A pair to test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QueuedPair {
    /// Lower bound (m) on its distance.
    pub lower: f64,
    /// Index in the pair list.
    pub index: usize,
}
