//! Narrow phase between solid primitives.

use clearance_geometry::math::MatrixPose;
use clearance_geometry::simd::Simd;

use super::element::ElementNumber;
use super::element_pair::{separation_within, touching_within};
use super::incumbent::Incumbent;
use super::solid::SolidLeaf;
use crate::bvh::Visitor;

/// Finds the nearest solids of two bodies; with `SEPARATE` only any that touch.
pub(super) struct SolidSolid<'s, 'w, const SEPARATE: bool> {
    pub pose_ab: &'s MatrixPose,
    pub incumbent: &'s mut Incumbent<'w>,
}

impl<const SEPARATE: bool> SolidSolid<'_, '_, SEPARATE> {
    #[inline]
    pub fn meet(&mut self, a: &SolidLeaf, b: &SolidLeaf) {
        self.incumbent.work.primitive_tests += 1;
        let limit = self.incumbent.bound();
        let look = if SEPARATE { touching_within } else { separation_within };
        if let Some(found) = look(&a.core, &b.core, self.pose_ab, limit) {
            let numbers = (ElementNumber::of_solid(a.number), ElementNumber::of_solid(b.number));
            self.incumbent.offer_numbered(found, numbers);
        }
    }
}

impl<const SEPARATE: bool> Visitor<SolidLeaf, SolidLeaf> for SolidSolid<'_, '_, SEPARATE> {
    const SEPARATE: bool = SEPARATE;

    fn threshold(&self) -> f32 {
        self.incumbent.threshold()
    }

    fn volume_tests(&mut self, count: u32) {
        self.incumbent.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.incumbent.interrupted()
    }

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, _: S, a: &SolidLeaf, b: &SolidLeaf) {
        self.meet(a, b);
    }
}
