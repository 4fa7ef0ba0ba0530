//! Narrow phase between solid primitives and grains (points or cubes).

use clearance_geometry::simd::{LANES, Simd, not_beyond};

use super::element::ElementNumber;
use super::grain_lanes::nearest;
use super::grains::GrainSearch;
use super::solid::SolidLeaf;
use super::solid_lanes;
use super::surface_surface::triangle_slack;
use crate::bounding_volume::BoundingVolume;
use crate::bvh::{GrainLeaf, Visitor};

/// Finds the solid nearest to grains.
pub(super) struct SolidGrains<'s, 'w, B: BoundingVolume>(pub GrainSearch<'s, 'w, B>);

impl<B: BoundingVolume> Visitor<SolidLeaf, GrainLeaf> for SolidGrains<'_, '_, B> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.0.threshold()
    }

    fn direction(&self) -> [f32; 3] {
        self.0.direction()
    }

    fn volume_tests(&mut self, count: u32) {
        self.0.incumbent.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.0.incumbent.interrupted()
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, solid: &SolidLeaf, grains: &GrainLeaf) {
        self.0.incumbent.work.screened_pairs += u64::from(grains.count);
        let slack = triangle_slack(self.0.relative);
        let lower = solid_lanes::bounds_of_grains(simd, solid, grains, &self.0.relative.inverse(), slack);
        let mut near = not_beyond(lower, self.threshold()) & grains.mask();
        let lower: [f32; LANES] = lower.into();
        while near != 0 {
            let grain = nearest(&lower, near);
            near &= !(1 << grain);
            if lower[grain] > self.threshold() {
                return;
            }
            let other = (&solid.core, ElementNumber::of_solid(solid.number));
            self.0.test(other, grains.first + grain as u32);
        }
    }
}
