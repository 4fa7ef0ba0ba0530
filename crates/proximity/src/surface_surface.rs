//! Narrow phase between leaves of two surfaces.

use clearance_geometry::Triangle;
use clearance_geometry::constants::{CONTACT_DISTANCE, TRIANGLE_SHARE};
use clearance_geometry::math::{Extremes, MatrixPose};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, f32x8, not_beyond};

use super::element::ElementNumber;
use super::element_pair::Separation;
use super::incumbent::Incumbent;
use super::surface::Surface;
use super::triangle_lanes::{DistanceLanes, LaneTriangles, MovedTriangles};
use crate::bounding_volume::{BoundingVolume, Relative};
use crate::bvh::{TriangleLeaf, Visitor};

/// Finds the nearest triangles of two surfaces; with `SEPARATE` only any that touch.
///
/// Distances are first bounded in f32. Triangles that may be the nearest are kept as candidates until the bound no longer improves; the
/// remaining candidates are then measured in f64.
pub(super) struct SurfaceSurface<'s, 'w, B: BoundingVolume, const SEPARATE: bool> {
    pub a: &'s Surface<B>,
    pub b: &'s Surface<B>,
    pub pose_ab: &'s MatrixPose,
    /// Relative pose of the trees.
    pub relative: &'s Relative,
    pub incumbent: &'s mut Incumbent<'w>,
    pub candidates: &'s mut Candidates,
}

/// Candidates: pairs of triangles that may be the nearest.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates {
    /// Upper bound (m) on the least distance of triangles.
    upper: f32,
    /// The direction of the pair with this distance, in the frame of b's tree; length at most one.
    direction: [f32; 3],
    /// Lower bound on the distance (m), and the indices of a triangle of a and one of b.
    pairs: Vec<(f32, u32, u32)>,
}

impl Candidates {
    /// Number of candidates that are kept before they are measured.
    const MOST: usize = 32;

    /// Removes all candidates. If distances matter, the search direction starts as that between the trees.
    #[inline]
    pub fn begin(&mut self, trees: Option<&Relative>) {
        self.upper = f32::INFINITY;
        self.direction = trees.map_or([0.0; 3], |trees| shortened(trees.t));
        self.pairs.clear();
    }

    /// Upper bound (m) on the least distance of the candidates; infinity if there are none.
    #[inline]
    pub fn upper(&self) -> f64 {
        f64::from(self.upper)
    }

    /// All candidates, each with a lower bound on its distance (m).
    #[inline]
    pub fn drain(&mut self) -> impl Iterator<Item = (f64, u32, u32)> {
        self.pairs.drain(..).map(|(lower, i, j)| (f64::from(lower), i, j))
    }

    #[inline(always)]
    fn take_upper<S: Simd>(&mut self, simd: S, distances: &DistanceLanes<S>) {
        let least = simd.reduce_min_f32x8(distances.upper);
        if least < self.upper {
            self.upper = least;
            let lane = distances.upper.simd_le(least).to_bitmask().trailing_zeros();
            self.direction = distances.direction(lane as usize);
        }
    }
}

impl<B: BoundingVolume, const SEPARATE: bool> SurfaceSurface<'_, '_, B, SEPARATE> {
    fn contact(&mut self, i: u32, j: u32) {
        self.incumbent.work.primitive_tests += 1;
        let (a, b) = triangles((self.a, i), (self.b, j), self.pose_ab);
        if let Some(point) = a.contact_point(&b) {
            self.incumbent.offer(Separation::touching_at(point));
        }
    }

    #[inline]
    pub fn measure(&mut self, i: u32, j: u32) {
        self.incumbent.work.primitive_tests += 1;
        let numbers = (ElementNumber::of_triangle(i), ElementNumber::of_triangle(j));
        let found = separation_of_triangles((self.a, i), (self.b, j), self.pose_ab);
        self.incumbent.offer_numbered(found, numbers);
    }

    /// Bounds the distances of eight pairs of triangles, selected by `mask`, and keeps those that may be the nearest; `numbers` gives the
    /// indices of the triangles in a lane. Returns lower bounds (m).
    #[inline(always)]
    pub fn screen<S: Simd>(
        &mut self,
        simd: S,
        one: &LaneTriangles<S>,
        other: &LaneTriangles<S>,
        slack: f32,
        mask: u64,
        numbers: impl Fn(usize) -> (u32, u32),
    ) -> f32x8<S> {
        self.incumbent.work.screened_pairs += u64::from(mask.count_ones());
        let coarse = one.coarse_bounds(simd, other, &self.candidates.direction, slack);
        if not_beyond(coarse, self.threshold()) & mask == 0 {
            return coarse;
        }
        let distances = one.bounds(simd, other, slack);
        self.candidates.take_upper(simd, &distances);
        let mut near = not_beyond(distances.lower, self.threshold()) & mask;
        let lower: [f32; LANES] = distances.lower.into();
        while near != 0 {
            let lane = near.trailing_zeros() as usize;
            near &= near - 1;
            let (i, j) = numbers(lane);
            self.keep(lower[lane & 7], i, j);
        }
        distances.lower
    }

