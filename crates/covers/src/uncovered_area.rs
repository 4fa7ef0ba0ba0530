//! Proven bounds on the part of a surface that no ball covers.

use clearance_geometry::math::{Extremes, Point};

use crate::ball::{Ball, ROUNDING};
use crate::link_solid::LinkSolid;
use crate::search_limit::SearchLimit;

/// Size below which a piece of the surface is not split further, relative to the extent of the solid.
const FINEST: f64 = 1e-3;

/// Bounds on the uncovered part of a surface. Areas are those of the meshes that stand for curved primitives; the bounds hold for the parts of
/// the primitives over them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncoveredArea {
    /// Area (m²) that is certainly in no ball.
    pub lower: f64,
    /// The rest of the area (m²) is certainly covered.
    pub upper: f64,
    /// Area (m²) of all triangles.
    pub total: f64,
}

/// Bounds on the area of the surface outside of all balls. They hold wherever the limit ends the search.
pub fn uncovered_area(solid: &LinkSolid, balls: &[Ball], limit: &SearchLimit) -> UncoveredArea {
    let finest = FINEST * solid.extent();
    // the surface of a curved primitive is this near to its mesh
    let margin = solid.chord_error() + ROUNDING;
    let mut result = UncoveredArea { lower: 0.0, upper: 0.0, total: 0.0 };
    let mut open = vec![];
    for triangle in solid.triangles() {
        open.push(triangle.corners());
        result.total += area(&triangle.corners());
        while let Some([a, b, c]) = open.pop() {
            let centre = Point::from((a.coords + b.coords + c.coords) / 3.0);
            let reach = [a, b, c].iter().map(|p| (p - centre).norm()).fold(0.0, Extremes::greater);
            let is_in = |ball: &Ball| [a, b, c].iter().all(|p| ball.contains(p, margin));
            if balls.iter().any(is_in) {
                continue;
            }
            let is_outside = balls.iter().all(|ball| ball.slack(&centre) < -reach - margin);
            if is_outside || reach < finest || limit.is_over() {
                result.upper += area(&[a, b, c]);
                result.lower += if is_outside { area(&[a, b, c]) } else { 0.0 };
                continue;
            }
            let [p, q, r] = [a + (b - a) * 0.5, b + (c - b) * 0.5, c + (a - c) * 0.5];
            open.extend([[a, p, r], [p, b, q], [r, q, c], [p, q, r]]);
        }
    }
    result
}

fn area([a, b, c]: &[Point; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}
