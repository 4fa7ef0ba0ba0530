//! Pieces of obstacles, and the bounding box trees that find the pieces near a robot part.

use clearance_geometry::simd::{LANES, Level, Simd, dispatch, f32x8};
use clearance_proximity::Piece;
use clearance_proximity::bvh::{AxisBox, Child, DynamicTree, EightBoxes};

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
    within: DynamicTree,
    /// Pieces that the robot cannot reach in expected states.
    beyond: DynamicTree,
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
const BEYOND: u32 = 1 << 31;

/// Where a piece is stored.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Within,
    Beyond,
    Unbounded,
}

impl Side {
    fn of(volume: &RootVolume, bounds: &AxisBox, reachable: &ReachableRegions) -> Self {
        match () {
            () if !bounds.is_bounded() => Self::Unbounded,
            () if reachable.meets(volume) => Self::Within,
            () => Self::Beyond,
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
    pub fn new(places: Vec<Vec<PieceVolumes>>, reachable: &ReachableRegions) -> Self {
        let mut pieces = Self::default();
        let (mut within, mut beyond) = (Vec::new(), Vec::new());
        for (place, placed) in (0..).zip(places) {
            let numbers = (placed.into_iter())
                .map(|PieceVolumes { piece, volume, bounds }| {
                    let number = pieces.take_number(PlacedPiece { place, piece, volume });
                    match Side::of(&volume, &bounds, reachable) {
                        Side::Within => within.push((number, bounds)),
                        Side::Beyond => beyond.push((number, bounds)),
                        Side::Unbounded => pieces.unbounded.push(number),
                    }
                    number
                })
                .collect();
            pieces.of_places.push(numbers);
        }
        (pieces.within, pieces.beyond) = (DynamicTree::build(&within), DynamicTree::build(&beyond));
        pieces
    }

    /// Replaces the pieces of the obstacle that was at a place by the pieces of its present obstacle.
    pub fn set(&mut self, place: u32, placed: Vec<PieceVolumes>, reachable: &ReachableRegions) {
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
            self.put(number, bounds, Side::of(&volume, &bounds, reachable));
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
    pub fn beyond_count(&self) -> usize {
        self.beyond.len()
    }

    /// All boxes, each with the number of its piece.
    pub fn boxes(&self) -> Vec<(u32, AxisBox)> {
        [self.within.items(), self.beyond.items()].concat()
    }

    /// Appends the pieces whose boxes overlap a box, and the pieces without bounds, to `found`; returns the number of boxes tested.
    /// `stack` is scratch memory.
    #[inline(always)]
    pub fn find<S: Simd>(&self, simd: S, with: &AxisBox, stack: &mut Vec<u32>, found: &mut Vec<u32>) -> u64 {
        found.extend_from_slice(&self.unbounded);
        let within = self.within.find_overlapping(simd, with, stack, found);
        within + self.beyond.find_overlapping(simd, with, stack, found)
    }

    /// As above, for those of eight boxes whose bits are set in `among`; each result has a bit mask of the boxes it overlaps. For an
    /// expected state only the pieces that the robot may reach are searched.
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
        let within = self.within.find_overlapping_any(simd, (boxes, among), stack, found);
        if are_expected {
            return within;
        }
        within + self.find_any_beyond(simd.level(), query, stack, found)
    }

    #[cold]
    #[inline(never)]
    fn find_any_beyond(
        &self,
        level: Level,
        EightBoxQuery { boxes, among, .. }: EightBoxQuery,
        stack: &mut Vec<(u32, u8)>,
        found: &mut Vec<(u32, u8)>,
    ) -> u64 {
        dispatch!(level, simd => self.beyond.find_overlapping_any(simd, (boxes, among), stack, found))
    }

    /// Pieces without bounds.
    pub fn unbounded(&self) -> &[u32] {
        &self.unbounded
    }

    /// The root nodes.
    pub fn roots(&self) -> impl Iterator<Item = u32> {
        self.within.root().into_iter().chain(self.beyond.root().map(|node| node | BEYOND))
    }

    /// The children of a node and their boxes.
    pub fn node(&self, number: u32) -> (&EightBoxes, [Child; LANES]) {
        if number & BEYOND == 0 {
            let (boxes, children) = self.within.node(number);
            return (boxes, *children);
        }
        let (boxes, children) = self.beyond.node(number & !BEYOND);
        let beyond = |child: &Child| match *child {
            Child::Node(node) => Child::Node(node | BEYOND),
            other => other,
        };
        (boxes, children.each_ref().map(beyond))
    }

    fn put(&mut self, number: u32, bounds: AxisBox, side: Side) {
        if side != Side::Within {
            self.within.remove(number);
        }
        if side != Side::Beyond {
            self.beyond.remove(number);
        }
        self.unbounded.retain(|other| *other != number);
        match side {
            Side::Within => self.within.set(number, bounds),
            Side::Beyond => self.beyond.set(number, bounds),
            Side::Unbounded => self.unbounded.push(number),
        }
    }

    fn take_out(&mut self, number: u32) {
        self.within.remove(number);
        self.beyond.remove(number);
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
