//! Pieces of obstacles, and the two bounding box trees (within the robot's reach, or not) that find those near a part.

use clearance_geometry::simd::{LANES, Level, Simd, dispatch, f32x8};
use clearance_proximity::Piece;
use clearance_proximity::bvh::{AxisBox, Child, DynamicTree, EightBoxes, SelectedBoxes};

use super::reachable_regions::ReachableRegions;
use crate::capsules::{RootCapsule, RootVolume};

/// Numbered pieces; each is stored in one of the trees.
#[derive(Clone, Debug, Default)]
pub struct PieceTrees {
    all: Vec<PlacedPiece>,
    /// Free numbers, of removed pieces.
    unused: Vec<u32>,
    /// By place of an obstacle: the numbers of its pieces.
    of_places: Vec<Vec<u32>>,
    /// Pieces that the robot may reach in expected states.
    reachable: DynamicTree,
    /// Pieces that the robot cannot reach in expected states.
    unreachable: DynamicTree,
    /// Pieces without bounds.
    unbounded: Vec<u32>,
}

/// A piece of the obstacle at a place.
#[derive(Clone, Copy, Debug)]
pub struct PlacedPiece {
    pub place: u32,
    pub piece: Piece,
    /// Bounding volume, grown by the obstacle's padding.
    volume: RootVolume,
}

impl PlacedPiece {
    /// Lower bound (m) on the padded distance to a padded part; NaN is no bound.
    #[inline(always)]
    pub fn lower_bound(&self, part: &RootCapsule) -> f32 {
        self.volume.lower_bound(part)
    }

    /// Bit mask of the eight padded parts that are not proven farther away than `limit` (m).
    #[inline(always)]
    pub fn near<S: Simd>(&self, simd: S, parts: &RootCapsule<f32x8<S>>, limit: f32) -> u8 {
        self.volume.near(simd, parts, limit)
    }
}

/// Boxes around eight parts; bits of `among` select the boxes that are searched for.
#[derive(Clone, Copy, Debug)]
pub struct EightBoxQuery<'q> {
    pub boxes: &'q EightBoxes,
    pub among: u8,
    /// True if all their states are expected: then only the pieces that the robot may reach are searched.
    pub are_expected: bool,
}

/// Bit that marks node numbers of the tree of unreachable pieces.
const UNREACHABLE: u32 = 1 << 31;

/// Where a piece is stored.
#[derive(Clone, Copy, PartialEq)]
enum PieceStore {
    Reachable,
    Unreachable,
    Unbounded,
}

impl PieceStore {
    fn of(volume: &RootVolume, bounds: &AxisBox, regions: &ReachableRegions) -> Self {
        match () {
            () if !bounds.is_bounded() => Self::Unbounded,
            () if regions.may_touch(volume) => Self::Reachable,
            () => Self::Unreachable,
        }
    }
}

/// A piece of an obstacle with its bounding volumes, in the root frame.
#[derive(Clone, Copy, Debug)]
pub struct PieceVolumes {
    pub piece: Piece,
    /// Bounding volume, grown by the obstacle's padding.
    pub volume: RootVolume,
    /// Box around it along the axes of the root frame.
    pub bounds: AxisBox,
}

impl PieceTrees {
    /// The pieces of obstacles by place.
    pub fn new(places: Vec<Vec<PieceVolumes>>, regions: &ReachableRegions) -> Self {
        let mut pieces = Self::default();
        let (mut reachable, mut unreachable) = (Vec::new(), Vec::new());
        for (place, placed) in (0..).zip(places) {
            let numbers = (placed.into_iter())
                .map(|PieceVolumes { piece, volume, bounds }| {
                    let number = pieces.take_number(PlacedPiece { place, piece, volume });
                    match PieceStore::of(&volume, &bounds, regions) {
                        PieceStore::Reachable => reachable.push((number, bounds)),
                        PieceStore::Unreachable => unreachable.push((number, bounds)),
                        PieceStore::Unbounded => pieces.unbounded.push(number),
                    }
                    number
                })
                .collect();
            pieces.of_places.push(numbers);
        }
        (pieces.reachable, pieces.unreachable) =
            (DynamicTree::build(&reachable), DynamicTree::build(&unreachable));
        pieces
    }

    /// Replaces the pieces of the obstacle that was at a place by the pieces of its present obstacle.
    pub fn set(&mut self, place: u32, placed: Vec<PieceVolumes>, regions: &ReachableRegions) {
        let at = place as usize;
        if self.of_places.len() <= at {
            self.of_places.resize(at + 1, Vec::new());
        }
        let mut before = std::mem::take(&mut self.of_places[at]);
        before.reverse();
        let mut numbers = Vec::with_capacity(placed.len());
        for PieceVolumes { piece, volume, bounds } in placed {
            let made = PlacedPiece { place, piece, volume };
            let number = match before.pop() {
                Some(number) => {
                    self.all[number as usize] = made;
                    number
                }
                None => self.take_number(made),
            };
            self.put(number, bounds, PieceStore::of(&volume, &bounds, regions));
            numbers.push(number);
        }
        for number in before {
            self.take_out(number);
            self.unused.push(number);
        }
        self.of_places[at] = numbers;
    }

