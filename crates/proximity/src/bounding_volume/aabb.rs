//! Axis-aligned bounding boxes (van den Bergen 1997): boxes whose frame is always the tree's own.

use clearance_geometry::math::{RotationMatrix, Vector};
use clearance_geometry::simd::{Simd, f32x8};

use super::obb::{FacingObbs, Obb, ObbPack, SeenObbs};
use super::outline::Outline;
use super::relative::Relative;
use super::volume_trait::BoundingVolume;

/// A box along the axes of the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb(pub Obb);

impl BoundingVolume for Aabb {
    type Pack = ObbPack;
    type Seen = SeenObbs;
    type Facing<S: Simd> = FacingObbs<S>;

    fn axes(_: &[Vector]) -> RotationMatrix {
        RotationMatrix::identity()
    }

    fn fit(points: &[Vector]) -> Self {
        Self(Obb::fit(points))
    }

    fn outline(&self) -> Outline {
        self.0.outline()
    }

    fn pack(volumes: &[Self]) -> ObbPack {
        let boxes: Vec<Obb> = volumes.iter().map(|v| v.0).collect();
        Obb::pack(&boxes)
    }

    #[inline(always)]
    fn splat(&self) -> ObbPack {
        self.0.splat()
    }

    #[inline(always)]
    fn seen<S: Simd>(simd: S, pack: &ObbPack, relative: &Relative) -> SeenObbs {
        Obb::seen(simd, pack, relative)
    }

    #[inline(always)]
    fn facing<S: Simd>(simd: S, pack: &ObbPack, relative: &Relative) -> FacingObbs<S> {
        Obb::facing(simd, pack, relative)
    }

    #[inline(always)]
    fn coarse_bounds<S: Simd>(simd: S, seen: &SeenObbs, other: &Self, relative: &Relative) -> f32x8<S> {
        Obb::coarse_bounds(simd, seen, &other.0, relative)
    }

    #[inline(always)]
    fn extents<S: Simd>(simd: S, pack: &ObbPack, direction: &[f32; 3]) -> [f32x8<S>; 2] {
        Obb::extents(simd, pack, direction)
    }

    #[inline(always)]
    fn bounds<S: Simd, const SEPARATE: bool>(
        simd: S,
        facing: &FacingObbs<S>,
        seen: &SeenObbs,
        lane: usize,
        relative: &Relative,
    ) -> f32x8<S> {
        Obb::bounds::<S, SEPARATE>(simd, facing, seen, lane, relative)
    }
}
