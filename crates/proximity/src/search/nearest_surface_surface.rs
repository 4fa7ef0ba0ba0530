//! Narrow phase between leaves of two surfaces.

use clearance_geometry::Triangle;
use clearance_geometry::math::MatrixPose;
use clearance_geometry::simd::{LANES, Simd, f32x8, not_beyond};

use super::best_so_far::BestSoFar;
use super::triangle_candidates::{TriangleCandidate, TriangleCandidates};
use crate::body::Surface;
use crate::bounding_volume::Relative;
use crate::bvh::{TriangleLeaf, Visitor};
use crate::elements::{ElementId, ElementPair};
use crate::narrow_phase::{LaneTriangles, MovedTriangles, Separation, TrianglePairs, triangle_slack};

/// Finds the nearest triangles of two surfaces; with `SEPARATE` only any that touch.
///
/// Distances are first bounded in f32. Triangles that may be the nearest are kept as candidates until the bound no longer improves; the
/// remaining candidates are then measured in f64.
pub(crate) struct SurfaceSurfaceVisitor<'s, 'w, const SEPARATE: bool> {
    pub a: &'s Surface,
    pub b: &'s Surface,
    pub pose_ab: &'s MatrixPose,
    /// Relative pose of the trees.
    pub relative: &'s Relative,
    pub best_so_far: &'s mut BestSoFar<'w>,
    pub candidates: &'s mut TriangleCandidates,
}

impl<const SEPARATE: bool> SurfaceSurfaceVisitor<'_, '_, SEPARATE> {
    fn contact(&mut self, i: u32, j: u32) {
        self.best_so_far.work.primitive_tests += 1;
        let (a, b) = (self.a.triangle(i), placed(&self.b.triangle(j), self.pose_ab));
        if let Some(point) = a.contact_point(&b) {
            self.best_so_far.offer(Separation::touching_at(point));
        }
    }

    /// Measures the distance of triangle `i` of a and triangle `j` of b.
    #[inline]
    pub fn measure(&mut self, i: u32, j: u32) {
        self.best_so_far.work.primitive_tests += 1;
        let elements = ElementPair { a: ElementId::of_triangle(i), b: ElementId::of_triangle(j) };
        let found = separation_of_triangles(&self.a.triangle(i), &self.b.triangle(j), self.pose_ab);
        self.best_so_far.offer_elements(found, elements);
    }

    /// Bounds the distances of eight pairs of triangles and keeps those that may be the nearest; `indices` gives the indices of the
    /// triangles in a lane. Returns lower bounds (m).
    #[inline(always)]
    pub fn screen<S: Simd>(
        &mut self,
        simd: S,
        pairs: TrianglePairs<S>,
        indices: impl Fn(usize) -> (u32, u32),
    ) -> f32x8<S> {
        let TrianglePairs { one, other, slack, mask } = pairs;
        self.best_so_far.work.screened_pairs += u64::from(mask.count_ones());
        let coarse = one.coarse_bounds(simd, other, self.candidates.direction(), slack);
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
            let (i, j) = indices(lane);
            self.keep(lower[lane & 7], i, j);
        }
        distances.lower
    }

    /// Keeps a candidate; measures it at once if it may touch.
    fn keep(&mut self, lower: f32, i: u32, j: u32) {
        if lower <= 0.0 || lower.is_nan() {
            return self.measure(i, j);
        }
        if self.candidates.len() == TriangleCandidates::MOST {
            self.make_room();
        }
        self.candidates.push(TriangleCandidate { lower, a: i, b: j });
    }

    /// Removes pairs that can no longer be the nearest; if this frees too little space, the remaining candidates are measured.
    #[cold]
    fn make_room(&mut self) {
        let threshold = self.threshold();
        self.candidates.retain_within(threshold);
        if self.candidates.len() > TriangleCandidates::MOST / 2 {
            self.measure_candidates();
        }
    }

    /// Leaves the candidates to the caller; later pairs must be as near.
    #[inline]
    pub fn postpone_candidates(&mut self) {
        self.best_so_far.lower_limit(f64::from(self.candidates.upper()));
    }

    /// Measures the remaining candidates.
    #[inline]
    pub fn measure_candidates(&mut self) {
        for k in 0..self.candidates.len() {
            let TriangleCandidate { lower, a, b } = self.candidates.get(k);
            if lower <= self.threshold() {
                self.measure(a, b);
            }
        }
        self.candidates.clear();
    }
}

impl<const SEPARATE: bool> Visitor<TriangleLeaf, TriangleLeaf> for SurfaceSurfaceVisitor<'_, '_, SEPARATE> {
    const SEPARATE: bool = SEPARATE;

    fn threshold(&self) -> f32 {
        self.best_so_far.threshold_below(self.candidates.upper())
    }

    fn direction(&self) -> [f32; 3] {
        *self.candidates.direction()
    }

    fn volume_tests(&mut self, count: u32) {
        self.best_so_far.work.volume_tests += u64::from(count);
    }

    fn interrupted(&mut self) -> bool {
        self.best_so_far.interrupted()
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
            lanes &= moved.near_along(simd, &eight, self.candidates.direction(), margin);
        }
        while lanes != 0 && !self.best_so_far.is_settled() {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            let one = moved.one(simd, lane as usize);
            if SEPARATE {
                self.best_so_far.work.screened_pairs += u64::from(b.count);
                let mut near = one.may_touch(simd, &eight, slack) & b.mask();
                while near != 0 && !self.best_so_far.is_settled() {
                    self.contact(a.first + lane, b.first + near.trailing_zeros());
                    near &= near - 1;
                }
                continue;
            }
            let pairs = TrianglePairs { one: &one, other: &eight, slack, mask: b.mask() };
            self.screen(simd, pairs, |other| (a.first + lane, b.first + other as u32));
        }
    }
}

/// The distance of a triangle of one surface from one of another, each in the frame of its body.
#[inline]
pub(crate) fn separation_of_triangles(a: &Triangle, b: &Triangle, pose_ab: &MatrixPose) -> Separation {
    Separation::of(a.nearest_points(&placed(b, pose_ab)))
}

/// A triangle of b in the frame of a.
fn placed(b: &Triangle, pose_ab: &MatrixPose) -> Triangle {
    Triangle { a: pose_ab * b.a, b: pose_ab * b.b, c: pose_ab * b.c }
}
