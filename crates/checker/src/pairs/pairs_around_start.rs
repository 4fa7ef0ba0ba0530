//! Memory of self pairs for states near a start: distances at the start, which prove pairs apart near it, and elements that
//! touched.
//!
//! A pair that is d apart at the start is apart in all states in which one body has moved by less than d in the frame of
//! the other. Pairs that no joint moves need no search at all. Elements that touch in one state often do in others.

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::Extremes;
use clearance_proximity::{Effort, ElementPair, Scratch};
use clearance_robot::PlacedFrame;

use super::checked_pairs::CheckedPairs;
use super::posed_pair::PosedPair;

/// A distance is searched up to this multiple of the distance that proves the present state apart, so that the result lasts
/// for states farther away.
const LOOK_AHEAD: f64 = 2.0;

/// A distance is searched at least up to this (m).
const SHORTEST_LIMIT: f64 = 1e-4;

/// Relative tolerance of distances: a bound that is half as large costs much less.
const TOLERANCE: f64 = 0.5;

/// Number of contacts that are remembered.
const MOST_CONTACTS: usize = 16;

/// Memory of self pairs for states near a start.
#[derive(Clone, Debug)]
pub struct PairsAroundStart {
    /// Poses of the chain's bodies in the root frame, at the start.
    frames: Vec<PlacedFrame>,
    /// By self pair.
    known: Vec<KnownDistance>,
    /// Numbers of self pairs and two of their elements that touched in another state; the latest first.
    contacts: Vec<(usize, ElementPair)>,
}

/// Lower bound (m) on the distance of a pair, without padding.
#[derive(Clone, Copy, Debug)]
enum KnownDistance {
    /// A search up to a larger limit may give a larger bound.
    AtLeast(f64),
    /// Another search is useless; infinite for a pair that is apart in all states.
    About(f64),
}

impl PairsAroundStart {
    /// Nothing is known so far. The frames are the poses of the chain's bodies at the start.
    pub fn new(pairs: &CheckedPairs, frames: &[PlacedFrame]) -> Self {
        let known = vec![KnownDistance::AtLeast(0.0); pairs.self_pairs().count()];
        Self { frames: frames.to_vec(), known, contacts: Vec::new() }
    }

    /// Counts the pairs that do not move as apart in all states. At the start they must be farther apart than the margins of
    /// [`Self::are_within`].
    pub fn leave_out_unless(&mut self, moves: impl Fn(usize) -> bool) {
        for (index, known) in self.known.iter_mut().enumerate() {
            if !moves(index) {
                *known = KnownDistance::About(f64::INFINITY);
            }
        }
    }

    /// True if elements that touched in another state touch at these poses of the bodies.
    pub fn known_elements_touch(
        &mut self,
        pairs: &CheckedPairs,
        frames: &[PlacedFrame],
        scratch: &mut Scratch,
    ) -> bool {
        let touch = |(index, elements): &(usize, ElementPair)| {
            pairs.pair(*index, frames).elements_touch(*elements, scratch).is_some()
        };
        let found = self.contacts.iter().position(touch);
        if let Some(place) = found {
            self.contacts[..=place].rotate_right(1);
        }
        found.is_some()
    }

    /// True if a self pair comes within a margin (m; 0: touches) at these poses of the bodies, padding subtracted; otherwise
    /// it is proven farther apart.
    pub fn are_within(
        &mut self,
        margin: f64,
        (pairs, index): (&CheckedPairs, usize),
        frames: &[PlacedFrame],
        scratch: &mut Scratch,
    ) -> bool {
        if matches!(self.known[index], KnownDistance::About(f64::INFINITY)) {
            return false;
        }
        let pair = pairs.pair(index, frames);
        let at_start = pairs.pair(index, &self.frames);
        let margin_of_bodies = pair.info.padding + margin + CONTACT_DISTANCE;
        let needed = at_start.displacement_to(&pair.pose_ab) + margin_of_bodies;
        if self.lower_bound(index, needed, &at_start, scratch) > needed {
            return false;
        }
        if margin > 0.0 { pair.comes_within(margin, scratch) } else { self.touch(index, &pair, scratch) }
    }

    /// Lower bound (m) on the distance of a pair at the start, without padding; it is searched if it may be larger than
    /// `needed`.
    fn lower_bound(&mut self, index: usize, needed: f64, at_start: &PosedPair, scratch: &mut Scratch) -> f64 {
        let known = &mut self.known[index];
        if matches!(known, KnownDistance::AtLeast(lower) if *lower <= needed) {
            let limit = (LOOK_AHEAD * needed).greater(SHORTEST_LIMIT);
            let effort = Effort { relative_tolerance: TOLERANCE, ..Effort::default() };
            let found = at_start.separation_bounds(limit, &effort, scratch);
            *known = match found.upper {
                Some(_) => KnownDistance::About(found.lower),
                None => KnownDistance::AtLeast(found.lower),
            };
        }
        let (KnownDistance::AtLeast(lower) | KnownDistance::About(lower)) = *known;
        lower
    }

    /// True if a pair touches; its elements are remembered.
    fn touch(&mut self, index: usize, pair: &PosedPair, scratch: &mut Scratch) -> bool {
        let touches = pair.touches(scratch);
        if touches && let Ok((_, Some(elements))) = pair.contact_or_bound(0.0, scratch) {
            self.contacts.truncate(MOST_CONTACTS - 1);
            self.contacts.insert(0, (index, elements));
        }
        touches
    }
}
