//! Lower bounds on the distances of a triangle, or of a cube, to eight cubes, in f32.

use clearance_geometry::Cube;
use clearance_geometry::math::Extremes;
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, Vectors, f32x8};

use crate::bvh::CubeLeaf;

/// A triangle in the frame of the cubes' tree, with the values used by the tests. Its values may be inexact: the gap along any resulting
/// direction is a lower bound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OneTriangle {
    corners: [[f32; 3]; 3],
    /// Edges, each from the corner with its index to the next one.
    edges: [[f32; 3]; 3],
    /// Inverse squares of the edges' lengths.
    over_squared: [f32; 3],
    normal: [f32; 3],
    over_normal_squared: f32,
    /// Vectors in the plane, normal to each edge and inward.
    inward: [[f32; 3]; 3],
    /// 1-norms of all edges.
    size: f32,
    low: [f32; 3],
    high: [f32; 3],
}

impl OneTriangle {
    #[inline(always)]
    pub fn new(corners: [[f32; 3]; 3]) -> Self {
        let [p, q, r] = corners;
        let edges = [minus(q, p), minus(r, q), minus(p, r)];
        let normal = cross(edges[0], edges[1]);
        let over = |v: [f32; 3]| 1.0 / dot(v, v).greater(1e-36);
        let one_norm = |v: [f32; 3]| v[0].abs() + v[1].abs() + v[2].abs();
        let least = |i: usize| p[i].lesser(q[i]).lesser(r[i]);
        let most = |i: usize| p[i].greater(q[i]).greater(r[i]);
        Self {
            corners,
            edges,
            over_squared: [over(edges[0]), over(edges[1]), over(edges[2])],
            normal,
            over_normal_squared: over(normal),
            inward: [cross(normal, edges[0]), cross(normal, edges[1]), cross(normal, edges[2])],
            size: one_norm(edges[0]) + one_norm(edges[1]) + one_norm(edges[2]),
            low: [least(0), least(1), least(2)],
            high: [most(0), most(1), most(2)],
        }
    }

    /// Lower bounds on the distances (m) of the cubes, from the box around the triangle; and, unless these all exceed `limit`, along the
    /// direction in which the triangle is nearest to each centre. Coordinates may have an error of `slack`.
    #[inline(always)]
    pub fn lower_bounds<S: Simd>(&self, simd: S, cubes: &CubeLeaf, limit: f32, slack: f32) -> f32x8<S> {
        let centre = Vectors::load(simd, &cubes.centre);
        let half = f32x8::from_slice(simd, &cubes.half_edge);
        let above = Vectors::splat(simd, &self.low).minus(centre);
        let below = centre.minus(Vectors::splat(simd, &self.high));
        let aside = above.max(below);
        let aside = Vectors { x: aside.x - half, y: aside.y - half, z: aside.z - half };
        let from_box = aside.max(Vectors::splat(simd, &[0.0; 3])).norm();
        let from_box = from_box - (from_box + half) * (16.0 * f32::EPSILON) - 4.0 * slack;
        if from_box.simd_gt(limit).all_true() {
            return from_box;
        }
        let w = [
            centre.minus(Vectors::splat(simd, &self.corners[0])),
            centre.minus(Vectors::splat(simd, &self.corners[1])),
            centre.minus(Vectors::splat(simd, &self.corners[2])),
        ];
        let away = self.away(simd, &w);
        let length = away.norm();
        let gap = away.dot(w[0]).min(away.dot(w[1])).min(away.dot(w[2])) - half * away.one_norm();
        let along = gap / length.max(f32x8::splat(simd, 1e-18));
        let rounding = (length + half + self.size) * (16.0 * f32::EPSILON) + 4.0 * slack;
        from_box.max(along - rounding)
    }

    /// Approximate vectors from the nearest point of the triangle to each centre, from those of its corners to the centre (Ericson,
    /// *Real-Time Collision Detection*, 5.1.5).
    #[inline(always)]
    fn away<S: Simd>(&self, simd: S, w: &[Vectors<S>; 3]) -> Vectors<S> {
        let (zero, unit) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let mut nearest = w[0];
        let mut squared = w[0].dot(w[0]);
        for (i, corner) in w.iter().enumerate() {
            let t = (corner.along(&self.edges[i]) * self.over_squared[i]).max(zero).min(unit);
            let from_edge = corner.minus(Vectors::splat(simd, &self.edges[i]).scaled(t));
            let s = from_edge.dot(from_edge);
            nearest = from_edge.or(s.simd_lt(squared), nearest);
            squared = s.min(squared);
        }
        let inside = (w[0].along(&self.inward[0]))
            .min(w[1].along(&self.inward[1]))
            .min(w[2].along(&self.inward[2]))
            .simd_ge(zero);
        let height = w[0].along(&self.normal) * self.over_normal_squared;
        let from_face = Vectors::splat(simd, &self.normal).scaled(height);
        // a sliver's normal is noise, and the face is no nearer than its edges
        let nearer = from_face.dot(from_face).simd_lt(squared);
        from_face.or(inside & nearer, nearest)
    }
}

/// For each of eight cubes a lower bound on its distance (m) from another cube, whose centre is placed in their frame: the distance of
/// the balls around them.
#[inline(always)]
pub(crate) fn lower_bounds_from_cube<S: Simd>(simd: S, cube: Cube, cubes: &CubeLeaf, slack: f32) -> f32x8<S> {
    /// The least f32 above the square root of three.
    const DIAGONAL: f32 = 1.732_051;
    let apart = Vectors::load(simd, &cubes.centre).minus(Vectors::splat(simd, &cube.centre)).norm();
    let half = f32x8::from_slice(simd, &cubes.half_edge) + cube.half_edge;
    apart - half * DIAGONAL - (apart + half) * (16.0 * f32::EPSILON) - 4.0 * slack
}

/// The lane of `mask` with the smallest number.
#[inline]
pub(crate) fn nearest_lane(numbers: &[f32; LANES], mask: u64) -> usize {
    let lanes = (0..LANES).filter(|lane| mask & (1 << lane) != 0);
    lanes.min_by(|&i, &j| numbers[i].total_cmp(&numbers[j])).unwrap_or(0)
}

#[inline(always)]
fn minus(p: [f32; 3], q: [f32; 3]) -> [f32; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline(always)]
fn dot(p: [f32; 3], q: [f32; 3]) -> f32 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

#[inline(always)]
fn cross(p: [f32; 3], q: [f32; 3]) -> [f32; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}
