//! Narrow phase between grains (points or cubes) of two bodies. Two clouds are rarely compared, so this code is short rather than fast.

use clearance_geometry::simd::{LANES, Simd, not_beyond};

use super::element::ElementNumber;
use super::grain_lanes::{from_grain, nearest};
use super::grains::{GrainSearch, Grains};
use super::surface_surface::triangle_slack;
use crate::bounding_volume::BoundingVolume;
use crate::bvh::{GrainLeaf, Visitor};

/// Finds the nearest of two sets of grains.
pub(super) struct GrainGrains<'s, 'w, B: BoundingVolume> {
    /// Grains of the other body.
    pub others: &'s Grains<B>,
    pub search: GrainSearch<'s, 'w, B>,
}

impl<B: BoundingVolume> Visitor<GrainLeaf, GrainLeaf> for GrainGrains<'_, '_, B> {
    const SEPARATE: bool = false;

    fn threshold(&self) -> f32 {
        self.search.threshold()
    }

    fn volume_tests(&mut self, count: u32) {
        self.search.incumbent.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.search.incumbent.interrupted()
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, others: &GrainLeaf, grains: &GrainLeaf) {
        let slack = triangle_slack(self.search.relative);
        for i in 0..others.count {
            self.search.incumbent.work.screened_pairs += u64::from(grains.count);
            let lane = i as usize & 7;
            let [x, y, z] = &others.centre;
            let centre = self.search.relative.point(&[x[lane], y[lane], z[lane]]);
            let lower = from_grain(simd, (&centre, others.half_edge[lane]), grains, slack);
            let mut near = not_beyond(lower, self.threshold()) & grains.mask();
            let lower: [f32; LANES] = lower.into();
            while near != 0 {
                let grain = nearest(&lower, near);
                near &= !(1 << grain);
                if lower[grain] > self.threshold() {
                    break;
                }
                let other = others.first + i;
                let core = self.others.core(other);
                let number = ElementNumber::of_grain(self.others.set, other);
                self.search.test((&core, number), grains.first + grain as u32);
            }
        }
    }
}
