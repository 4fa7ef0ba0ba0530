//! Splits items in two, by the surface area heuristic.
//!
//! The heuristic minimises the expected number of visits of the boxes around both parts (Goldsmith & Salmon 1987, *Automatic creation of
//! object hierarchies for ray tracing*; Wald 2007, *On fast construction of SAH-based bounding volume hierarchies*, for the bins), along
//! the principal axes.

use clearance_geometry::math::{Extremes, Vector};

/// Number of splits compared along an axis, plus one.
const BINS: usize = 32;

/// Each part has at least one item in this many, so that trees stay flat.
const LEAST_SHARE: usize = 8;

/// An item along the axes: its centre and the box around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub centre: Vector,
    pub lo: Vector,
    pub hi: Vector,
}

/// A split of items along an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    /// Relative cost of the split by the heuristic.
    cost: f64,
    /// The axis to split along.
    pub axis: usize,
    /// Number of items before the split.
    pub count: usize,
}

/// The best split; the number of items before it is a multiple of `capacity`.
#[inline]
pub(super) fn best_split(items: &[Extent], capacity: usize) -> Split {
    let mut best = Split { cost: f64::INFINITY, axis: 0, count: items.len() / 2 };
    for axis in 0..3 {
        if let Some(bins) = Bins::new(items, axis) {
            bins.compare(axis, items.len(), capacity, &mut best);
        }
    }
    let whole = (best.count + capacity / 2) / capacity * capacity;
    Split { count: whole.clamp(capacity, (items.len() - 1) / capacity * capacity), ..best }
}

/// Items between two splits.
#[derive(Clone, Copy, Debug)]
struct Part {
    count: usize,
    lo: Vector,
    hi: Vector,
}

impl Part {
    fn nothing() -> Self {
        Self { count: 0, lo: Vector::repeat(f64::INFINITY), hi: Vector::repeat(f64::NEG_INFINITY) }
    }

    fn add(&mut self, count: usize, lo: &Vector, hi: &Vector) {
        self.count += count;
        self.lo = self.lo.inf(lo);
        self.hi = self.hi.sup(hi);
    }

    /// Half the surface area of the box, times the number of leaves that it needs.
    #[allow(clippy::cast_precision_loss)] // counts of leaves
    fn cost(&self, capacity: usize) -> f64 {
        let d = self.hi - self.lo;
        (d.x * d.y + d.y * d.z + d.z * d.x) * self.count.div_ceil(capacity) as f64
    }
}

/// Bins of items, by their centres along an axis.
struct Bins([Part; BINS]);

impl Bins {
    /// `None` if all centres coincide.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn new(items: &[Extent], axis: usize) -> Option<Self> {
        let place = |item: &Extent| item.centre[axis];
        let low = items.iter().map(place).fold(f64::INFINITY, f64::lesser);
        let high = items.iter().map(place).fold(f64::NEG_INFINITY, f64::greater);
        let scale = BINS as f64 / (high - low);
        if !scale.is_finite() {
            return None;
        }
        let mut bins = [Part::nothing(); BINS];
        for item in items {
            let bin = ((place(item) - low) * scale) as usize;
            bins[bin.min(BINS - 1)].add(1, &item.lo, &item.hi);
        }
        Some(Self(bins))
    }

    /// Keeps the best split between two bins, if it is better than the best so far.
    fn compare(&self, axis: usize, count: usize, capacity: usize, best: &mut Split) {
        let mut after = [0.0; BINS];
        let mut part = Part::nothing();
        for (bin, after) in self.0.iter().zip(&mut after).rev() {
            part.add(bin.count, &bin.lo, &bin.hi);
            *after = part.cost(capacity);
        }
        let mut before = Part::nothing();
        for (bin, after) in self.0.iter().zip(&after[1..]) {
            before.add(bin.count, &bin.lo, &bin.hi);
            let smaller = before.count.min(count - before.count);
            let cost = before.cost(capacity) + after;
            if smaller * LEAST_SHARE >= count && smaller > 0 && cost < best.cost {
                *best = Split { cost, axis, count: before.count };
            }
        }
    }
}
