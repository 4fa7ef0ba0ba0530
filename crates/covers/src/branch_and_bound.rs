//! Proven bounds on the largest value, in a cube, of a function of the distance to a solid: branch and bound.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use clearance_geometry::math::{Extremes, Point, Vector};

use crate::ball::ROUNDING;
use crate::link_solid::KnownDistance;
use crate::search_limit::SearchLimit;

/// Bounds on a largest distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceBounds {
    /// Lower bound (m): the value at [`Self::witness`], up to rounding.
    pub lower: f64,
    /// Upper bound (m), proven.
    pub upper: f64,
    /// The point (m) with the largest value that was found, in the link frame.
    pub witness: Point,
}

/// When a search ends.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    /// Gap of the bounds relative to the upper one.
    pub relative: f64,
    /// Gap of the bounds (m).
    pub absolute: f64,
    /// Largest number of cells.
    pub most_cells: usize,
    /// A proof that the value is at most this (m) suffices.
    pub enough: f64,
}

/// Value of a function in a cell.
#[derive(Clone, Copy, Debug)]
pub struct CellValue {
    /// No point of the cell has a larger value (m).
    pub upper: f64,
    /// A point of the domain with its value (m).
    pub sample: Option<(Point, f64)>,
    /// Signed distance of the solid at a point, for the cells within.
    pub known: KnownDistance,
}

struct Cell {
    known: Option<KnownDistance>,
    upper: f64,
    centre: Point,
    half: f64,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.upper.total_cmp(&other.upper)
    }
}

/// Bounds on the largest value in a box of a function that is nowhere larger than `known`; 0 where there is no domain. `value` returns the
/// value in the cell of all points within a distance from a centre, or `None` if the cell is outside of the domain; it gets the distance that it
/// has returned for the cell around. The bounds hold wherever the limit ends the search.
pub fn maximise(
    [low, high]: [Point; 2],
    known: f64,
    (accuracy, limit): (&Accuracy, &SearchLimit),
    value: impl Fn(&Point, f64, Option<KnownDistance>) -> Option<CellValue>,
) -> DistanceBounds {
    let centre = low + (high - low) * 0.5;
    let mut found = DistanceBounds { lower: 0.0, upper: known, witness: centre };
    let mut heap =
        BinaryHeap::from([Cell { known: None, upper: known, centre, half: 0.5 * (high - low).amax() }]);
    let mut cells = 0;
    while let Some(Cell { known: around, upper, centre, half }) = heap.pop() {
        found.upper = upper.lesser(known).greater(found.lower);
        let gap = found.upper - found.lower;
        if found.upper <= accuracy.enough {
            return found;
        }
        if gap <= accuracy.absolute.greater(accuracy.relative * found.upper)
            || cells >= accuracy.most_cells
            || limit.is_over()
        {
            return found;
        }
        let half = 0.5 * half;
        for i in 0..8 {
            let side = |bit: usize| if i & bit == 0 { -half } else { half };
            let centre = centre + Vector::new(side(1), side(2), side(4));
            cells += 1;
            let reach = half * 3.0_f64.sqrt() + ROUNDING;
            let Some(CellValue { upper, sample, known }) = value(&centre, reach, around) else { continue };
            if let Some((point, value)) = sample
                && value > found.lower
            {
                (found.lower, found.witness) = (value, point);
            }
            if upper > found.lower {
                heap.push(Cell { known: Some(known), upper, centre, half });
            }
        }
    }
    found.upper = (found.lower + ROUNDING).lesser(known.greater(found.lower));
    found
}
