//! Capsules or boxes that contain the links of a robot.

use clearance_geometry::Triangle;
use clearance_geometry::math::{Extremes, Vector};
use clearance_robot::{LinkId, RobotModel};
use rayon::prelude::*;

use crate::ball::ROUNDING;
use crate::branch_and_bound::{Accuracy, DistanceBounds};
use crate::cover_shape::{CoverShape, PosedShape};
use crate::distance_grid::DistanceGrid;
use crate::excess::excess;
use crate::link_parts::{LinkPart, principal_axes};
use crate::link_solid::LinkSolid;
use crate::options::{CoverError, CoverSize};
use crate::search_limit::SearchLimit;
use crate::shape_fit::{Fitted, ShapeFit, ShapeKind, circumradius};
use crate::sphere_cover::solids;

/// Accuracy of the largest excess.
const ACCURACY: Accuracy = Accuracy { relative: 0.01, absolute: 1e-6, most_cells: 20_000, enough: 0.0 };

/// Part of the time that is left for the search of shapes; the rest is for their excess.
const SEARCH_TIME: f64 = 0.6;

/// Places of cutting planes, relative to the extent of a part.
const CUTS: [f64; 3] = [0.35, 0.5, 0.65];

/// The shapes of a link.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkShapes {
    /// The link.
    pub link: LinkId,
    /// The shapes, in the link frame, each with a proven bound (m) on the distance of its points from the link's geometry.
    pub shapes: Vec<(CoverShape, f64)>,
    /// Proven bounds (m), lower and upper, on the largest distance of a point of the shapes from the link's geometry.
    pub excess: [f64; 2],
    /// True if the limit has ended the search: more time can give less excess.
    pub is_cut: bool,
}

/// Shapes that contain a robot: the links with collision geometry, in the order of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeCover {
    /// The shapes of the links.
    pub links: Vec<LinkShapes>,
}

impl ShapeCover {
    /// Number of shapes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.links.iter().map(|link| link.shapes.len()).sum()
    }

    /// The largest of the links' upper bounds (m).
    #[must_use]
    pub fn largest_excess(&self) -> f64 {
        self.links.iter().map(|link| link.excess[1]).fold(0.0, Extremes::greater)
    }

    /// True if the limit has ended the search of a link.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.links.iter().any(|link| link.is_cut)
    }
}

/// At most `count` capsules or boxes for each link, which contain its collision geometry: every triangle, and the inside of closed meshes and
/// primitives. The same input gives the same shapes, on any number of threads, unless the limit ends the search.
///
/// `on_link` is called when a link is covered, from any thread.
///
/// # Errors
/// If the count is zero, or a link has geometry that cannot be covered.
pub fn shape_cover(
    robot: &RobotModel,
    kind: ShapeKind,
    count: usize,
    limit: &SearchLimit,
    on_link: &(dyn Fn(LinkId) + Sync),
) -> Result<ShapeCover, CoverError> {
    let size = CoverSize::PerLink(count);
    size.validate()?;
    let solids = solids(robot, &size)?;
    let of_link = |(link, solid): &(LinkId, LinkSolid)| {
        let search_limit = limit.part(SEARCH_TIME);
        let shapes = shapes_around(solid, kind, count, &search_limit);
        let bounds: Vec<DistanceBounds> =
            shapes.iter().map(|shape| shape_excess(solid, shape, limit)).collect();
        let largest = |of: fn(&DistanceBounds) -> f64| bounds.iter().map(of).fold(0.0, Extremes::greater);
        on_link(*link);
        LinkShapes {
            link: *link,
            shapes: shapes.into_iter().zip(bounds.iter().map(|bounds| bounds.upper)).collect(),
            excess: [largest(|bounds| bounds.lower), largest(|bounds| bounds.upper)],
            is_cut: search_limit.is_over() || limit.is_over(),
        }
    };
    Ok(ShapeCover { links: solids.par_iter().map(of_link).collect() })
}

/// Proven bounds (m) on the largest distance of a point of a shape from a solid.
pub fn shape_excess(solid: &LinkSolid, shape: &CoverShape, limit: &SearchLimit) -> DistanceBounds {
    let simple = circumradius(&shape.size) + solid.signed_distance(&shape.centre) + ROUNDING;
    excess(solid, &PosedShape::from(shape), (&ACCURACY, limit), simple.greater(0.0))
}

/// At most `count` shapes that contain a solid.
pub fn shapes_around(
    solid: &LinkSolid,
    kind: ShapeKind,
    count: usize,
    limit: &SearchLimit,
) -> Vec<CoverShape> {
    let whole = LinkPart { triangles: solid.triangles().map(Triangle::corners).collect() };
    // without time for a grid, the first shape is as good as any
    let grid = DistanceGrid::new(solid, limit).unwrap_or_else(DistanceGrid::empty);
    let fit = ShapeFit::new(kind, &grid, solid.chord_error() + 8.0 * ROUNDING, limit);
    let [first, second, _] = principal_axes(&whole.triangles);
    let mut parts = vec![(fit.fit(&whole), whole)];
    let mut best: Vec<CoverShape> = parts.iter().map(|(fitted, _)| fitted.shape).collect();
    let mut least = largest(&parts);
    while parts.len() < count && !limit.is_over() {
        let excess = |i: usize| parts[i].0.excess;
        let worst = (1..parts.len()).fold(0, |worst, i| if excess(i) > excess(worst) { i } else { worst });
        let Some(halves) = best_split(&fit, &parts[worst].1, [first, second]) else { break };
        parts.remove(worst);
        parts.extend(halves);
        if largest(&parts) < least {
            least = largest(&parts);
            best = parts.iter().map(|(fitted, _)| fitted.shape).collect();
        }
    }
    best
}

fn largest(parts: &[(Fitted, LinkPart)]) -> f64 {
    parts.iter().map(|(fitted, _)| fitted.excess).fold(0.0, Extremes::greater)
}

/// The split by a plane with one of two normals whose shapes have the least excess.
fn best_split(fit: &ShapeFit, part: &LinkPart, normals: [Vector; 2]) -> Option<[(Fitted, LinkPart); 2]> {
    let mut best: Option<(f64, [(Fitted, LinkPart); 2])> = None;
    for normal in normals {
        let [low, high] = part.range(&normal);
        for cut in CUTS {
            let Some(halves) = part.split(&normal, low + cut * (high - low)) else { continue };
            let halves = halves.map(|half| (fit.fit(&half), half));
            let excess = largest(&halves);
            if best.as_ref().is_none_or(|(least, _)| excess < *least) {
                best = Some((excess, halves));
            }
        }
    }
    best.map(|(_, halves)| halves)
}
