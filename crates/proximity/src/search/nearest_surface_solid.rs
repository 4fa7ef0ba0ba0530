//! Narrow phase between a solid primitive and the leaves of a surface.

use clearance_geometry::math::MatrixPose;
use clearance_geometry::simd::{LANES, Level, Simd, dispatch, not_beyond};

use super::best_so_far::BestSoFar;
use crate::body::{SolidLeaf, Surface};
use crate::bounding_volume::{Obb, Relative};
use crate::bvh::{Leaf, Tree, TriangleLeaf, Visitor};
use crate::elements::{ElementId, ElementPair, RoundedShape};
use crate::narrow_phase::{lower_bounds_of_triangles, nearest_lane, separation_within};

/// Largest number of solids that are tested one by one.
const FEW_SOLIDS: usize = 4;

/// Finds the triangle of a surface nearest to a solid; with `SEPARATE` only any that touches.
pub(crate) struct SurfaceSolidVisitor<'s, 'w, const SEPARATE: bool> {
    pub surface: &'s Surface,
    /// True if the solid belongs to body a, and the surface to b.
    pub solid_is_a: bool,
    pub pose_ab: &'s MatrixPose,
    /// Pose of the solid's tree in the surface's.
    pub relative: &'s Relative,
    pub best_so_far: &'s mut BestSoFar<'w>,
}

impl<const SEPARATE: bool> SurfaceSolidVisitor<'_, '_, SEPARATE> {
    /// The direction of the best separation, in the frame of the surface's tree; its length is at most one.
    #[allow(clippy::cast_possible_truncation)] // bounds hold for any direction
    fn direction(&self) -> [f32; 3] {
        let Some(best) = self.best_so_far.separation() else { return [0.0; 3] };
        let along = best.direction();
        let along = if self.solid_is_a { self.pose_ab.rotation.tr_mul(&along) } else { along };
        let shorter = 1.0 - 8.0 * f32::EPSILON;
        [along.x as f32 * shorter, along.y as f32 * shorter, along.z as f32 * shorter]
    }

    /// Tests a few vertices of the surface if any contact suffices: where the bodies touch, one of them is often inside a solid.
    #[inline]
    pub fn test_samples(&mut self, level: Level, solids: &Tree<Obb, SolidLeaf>) {
        if !self.best_so_far.seeks_any() || solids.leaves().len() > FEW_SOLIDS {
            return;
        }
        for Leaf { content: solid, .. } in solids.leaves() {
            if self.best_so_far.is_settled() {
                return;
            }
            self.best_so_far.work.volume_tests += 1;
            let samples = self.surface.samples();
            let innermost = dispatch!(level, simd => samples.innermost(simd, solid, self.relative));
            if let Some(vertex) = innermost {
                self.test_vertex(solid, vertex);
            }
        }
    }

    fn test_vertex(&mut self, solid: &SolidLeaf, vertex: u32) {
        self.best_so_far.work.primitive_tests += 1;
        let vertex = &RoundedShape::point(&self.surface.vertex(vertex));
        let (a, b) = if self.solid_is_a { (&solid.shape, vertex) } else { (vertex, &solid.shape) };
        if let Some(found) = separation_within(a, b, self.pose_ab, self.best_so_far.bound()) {
            self.best_so_far.offer(found);
        }
    }

    fn test(&mut self, solid: &SolidLeaf, index: u32) {
        self.best_so_far.work.primitive_tests += 1;
        let triangle = &self.surface.shape(index);
        let (a, b) = if self.solid_is_a { (&solid.shape, triangle) } else { (triangle, &solid.shape) };
        if let Some(found) = separation_within(a, b, self.pose_ab, self.best_so_far.bound()) {
            let (solid, triangle) = (ElementId::of_solid(solid.index), ElementId::of_triangle(index));
            self.best_so_far.offer_elements(found, ElementPair::ordered(solid, triangle, self.solid_is_a));
        }
    }
}

impl<const SEPARATE: bool> Visitor<SolidLeaf, TriangleLeaf> for SurfaceSolidVisitor<'_, '_, SEPARATE> {
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
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, solid: &SolidLeaf, leaf: &TriangleLeaf) {
        self.best_so_far.work.screened_pairs += u64::from(leaf.count);
        let lower = lower_bounds_of_triangles(simd, solid, leaf, self.relative, &self.direction());
        let mut near = not_beyond(lower, self.best_so_far.threshold()) & leaf.mask();
        let lower: [f32; LANES] = lower.into();
        // the nearest first, so that few are tested exactly
        while near != 0 {
            let lane = nearest_lane(&lower, near);
            near &= !(1 << lane);
            if lower[lane] > self.best_so_far.threshold() {
                return;
            }
            self.test(solid, leaf.first + lane as u32);
        }
    }
}
