//! Narrow phase between leaves of a surface and grains (points or cubes).

use clearance_geometry::simd::{LANES, Simd, not_beyond};

use super::element::ElementNumber;
use super::grain_lanes::{OneTriangle, nearest};
use super::grains::GrainSearch;
use super::surface::Surface;
use super::surface_surface::triangle_slack;
use super::triangle_lanes::MovedTriangles;
use crate::bounding_volume::BoundingVolume;
use crate::bvh::{GrainLeaf, TriangleLeaf, Visitor};

/// Finds the triangle of a surface nearest to grains.
pub(super) struct SurfaceGrains<'s, 'w, B: BoundingVolume> {
    pub surface: &'s Surface<B>,
    pub search: GrainSearch<'s, 'w, B>,
}

impl<B: BoundingVolume> SurfaceGrains<'_, '_, B> {
    fn test(&mut self, triangle: u32, grain: u32) {
        let other = (&self.surface.core(triangle), ElementNumber::of_triangle(triangle));
        self.search.test(other, grain);
    }
}

impl<B: BoundingVolume> Visitor<TriangleLeaf, GrainLeaf> for SurfaceGrains<'_, '_, B> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.search.threshold()
    }

    fn direction(&self) -> [f32; 3] {
        self.search.direction()
    }

    fn volume_tests(&mut self, count: u32) {
        self.search.incumbent.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.search.incumbent.interrupted()
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, leaf: &TriangleLeaf, grains: &GrainLeaf) {
        let slack = triangle_slack(self.search.relative);
        let limit = self.threshold();
        let corners = (&grains.low, &grains.high);
        let (moved, mut lanes) =
            MovedTriangles::new(simd, leaf, self.search.relative, corners, limit + 4.0 * slack);
        while lanes != 0 {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            let limit = self.threshold();
            self.search.incumbent.work.screened_pairs += u64::from(grains.count);
            let triangle = OneTriangle::new(moved.corners(lane as usize));
            let lower = triangle.lower_bounds(simd, grains, limit, slack);
            let mut near = not_beyond(lower, limit) & grains.mask();
            let lower: [f32; LANES] = lower.into();
            // the nearest first, so that few are tested exactly
            while near != 0 {
                let grain = nearest(&lower, near);
                near &= !(1 << grain);
                if lower[grain] > self.threshold() {
                    break;
                }
                self.test(leaf.first + lane, grains.first + grain as u32);
            }
        }
    }
}
