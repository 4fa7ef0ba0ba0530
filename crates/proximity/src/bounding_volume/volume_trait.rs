//! Trait of all bounding volumes: fit to points, pack into SIMD lanes, lower bounds on distances.

use std::fmt::Debug;

use clearance_geometry::math::{RotationMatrix, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{Simd, f32x8};

use super::outline::Outline;
use super::relative::Relative;

/// A bounding volume: cheap to test, and contains everything it was fitted to.
pub trait BoundingVolume: Copy + Debug + Send + Sync + 'static {
    /// Eight volumes of one frame, structure of arrays.
    type Pack: Clone + Debug + Send + Sync;

    /// Eight volumes of one frame, transformed to another frame, to be tested one by one.
    type Seen: Copy;

    /// Eight volumes of a frame, prepared for tests against a volume transformed to that frame.
    type Facing<S: Simd>: Copy;

    /// Axes, as columns, of a suitable frame for volumes around `points`.
    fn axes(points: &[Vector]) -> RotationMatrix;

    /// A volume that contains the convex hull of `points`, in the frame of their coordinates.
    fn fit(points: &[Vector]) -> Self;

    /// Its shape, in the frame of the coordinates, for visualisation only.
    fn outline(&self) -> Outline;

    /// Packs volumes; unused lanes repeat the last one.
    fn pack(volumes: &[Self]) -> Self::Pack;

    /// The same volume in all lanes.
    fn splat(&self) -> Self::Pack;

    /// The volumes of `pack`, transformed from their frame, which is placed at `relative`.
    fn seen<S: Simd>(simd: S, pack: &Self::Pack, relative: &Relative) -> Self::Seen;

    /// Prepares `pack` for volumes whose frame is placed at `relative` in its own.
    fn facing<S: Simd>(simd: S, pack: &Self::Pack, relative: &Relative) -> Self::Facing<S>;

    /// For each transformed volume a lower bound on its distance (m) to `other`; cheap rather than tight.
    fn coarse_bounds<S: Simd>(simd: S, seen: &Self::Seen, other: &Self, relative: &Relative) -> f32x8<S>;

    /// For each volume of a pack, its range (m) along a direction of its frame.
    fn extents<S: Simd>(simd: S, _pack: &Self::Pack, _direction: &[f32; 3]) -> [f32x8<S>; 2] {
        [f32x8::splat(simd, f32::NEG_INFINITY), f32x8::splat(simd, f32::INFINITY)]
    }

    /// For the transformed volume in `lane`, lower bounds (m) on its distances to the eight prepared ones, up to the rounding of
    /// [`Relative::slack`]; negative where they overlap, the more the deeper.
    ///
    /// With `SEPARATE` only the sign is needed: any positive value is sufficient.
    fn bounds<S: Simd, const SEPARATE: bool>(
        simd: S,
        facing: &Self::Facing<S>,
        seen: &Self::Seen,
        lane: usize,
        relative: &Relative,
    ) -> f32x8<S>;
}
