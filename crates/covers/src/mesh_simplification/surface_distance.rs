//! Certified distance between the surfaces of two meshes.

use std::sync::Arc;
use std::time::Instant;

use clearance_geometry::TriangleMesh;
use clearance_geometry::math::{Extremes, Point};
use clearance_lint::{HausdorffBounds, HausdorffOptions, PlacedShape, hausdorff};

use crate::search_limit::SearchLimit;

/// Gap of the bounds relative to the lower one.
const RELATIVE_GAP: f64 = 0.02;

/// Gap of the bounds relative to the diagonal of the box around the mesh.
const GAP_OF_SIZE: f64 = 2e-5;

/// Gap of the first bounds that are compared with a distance, relative to the distance.
const ROUGH_GAP: f64 = 0.3;

/// Number of samples after which a search ends: plane faces that lie on many small ones would need far more for a small gap.
const MOST_SAMPLES: usize = 200_000;

/// Proven bounds on the Hausdorff distance of two surfaces: the largest distance of a point of one surface from the other surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceDistance {
    /// Lower bound (m): [`Self::point`] has at least this distance.
    pub lower: f64,
    /// Upper bound (m): no point of either surface is further away from the other.
    pub upper: f64,
    /// The point with the largest distance that was found (m).
    pub point: Point,
}

impl SurfaceDistance {
    /// Of two meshes in one frame. The gap between the bounds is small relative to the distance or to the size of the mesh, or at most `gap`
    /// (m). The bounds hold, but may be wide, where the limit ends the search.
    pub fn between([a, b]: [&Arc<TriangleMesh>; 2], gap: f64, limit: &SearchLimit) -> Self {
        let (low, high) = a.bounds();
        let gap = (GAP_OF_SIZE * (high - low).norm()).greater(gap);
        let options = HausdorffOptions {
            relative_gap: RELATIVE_GAP,
            absolute_gap: gap,
            most_samples: MOST_SAMPLES,
            target_is_solid: false,
            deadline: if limit.is_over() { Some(Instant::now()) } else { limit.deadline() },
        };
        let [a, b] = [a, b].map(|mesh| [PlacedShape::mesh(mesh.clone())]);
        let (there, back) = rayon::join(|| hausdorff(&a, &b, &options), || hausdorff(&b, &a, &options));
        let bounds = |bounds: HausdorffBounds| {
            let HausdorffBounds { lower, upper, point, .. } = bounds;
            Self { lower, upper, point }
        };
        // a mesh is never empty
        let unknown = Self { lower: 0.0, upper: f64::INFINITY, point: Point::origin() };
        let [there, back] = [there, back].map(|found| found.map_or(unknown, bounds));
        there.larger(&back)
    }

    /// Of two meshes in one frame, with bounds that are close enough to compare the distance with a given one (m), where possible.
    pub fn compared(meshes: [&Arc<TriangleMesh>; 2], with: f64, limit: &SearchLimit) -> Self {
        let rough = Self::between(meshes, ROUGH_GAP * with, limit);
        let is_decided = rough.upper <= with || rough.lower > with;
        if is_decided { rough } else { Self::between(meshes, 0.0, limit) }
    }

    /// Of two meshes with the same faces: no point of a face moves further than its corners.
    pub fn of_moved_vertices(original: &TriangleMesh, moved: &TriangleMesh) -> Self {
        let mut distance = Self { lower: 0.0, upper: 0.0, point: moved.triangle(0).a };
        for (p, q) in original.vertices().iter().zip(moved.vertices()) {
            let way = (p - q).norm();
            if way > distance.upper {
                // and the rounding of the way itself
                (distance.upper, distance.point) = (way * (1.0 + 1e-9), *q);
            }
        }
        distance
    }

    /// Bounds on the larger of two distances.
    pub fn larger(&self, other: &Self) -> Self {
        let point = if other.lower > self.lower { other.point } else { self.point };
        Self { lower: self.lower.greater(other.lower), upper: self.upper.greater(other.upper), point }
    }
}
