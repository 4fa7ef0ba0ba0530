//! What changes from query to query, owned by the caller: one per thread.

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

/// Scratch memory of one thread's queries. Its contents save the next query work, and change no exact answer; given to another
/// checker than it was made by, it becomes that one's.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// The checker that it suits.
    pub(super) checker: u64,
    /// Of the chain's bodies in the root frame.
    pub(super) frames: Vec<PlacedFrame>,
    /// Of the capsules around bodies.
    pub(super) segments: Vec<PlacedSegment>,
    /// For each group of eight pairs, a bit for each that may be near.
    pub(super) near: Vec<u8>,
    /// For each group of eight pairs, numbers (m) never larger than their distances.
    pub(super) bounds: Vec<[f32; LANES]>,
    /// Pairs to ask about.
    pub(super) queue: Vec<QueuedPair>,
    /// What is looked at for the least distance.
    pub(super) nearest_first: NearestFirst,
    /// Pairs with obstacles that were asked about for it.
    pub(super) asked: Vec<usize>,
    /// What is to be measured for it.
    pub(super) in_doubt: Vec<InDoubt>,
    pub(super) part_order: PartOrder,
    pub(super) likely: PairPriority,
    pub(super) nearby: NearbyScratch,
    pub(super) scratch: Scratch,
    /// For motions.
    pub(super) motion: MotionScratch,
    /// For streams of states.
    pub(super) stream: Option<Stream>,
}

impl Workspace {
    /// What is remembered of the last states, if that is about this checker.
    pub(super) fn stream_of(&mut self, checker: u64) -> Option<&mut Stream> {
        self.stream.as_mut().filter(|stream| stream.is_of(checker))
    }
}

/// A pair to ask about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QueuedPair {
    /// Its distance (m) is not less than this.
    pub lower: f64,
    /// In the pair list.
    pub index: usize,
}
