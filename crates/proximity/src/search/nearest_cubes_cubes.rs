//! Narrow phase between cubes of two bodies. Two clouds are rarely compared, so this code is short rather than fast.

use clearance_geometry::Cube;
use clearance_geometry::simd::{LANES, Simd, not_beyond};

use super::cube_search_state::CubeSearch;
use crate::body::CubeSet;
use crate::bvh::{CubeLeaf, Visitor};
use crate::narrow_phase::{lower_bounds_from_cube, nearest_lane, triangle_slack};

/// Finds the nearest of two sets of cubes.
pub(crate) struct CubesCubesVisitor<'s, 'w> {
    /// Cubes of the other body.
    pub others: &'s CubeSet,
    pub search: CubeSearch<'s, 'w>,
}

impl Visitor<CubeLeaf, CubeLeaf> for CubesCubesVisitor<'_, '_> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.search.threshold()
    }

    fn volume_tests(&mut self, count: u32) {
        self.search.best_so_far.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.search.best_so_far.interrupted()
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, others: &CubeLeaf, cubes: &CubeLeaf) {
        let slack = triangle_slack(self.search.relative);
        for i in 0..others.count {
            self.search.best_so_far.work.screened_pairs += u64::from(cubes.count);
            let lane = i as usize & 7;
            let [x, y, z] = &others.centre;
            let centre = self.search.relative.point(&[x[lane], y[lane], z[lane]]);
            let cube = Cube { centre, half_edge: others.half_edge[lane] };
            let lower = lower_bounds_from_cube(simd, cube, cubes, slack);
            let mut near = not_beyond(lower, self.threshold()) & cubes.mask();
            let lower: [f32; LANES] = lower.into();
            while near != 0 {
                let cube = nearest_lane(&lower, near);
                near &= !(1 << cube);
                if lower[cube] > self.threshold() {
                    break;
                }
                let other = others.first + i;
                self.search.test(&self.others.shape(other), self.others.id(other), cubes.first + cube as u32);
            }
        }
    }
}