    /// Keeps a candidate; measures it at once if it may touch.
    fn keep(&mut self, lower: f32, i: u32, j: u32) {
        if lower <= 0.0 || lower.is_nan() {
            return self.measure(i, j);
        }
        if self.candidates.pairs.len() == Candidates::MOST {
            self.make_room();
        }
        self.candidates.pairs.push((lower, i, j));
    }

    /// Removes pairs that can no longer be the nearest; if this frees too little space, the remaining candidates are measured.
    #[cold]
    fn make_room(&mut self) {
        let threshold = self.threshold();
        self.candidates.pairs.retain(|(lower, ..)| *lower <= threshold);
        if self.candidates.pairs.len() > Candidates::MOST / 2 {
            self.measure_candidates();
        }
    }

    /// Leaves the candidates to the caller; later pairs must be as near.
    #[inline]
    pub fn postpone_candidates(&mut self) {
        self.incumbent.lower_limit(self.candidates.upper());
    }

    /// Measures the remaining candidates.
    #[inline]
    pub fn measure_candidates(&mut self) {
        for k in 0..self.candidates.pairs.len() {
            let (lower, i, j) = self.candidates.pairs[k];
            if lower <= self.threshold() {
                self.measure(i, j);
            }
        }
        self.candidates.pairs.clear();
    }
}

impl<B: BoundingVolume, const SEPARATE: bool> Visitor<TriangleLeaf, TriangleLeaf>
    for SurfaceSurface<'_, '_, B, SEPARATE>
{
    const SEPARATE: bool = SEPARATE;

    fn threshold(&self) -> f32 {
        self.incumbent.threshold().lesser(self.candidates.upper)
    }

    fn direction(&self) -> [f32; 3] {
        self.candidates.direction
    }

    fn volume_tests(&mut self, count: u32) {
        self.incumbent.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.incumbent.interrupted()
    }

    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // lanes are few
    fn leaves<S: Simd>(&mut self, simd: S, a: &TriangleLeaf, b: &TriangleLeaf) {
        let slack = triangle_slack(self.relative);
        let margin = self.threshold() + 4.0 * slack;
        let (moved, mut lanes) = MovedTriangles::new(simd, a, self.relative, (&b.low, &b.high), margin);
        if lanes == 0 {
            return;
        }
        let eight = LaneTriangles::of_leaf(simd, b);
        if !SEPARATE {
            lanes &= moved.near_along(simd, &eight, &self.candidates.direction, margin);
        }
        while lanes != 0 && !self.incumbent.is_settled() {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            let one = moved.one(simd, lane as usize);
            if SEPARATE {
                self.incumbent.work.screened_pairs += u64::from(b.count);
                let mut near = one.may_touch(simd, &eight, slack) & b.mask();
                while near != 0 && !self.incumbent.is_settled() {
                    self.contact(a.first + lane, b.first + near.trailing_zeros());
                    near &= near - 1;
                }
                continue;
            }
            self.screen(simd, &one, &eight, slack, b.mask(), |other| {
                (a.first + lane, b.first + other as u32)
            });
        }
    }
}

/// The distance of a triangle of one surface from one of another.
#[inline]
pub(super) fn separation_of_triangles<B: BoundingVolume>(
    a: (&Surface<B>, u32),
    b: (&Surface<B>, u32),
    pose_ab: &MatrixPose,
) -> Separation {
    let (a, b) = triangles(a, b, pose_ab);
    Separation::of(a.nearest_points(&b))
}

/// A triangle of one surface and one of another, in the frame of the first.
fn triangles<B: BoundingVolume>(
    (a, i): (&Surface<B>, u32),
    (b, j): (&Surface<B>, u32),
    pose_ab: &MatrixPose,
) -> (Triangle, Triangle) {
    let Triangle { a: p, b: q, c: r } = b.triangle(j);
    (a.triangle(i), Triangle { a: pose_ab * p, b: pose_ab * q, c: pose_ab * r })
}

/// The vector v, scaled to a length of at most one.
#[inline]
pub(super) fn shortened(v: [f32; 3]) -> [f32; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let scale = if length > 1e-15 { (1.0 - 8.0 * f32::EPSILON) / length } else { 0.0 };
    v.map(|c| c * scale)
}

/// Error (m) of f32 coordinates of triangles, plus the contact distance.
#[allow(clippy::cast_possible_truncation)] // rounded up
#[inline]
pub(super) fn triangle_slack(relative: &Relative) -> f32 {
    TRIANGLE_SHARE * relative.slack + (CONTACT_DISTANCE as f32).next_up()
}
