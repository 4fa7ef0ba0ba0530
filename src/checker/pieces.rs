//! The world in pieces, and the tree by which those near a part are found.

use super::root_volume::{RootCapsule, RootVolume};
use crate::bvh::{AxisBox, DynamicTree};
use crate::query::Piece;
use crate::simd::{Simd, f32x8};

/// Pieces by number, of which each has a place in the tree.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces {
    all: Vec<PlacedPiece>,
    /// Numbers of those that are gone.
    unused: Vec<u32>,
    /// By place of obstacle.
    of_places: Vec<Vec<u32>>,
    pub tree: DynamicTree,
    /// Those that have no bounds.
    pub unbounded: Vec<u32>,
}

/// A piece of the obstacle at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedPiece {
    pub place: u32,
    pub piece: Piece,
    /// With the obstacle's padding.
    volume: RootVolume,
}

impl PlacedPiece {
    /// A number never larger than the padded distance (m) of a padded part; what is no number bounds nothing.
    #[inline(always)]
    pub fn lower_bound(&self, part: &RootCapsule) -> f32 {
        self.volume.lower_bound(part)
    }

    /// A bit for each of eight padded parts that is not proven to be farther away than `limit` (m).
    #[inline(always)]
    pub fn near<S: Simd>(&self, simd: S, parts: &RootCapsule<f32x8<S>>, limit: f32) -> u8 {
        self.volume.near(simd, parts, limit)
    }
}

/// A piece, where it is, and a box around it.
pub(super) type Placed = (Piece, RootVolume, AxisBox);

impl Pieces {
    /// The pieces of obstacles by place.
    pub fn new(places: Vec<Vec<Placed>>) -> Self {
        let mut pieces = Self::default();
        let mut items = Vec::new();
        for (place, placed) in (0..).zip(places) {
            let numbers = (placed.into_iter())
                .map(|(piece, volume, bounds)| {
                    let number = pieces.take_number(PlacedPiece { place, piece, volume });
                    if bounds.is_bounded() {
                        items.push((number, bounds));
                    } else {
                        pieces.unbounded.push(number);
                    }
                    number
                })
                .collect();
            pieces.of_places.push(numbers);
        }
        pieces.tree = DynamicTree::build(&items);
        pieces
    }

    /// Puts the pieces of what is now at a place where those of what was there are.
    pub fn set(&mut self, place: u32, placed: Vec<Placed>) {
        let at = place as usize;
        if self.of_places.len() <= at {
            self.of_places.resize(at + 1, Vec::new());
        }
        let mut before = std::mem::take(&mut self.of_places[at]);
        before.reverse();
        let mut numbers = Vec::with_capacity(placed.len());
        for (piece, volume, bounds) in placed {
            let made = PlacedPiece { place, piece, volume };
            let number = match before.pop() {
                Some(number) => {
                    self.all[number as usize] = made;
                    number
                }
                None => self.take_number(made),
            };
            self.put(number, bounds);
            numbers.push(number);
        }
        for number in before {
            self.tree.remove(number);
            self.unbounded.retain(|other| *other != number);
            self.unused.push(number);
        }
        self.of_places[at] = numbers;
    }

    #[inline]
    pub fn at(&self, number: u32) -> &PlacedPiece {
        &self.all[number as usize]
    }

    fn put(&mut self, number: u32, bounds: AxisBox) {
        self.unbounded.retain(|other| *other != number);
        if bounds.is_bounded() {
            self.tree.set(number, bounds);
        } else {
            self.tree.remove(number);
            self.unbounded.push(number);
        }
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
