//! Pairs of triangles that may be the nearest, collected before they are measured in f64.

use clearance_geometry::simd::Simd;
use clearance_geometry::simd::prelude::*;

use crate::bounding_volume::Relative;
use crate::narrow_phase::{DistanceLanes, shortened};

/// A triangle of a and one of b.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleCandidate {
    /// Lower bound (m) on the distance.
    pub lower: f32,
    /// Index of the triangle of a.
    pub a: u32,
    /// Index of the triangle of b.
    pub b: u32,
}

/// Pairs of triangles that may be the nearest.
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangleCandidates {
    /// Upper bound (m) on the least distance of triangles.
    upper: f32,
    /// The direction of the pair with this distance, in the frame of b's tree; length at most one.
    direction: [f32; 3],
    pairs: Vec<TriangleCandidate>,
}

impl TriangleCandidates {
    /// Number of candidates that are kept before they are measured.
    pub const MOST: usize = 32;

    /// Removes all candidates. If distances matter, the search direction starts as that between the trees.
    #[inline]
    pub fn begin(&mut self, trees: Option<&Relative>) {
        self.upper = f32::INFINITY;
        self.direction = trees.map_or([0.0; 3], |trees| shortened(trees.t));
        self.pairs.clear();
    }

    /// Upper bound (m) on the least distance of the candidates; infinity if there are none.
    #[inline]
    pub fn upper(&self) -> f32 {
        self.upper
    }

    /// The direction of the nearest pair so far, in the frame of b's tree; length at most one.
    #[inline]
    pub fn direction(&self) -> &[f32; 3] {
        &self.direction
    }

    #[inline]
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    #[inline]
    pub fn get(&self, index: usize) -> TriangleCandidate {
        self.pairs[index]
    }

    #[inline]
    pub fn push(&mut self, candidate: TriangleCandidate) {
        self.pairs.push(candidate);
    }

    /// Removes candidates farther apart than `threshold` (m).
    #[inline]
    pub fn retain_within(&mut self, threshold: f32) {
        self.pairs.retain(|pair| pair.lower <= threshold);
    }

    #[inline]
    pub fn clear(&mut self) {
        self.pairs.clear();
    }

    /// Removes and returns all candidates.
    #[inline]
    pub fn drain(&mut self) -> impl Iterator<Item = TriangleCandidate> {
        self.pairs.drain(..)
    }

    /// Keeps the upper bound and the direction of the nearest of eight pairs, if it is nearer.
    #[inline(always)]
    pub fn take_upper<S: Simd>(&mut self, simd: S, distances: &DistanceLanes<S>) {
        let least = simd.reduce_min_f32x8(distances.upper);
        if least < self.upper {
            self.upper = least;
            let lane = distances.upper.simd_le(least).to_bitmask().trailing_zeros();
            self.direction = distances.direction(lane as usize);
        }
    }
}
