//! Narrow phase between a solid primitive and the leaves of a surface.

use clearance_geometry::math::{MatrixPose, Vector};
use clearance_geometry::simd::{LANES, Level, Simd, dispatch, not_beyond};

use super::core::RoundedCore;
use super::element::ElementNumber;
use super::element_pair::separation_within;
use super::grain_lanes::nearest;
use super::incumbent::Incumbent;
use super::solid::SolidLeaf;
use super::solid_lanes;
use super::surface::Surface;
use super::surface_surface::triangle_slack;
use crate::bounding_volume::{BoundingVolume, Relative};
use crate::bvh::{Leaf, Tree, TriangleLeaf, Visitor};

/// Largest number of solids that are tested one by one.
const FEW_SOLIDS: usize = 4;

/// Finds the triangle of a surface nearest to a solid; with `SEPARATE` only any that touches.
pub(super) struct SurfaceSolid<'s, 'w, B: BoundingVolume, const SEPARATE: bool> {
    pub surface: &'s Surface<B>,
    /// True if the solid belongs to body a, and the surface to b.
    pub solid_is_a: bool,
    pub pose_ab: &'s MatrixPose,
    /// Pose of the solid's tree in the surface's.
    pub relative: &'s Relative,
    pub incumbent: &'s mut Incumbent<'w>,
}

impl<B: BoundingVolume, const SEPARATE: bool> SurfaceSolid<'_, '_, B, SEPARATE> {
    /// The direction of the best separation, in the frame of the surface's tree; its length is at most one.
    #[allow(clippy::cast_possible_truncation)] // bounds hold for any direction
    fn direction(&self) -> [f32; 3] {
        let Some(best) = &self.incumbent.best else { return [0.0; 3] };
        let [p, q] = best.witness_points;
        let along = (q - p).try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let along = if self.solid_is_a { self.pose_ab.rotation.tr_mul(&along) } else { along };
        let shorter = 1.0 - 8.0 * f32::EPSILON;
        [along.x as f32 * shorter, along.y as f32 * shorter, along.z as f32 * shorter]
    }

    /// Tests a few vertices of the surface if any contact suffices: where the bodies touch, one of them is often inside a solid.
    #[inline]
    pub fn glance(&mut self, level: Level, solids: &Tree<B, SolidLeaf>) {
        if !self.incumbent.seeks_any() || solids.leaves().len() > FEW_SOLIDS {
            return;
        }
        for Leaf { content: solid, .. } in solids.leaves() {
            if self.incumbent.is_settled() {
                return;
            }
            self.incumbent.work.volume_tests += 1;
            let samples = &self.surface.samples;
            let innermost = dispatch!(level, simd => samples.innermost(simd, solid, self.relative));
            if let Some(vertex) = innermost {
                self.test_vertex(solid, vertex);
            }
        }
    }

    fn test_vertex(&mut self, solid: &SolidLeaf, vertex: u32) {
        self.incumbent.work.primitive_tests += 1;
        let vertex = &RoundedCore::point(&self.surface.vertex(vertex));
        let (a, b) = if self.solid_is_a { (&solid.core, vertex) } else { (vertex, &solid.core) };
        if let Some(found) = separation_within(a, b, self.pose_ab, self.incumbent.bound()) {
            self.incumbent.offer(found);
        }
    }

    fn test(&mut self, solid: &SolidLeaf, number: u32) {
        self.incumbent.work.primitive_tests += 1;
        let triangle = &self.surface.core(number);
        let numbers = (ElementNumber::of_solid(solid.number), ElementNumber::of_triangle(number));
        let ((a, b), numbers) = if self.solid_is_a {
            ((&solid.core, triangle), numbers)
        } else {
            ((triangle, &solid.core), (numbers.1, numbers.0))
        };
        if let Some(found) = separation_within(a, b, self.pose_ab, self.incumbent.bound()) {
            self.incumbent.offer_numbered(found, numbers);
        }
    }
}

impl<B: BoundingVolume, const SEPARATE: bool> Visitor<SolidLeaf, TriangleLeaf>
    for SurfaceSolid<'_, '_, B, SEPARATE>
{
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
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, solid: &SolidLeaf, leaf: &TriangleLeaf) {
        self.incumbent.work.screened_pairs += u64::from(leaf.count);
        let slack = triangle_slack(self.relative);
        let lower = solid_lanes::lower_bounds(simd, solid, leaf, self.relative, &self.direction(), slack);
        let mut near = not_beyond(lower, self.incumbent.threshold()) & leaf.mask();
        let lower: [f32; LANES] = lower.into();
        // the nearest first, so that few are tested exactly
        while near != 0 {
            let lane = nearest(&lower, near);
            near &= !(1 << lane);
            if lower[lane] > self.incumbent.threshold() {
                return;
            }
            self.test(solid, leaf.first + lane as u32);
        }
    }
}
