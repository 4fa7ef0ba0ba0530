//! Where a line passes through a surface.

use clearance_geometry::math::{MatrixPose, Point};

use super::chord::Line;
use super::surface_pair::PlacedSurface;
use super::touching_elements::for_touching;
use crate::body::Surface;
use crate::bounding_volume::Obb;
use crate::bvh::TreePair;
use crate::search::Scratch;

/// A point of a line in a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceHit {
    /// Parameter (m) of the line.
    pub at: f64,
    /// Cosine between the line and the normal of the surface: positive where the line leaves a solid.
    pub slope: f64,
}

/// Everywhere that a line passes through a surface; the line is in the frame of the first body. A face that contains the line is not hit.
pub(super) fn hits(placed: &PlacedSurface, line: &Line, scratch: &mut Scratch) -> Vec<SurfaceHit> {
    let PlacedSurface { surface, pose, .. } = placed;
    let own = line.seen_from(pose);
    let length = surface.tree().reach() + nalgebra::distance(surface.tree().anchor(), &own.origin);
    let ends = [own.at(-length), own.at(length)];
    let Some(segment) = Surface::<Obb>::new(ends.to_vec(), &[[0, 1, 1]]) else { return Vec::new() };
    let relative = &segment.tree().relative(surface.tree(), &MatrixPose::identity());
    let trees = TreePair { a: segment.tree(), b: surface.tree(), relative };
    let mut found = Vec::new();
    for_touching(trees, 0.0, 0.0, scratch, |_, index| {
        let triangle = surface.triangle(index);
        let Some(point) = triangle.pierced_by(&ends) else { return false };
        let (normal, _) = placed.normal(index, &triangle);
        found.push(SurfaceHit { at: along(&own, &point), slope: normal.dot(&own.direction) });
        true
    });
    found
}

fn along(line: &Line, point: &Point) -> f64 {
    (point - line.origin).dot(&line.direction)
}
