//! Narrow phase between solid primitives and cubes.

use clearance_geometry::simd::{LANES, Simd, not_beyond};

use super::cube_search_state::CubeSearch;
use crate::body::SolidLeaf;
use crate::bvh::{CubeLeaf, Visitor};
use crate::elements::ElementId;
use crate::narrow_phase::{lower_bounds_of_cubes, nearest_lane};

/// Finds the solid nearest to cubes.
pub(crate) struct SolidCubesVisitor<'s, 'w>(pub CubeSearch<'s, 'w>);

impl Visitor<SolidLeaf, CubeLeaf> for SolidCubesVisitor<'_, '_> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.0.threshold()
    }

    fn direction(&self) -> [f32; 3] {
        self.0.direction()
    }

    fn volume_tests(&mut self, count: u32) {
        self.0.best_so_far.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.0.best_so_far.interrupted()
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, solid: &SolidLeaf, cubes: &CubeLeaf) {
        self.0.best_so_far.work.screened_pairs += u64::from(cubes.count);
        let lower = lower_bounds_of_cubes(simd, solid, cubes, &self.0.relative.inverse());
        let mut near = not_beyond(lower, self.threshold()) & cubes.mask();
        let lower: [f32; LANES] = lower.into();
        while near != 0 {
            let cube = nearest_lane(&lower, near);
            near &= !(1 << cube);
            if lower[cube] > self.threshold() {
                return;
            }
            self.0.test(&solid.shape, ElementId::of_solid(solid.index), cubes.first + cube as u32);
        }
    }
}
