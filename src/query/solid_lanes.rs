//! The box around a solid against the eight triangles of a leaf, in f32.

use super::solid::SolidLeaf;
use crate::bounding_volume::{Axes, Relative};
use crate::bvh::TriangleLeaf;
use crate::simd::prelude::*;
use crate::simd::{Simd, Vectors, f32x8};

/// Numbers never larger than the distances (m) of the triangles of `leaf` from the solid; `relative` places the solid's
/// tree in the leaf's. Across the faces of the box around the solid, across the triangles' planes, and along a `direction`
/// (not longer than one) in which something near was found.
#[inline(always)]
pub(super) fn lower_bounds<S: Simd>(
    simd: S,
    solid: &SolidLeaf,
    leaf: &TriangleLeaf,
    relative: &Relative,
    direction: &[f32; 3],
    slack: f32,
) -> f32x8<S> {
    // the triangles in the frame of the box
    let own = relative.of_nodes(&solid.axes, &Axes::IDENTITY);
    let centre = Vectors::splat(simd, &relative.point(&solid.centre));
    let p = Vectors::load(simd, &leaf.corners[0]).minus(centre).turned_back(&own.r);
    let q = Vectors::load(simd, &leaf.corners[1]).minus(centre).turned_back(&own.r);
    let r = Vectors::load(simd, &leaf.corners[2]).minus(centre).turned_back(&own.r);
    let zero = Vectors::splat(simd, &[0.0; 3]);
    let half = Vectors::splat(simd, &solid.half_extents);
    let (low, high) = (p.min(q).min(r), p.max(q).max(r));
    let across_box = low.max(zero.minus(high)).minus(half).max(zero).norm();
    let (e, f) = (q.minus(p), r.minus(q));
    let n = e.cross(f);
    let over = n.dot(p).abs() - n.abs().dot(half);
    // the normal may be off by the slack times the edges, at a lever of the corner and the box
    let lever = p.one_norm() + half.one_norm();
    let rounding = (n.one_norm() + (e.one_norm() + f.one_norm()) * lever * 2.0) * (2.0 * slack);
    let length = n.dot(n).max(f32x8::splat(simd, 1e-30)).sqrt();
    let across_plane = (over - rounding) / length;
    // the box spans its shadow either way from its centre
    let along_box = own.along_a(direction);
    let shadow = half.along(&[along_box[0].abs(), along_box[1].abs(), along_box[2].abs()]);
    let (a, b, c) = (p.along(&along_box), q.along(&along_box), r.along(&along_box));
    let beyond = a.min(b).min(c).max(f32x8::splat(simd, 0.0) - a.max(b).max(c)) - shadow;
    across_box.max(across_plane).max(beyond) - 4.0 * slack
}
