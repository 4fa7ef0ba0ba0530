//! Proven bounds on the excess of a shape over a solid: the largest distance of the shape's points from the solid.
//!
//! Branch and bound over the box around the shape: a point of a cell is at most the cell's radius farther from the solid than its centre.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use clearance_geometry::math::{Extremes, Point, Vector};

use crate::ball::{Ball, ROUNDING};
use crate::link_solid::LinkSolid;

/// A convex shape whose excess is bounded.
pub trait ConvexShape {
    /// Smallest and largest corner (m) of a box around the shape.
    fn bounds(&self) -> [Point; 2];
    /// The point of the shape nearest to a point.
    fn nearest_point(&self, p: &Point) -> Point;
}

impl ConvexShape for Ball {
    fn bounds(&self) -> [Point; 2] {
        let reach = Vector::repeat(self.radius);
        [self.centre - reach, self.centre + reach]
    }

    fn nearest_point(&self, p: &Point) -> Point {
        let way = p - self.centre;
        let distance = way.norm();
        if distance <= self.radius { *p } else { self.centre + way * (self.radius / distance) }
    }
}

/// Bounds (m) on a largest distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExcessBounds {
    /// Lower bound (m): the distance of [`Self::witness`] from the solid.
    pub lower: f64,
    /// Upper bound (m), proven.
    pub upper: f64,
    /// The farthest point that was found.
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
}

struct Cell {
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

/// Bounds on the excess of a ball. They are tighter than those of any shape, since a ball around a point at depth e reaches at most r − e out.
pub fn ball_excess(solid: &LinkSolid, ball: &Ball, accuracy: &Accuracy) -> ExcessBounds {
    let simple = (ball.radius + solid.signed_distance(&ball.centre) + ROUNDING).greater(0.0);
    let mut bounds = excess(solid, ball, accuracy, simple);
    bounds.upper = bounds.upper.lesser(simple);
    bounds
}

/// Bounds on the excess of a convex shape that is known to be at most `known` (m).
pub fn excess(solid: &LinkSolid, shape: &impl ConvexShape, accuracy: &Accuracy, known: f64) -> ExcessBounds {
    let [low, high] = shape.bounds();
    let outside = |p: &Point| solid.signed_distance(p).greater(0.0);
    let centre = low + (high - low) * 0.5;
    let mut found = ExcessBounds { lower: 0.0, upper: known, witness: shape.nearest_point(&centre) };
    let mut heap = BinaryHeap::from([Cell { upper: known, centre, half: 0.5 * (high - low).amax() }]);
    let mut cells = 0;
    while let Some(Cell { upper, centre, half }) = heap.pop() {
        found.upper = upper.lesser(known).greater(found.lower);
        let gap = found.upper - found.lower;
        if gap <= accuracy.absolute.greater(accuracy.relative * found.upper) || cells >= accuracy.most_cells {
            return found;
        }
        let quarter = 0.5 * half;
        let reach = quarter * 3.0_f64.sqrt() + ROUNDING;
        for i in 0..8 {
            let side = |bit: usize| if i & bit == 0 { -quarter } else { quarter };
            let centre = centre + Vector::new(side(1), side(2), side(4));
            let inner = shape.nearest_point(&centre);
            if (inner - centre).norm() > reach {
                continue;
            }
            cells += 1;
            // the projection on a convex shape brings no two points farther apart
            let distance = outside(&inner);
            let upper = distance + reach;
            if distance > found.lower {
                (found.lower, found.witness) = (distance, inner);
            }
            if upper > found.lower {
                heap.push(Cell { upper, centre, half: quarter });
            }
        }
    }
    found.upper = found.lower.lesser(known) + ROUNDING;
    found
}