    #[inline]
    pub fn at(&self, number: u32) -> &PlacedPiece {
        &self.all[number as usize]
    }

    /// Number of pieces that the robot cannot reach in expected states.
    #[cfg(test)]
    pub fn unreachable_count(&self) -> usize {
        self.unreachable.len()
    }

    /// All boxes, each with the number of its piece.
    pub fn boxes(&self) -> Vec<(u32, AxisBox)> {
        [self.reachable.items(), self.unreachable.items()].concat()
    }

    /// Appends the pieces whose boxes overlap a box, and the pieces without bounds, to `found`; returns the number of
    /// boxes tested. `stack` is scratch memory.
    #[inline(always)]
    pub fn find<S: Simd>(&self, simd: S, with: &AxisBox, stack: &mut Vec<u32>, found: &mut Vec<u32>) -> u64 {
        found.extend_from_slice(&self.unbounded);
        let reachable = self.reachable.find_overlapping(simd, with, stack, found);
        reachable + self.unreachable.find_overlapping(simd, with, stack, found)
    }

    /// As above, for those of eight boxes whose bits are set in `among`; each result has a bit mask of the boxes it
    /// overlaps. For an expected state only the pieces that the robot may reach are searched.
    #[inline(always)]
    pub fn find_any<S: Simd>(
        &self,
        simd: S,
        query: EightBoxQuery,
        stack: &mut Vec<(u32, u8)>,
        found: &mut Vec<(u32, u8)>,
    ) -> u64 {
        let EightBoxQuery { boxes, among, are_expected } = query;
        found.extend(self.unbounded.iter().map(|piece| (*piece, among)));
        let reachable =
            self.reachable.find_overlapping_any(simd, SelectedBoxes { boxes, mask: among }, stack, found);
        if are_expected {
            return reachable;
        }
        reachable + self.find_any_unreachable(simd.level(), query, stack, found)
    }

    #[cold]
    #[inline(never)]
    fn find_any_unreachable(
        &self,
        level: Level,
        EightBoxQuery { boxes, among, .. }: EightBoxQuery,
        stack: &mut Vec<(u32, u8)>,
        found: &mut Vec<(u32, u8)>,
    ) -> u64 {
        dispatch!(level, simd => self.unreachable.find_overlapping_any(simd, SelectedBoxes { boxes, mask: among }, stack, found))
    }

    /// Pieces without bounds.
    pub fn unbounded(&self) -> &[u32] {
        &self.unbounded
    }

    /// The root nodes.
    pub fn roots(&self) -> impl Iterator<Item = u32> {
        self.reachable.root().into_iter().chain(self.unreachable.root().map(|node| node | UNREACHABLE))
    }

    /// The children of a node and their boxes.
    pub fn node(&self, number: u32) -> (&EightBoxes, [Child; LANES]) {
        if number & UNREACHABLE == 0 {
            let (boxes, children) = self.reachable.node(number);
            return (boxes, *children);
        }
        let (boxes, children) = self.unreachable.node(number & !UNREACHABLE);
        let unreachable = |child: &Child| match *child {
            Child::Node(node) => Child::Node(node | UNREACHABLE),
            other => other,
        };
        (boxes, children.each_ref().map(unreachable))
    }

    fn put(&mut self, number: u32, bounds: AxisBox, store: PieceStore) {
        if store != PieceStore::Reachable {
            self.reachable.remove(number);
        }
        if store != PieceStore::Unreachable {
            self.unreachable.remove(number);
        }
        self.unbounded.retain(|other| *other != number);
        match store {
            PieceStore::Reachable => self.reachable.set(number, bounds),
            PieceStore::Unreachable => self.unreachable.set(number, bounds),
            PieceStore::Unbounded => self.unbounded.push(number),
        }
    }

    fn take_out(&mut self, number: u32) {
        self.reachable.remove(number);
        self.unreachable.remove(number);
        self.unbounded.retain(|other| *other != number);
    }

    fn take_number(&mut self, piece: PlacedPiece) -> u32 {
        if let Some(number) = self.unused.pop() {
            self.all[number as usize] = piece;
            return number;
        }
        self.all.push(piece);
        u32::try_from(self.all.len() - 1).expect("pieces are counted in 32 bits")
    }
}
