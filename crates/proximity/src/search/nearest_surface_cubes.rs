//! Narrow phase between leaves of a surface and cubes.

use clearance_geometry::simd::{LANES, Simd, not_beyond};

use super::cube_search_state::CubeSearch;
use crate::body::Surface;
use crate::bvh::{CubeLeaf, TriangleLeaf, Visitor};
use crate::elements::ElementId;
use crate::narrow_phase::{MovedTriangles, OneTriangle, nearest_lane, triangle_slack};

/// Finds the triangle of a surface nearest to cubes.
pub(crate) struct SurfaceCubesVisitor<'s, 'w> {
    pub surface: &'s Surface,
    pub search: CubeSearch<'s, 'w>,
}

impl SurfaceCubesVisitor<'_, '_> {
    fn test(&mut self, triangle: u32, cube: u32) {
        self.search.test(&self.surface.shape(triangle), ElementId::of_triangle(triangle), cube);
    }
}

impl Visitor<TriangleLeaf, CubeLeaf> for SurfaceCubesVisitor<'_, '_> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.search.threshold()
    }

    fn direction(&self) -> [f32; 3] {
        self.search.direction()
    }

    fn volume_tests(&mut self, count: u32) {
        self.search.best_so_far.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.search.best_so_far.interrupted()
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, leaf: &TriangleLeaf, cubes: &CubeLeaf) {
        let slack = triangle_slack(self.search.relative);
        let limit = self.threshold();
        let corners = (&cubes.low, &cubes.high);
        let (moved, mut lanes) =
            MovedTriangles::new(simd, leaf, self.search.relative, corners, limit + 4.0 * slack);
        while lanes != 0 {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            let limit = self.threshold();
            self.search.best_so_far.work.screened_pairs += u64::from(cubes.count);
            let triangle = OneTriangle::new(moved.corners(lane as usize));
            let lower = triangle.lower_bounds(simd, cubes, limit, slack);
            let mut near = not_beyond(lower, limit) & cubes.mask();
            let lower: [f32; LANES] = lower.into();
            // the nearest first, so that few are tested exactly
            while near != 0 {
                let cube = nearest_lane(&lower, near);
                near &= !(1 << cube);
                if lower[cube] > self.threshold() {
                    break;
                }
                self.test(leaf.first + lane, cubes.first + cube as u32);
            }
        }
    }
}
