//! Narrow phase between solid primitives.

use clearance_geometry::math::MatrixPose;
use clearance_geometry::simd::Simd;

use super::best_so_far::BestSoFar;
use crate::body::SolidLeaf;
use crate::bvh::Visitor;
use crate::elements::{ElementId, ElementPair};
use crate::narrow_phase::{separation_within, touching_within};

/// Finds the nearest solids of two bodies; with `SEPARATE` only any that touch.
pub(crate) struct SolidSolidVisitor<'s, 'w, const SEPARATE: bool> {
    pub pose_ab: &'s MatrixPose,
    pub best_so_far: &'s mut BestSoFar<'w>,
}

impl<const SEPARATE: bool> SolidSolidVisitor<'_, '_, SEPARATE> {
    #[inline]
    pub fn test(&mut self, a: &SolidLeaf, b: &SolidLeaf) {
        self.best_so_far.work.primitive_tests += 1;
        let limit = self.best_so_far.bound();
        let measure = if SEPARATE { touching_within } else { separation_within };
        if let Some(found) = measure(&a.shape, &b.shape, self.pose_ab, limit) {
            let elements = ElementPair { a: ElementId::of_solid(a.index), b: ElementId::of_solid(b.index) };
            self.best_so_far.offer_elements(found, elements);
        }
    }
}

impl<const SEPARATE: bool> Visitor<SolidLeaf, SolidLeaf> for SolidSolidVisitor<'_, '_, SEPARATE> {
    const SEPARATE: bool = SEPARATE;

    fn threshold(&self) -> f32 {
        self.best_so_far.threshold()
    }

    fn volume_tests(&mut self, count: u32) {
        self.best_so_far.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.best_so_far.interrupted()
    }

    #[inline(always)]
    fn leaves<S: Simd>(&mut self, _: S, a: &SolidLeaf, b: &SolidLeaf) {
        self.test(a, b);
    }
}
