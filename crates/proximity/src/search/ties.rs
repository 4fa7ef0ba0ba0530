//! Ties: pairs of elements that are as near as the nearest pair, within a tolerance.

use clearance_geometry::math::Extremes;

use crate::elements::ElementPair;
use crate::narrow_phase::Separation;

/// Tolerance within which a distance counts as equal to the least distance; the larger of the two applies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TieTolerance {
    /// Relative to the least distance.
    pub relative: f64,
    /// In metres.
    pub absolute: f64,
}

impl Default for TieTolerance {
    /// A millionth of the distance, and at least a nanometre: many times the errors of measured distances.
    fn default() -> Self {
        Self { relative: 1e-6, absolute: 1e-9 }
    }
}

impl TieTolerance {
    /// The tolerance (m) at a distance (m).
    #[must_use]
    #[inline]
    pub fn at(&self, distance: f64) -> f64 {
        self.absolute.greater(self.relative * distance)
    }
}

/// Two measured elements that are as near as the nearest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tie {
    pub separation: Separation,
    pub elements: ElementPair,
}

/// The nearest pair of elements so far, and its ties.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ties {
    tolerance: TieTolerance,
    /// Number of pairs that are kept.
    most: usize,
    found: Vec<Tie>,
    /// True if more pairs were found than are kept.
    is_truncated: bool,
}

impl Ties {
    /// Begins a search that keeps at most this number of pairs.
    #[inline]
    pub fn begin(&mut self, tolerance: TieTolerance, most: usize) -> &mut Self {
        self.found.clear();
        (self.tolerance, self.most, self.is_truncated) = (tolerance, most, false);
        self
    }

    /// Pairs up to this distance (m) are as near as one at `distance` (m).
    #[inline]
    pub fn limit(&self, distance: f64) -> f64 {
        distance + self.tolerance.at(distance)
    }

    /// Adds a pair that is within the limit of the best so far.
    #[inline]
    pub fn offer(&mut self, found: Separation, elements: ElementPair, best: f64) {
        if found.distance > self.limit(best) {
            return;
        }
        self.found.push(Tie { separation: found, elements });
        if self.found.len() >= 2 * self.most {
            self.drop_farthest(best);
        }
    }

    /// Keeps the nearest pairs: those that are dropped are not nearer than any that stays.
    #[cold]
    fn drop_farthest(&mut self, best: f64) {
        self.retain_within(best);
        if self.found.len() > self.most {
            self.found.select_nth_unstable_by(self.most, Tie::order);
            self.found.truncate(self.most);
            self.is_truncated = true;
        }
    }

    fn retain_within(&mut self, best: f64) {
        let limit = self.limit(best);
        self.found.retain(|tie| tie.separation.distance <= limit);
    }

    /// The nearest pair and its ties, the nearest first. The order does not depend on the search.
    #[inline]
    pub fn finish(&mut self, best: f64) -> &[Tie] {
        self.retain_within(best);
        if self.found.len() > self.most {
            self.drop_farthest(best);
        }
        self.found.sort_unstable_by(Tie::order);
        &self.found
    }

    /// True if more pairs were found than are kept.
    #[inline]
    pub fn is_truncated(&self) -> bool {
        self.is_truncated
    }
}

impl Tie {
    fn order(a: &Self, b: &Self) -> std::cmp::Ordering {
        let by_distance = a.separation.distance.total_cmp(&b.separation.distance);
        by_distance.then(a.elements.cmp(&b.elements))
    }
}
