//! Distance bounds of a solid to the eight triangles or cubes of a leaf, in f32.

use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{Simd, Vectors, f32x8};

use super::single_precision::triangle_slack;
use crate::body::{Hull, SolidLeaf};
use crate::bounding_volume::{Axes, Relative};
use crate::bvh::{CubeLeaf, TriangleLeaf};

/// Lower bounds on the distances (m) of the triangles of `leaf` from the solid; `relative` places the solid's tree in the leaf's.
/// Computed from the boxes around the triangles, along the triangles' normals, and along a `direction` (length at most one) in which near
/// elements were found.
#[inline(always)]
pub(crate) fn lower_bounds_of_triangles<S: Simd>(
    simd: S,
    solid: &SolidLeaf,
    leaf: &TriangleLeaf,
    relative: &Relative,
    direction: &[f32; 3],
) -> f32x8<S> {
    let slack = triangle_slack(relative);
    // the triangles in the frame of the solid
    let own = relative.of_nodes(&solid.axes, &Axes::IDENTITY);
    let centre = Vectors::splat(simd, &relative.point(&solid.centre));
    let p = Vectors::load(simd, &leaf.corners[0]).minus(centre).turned_back(&own.r);
    let q = Vectors::load(simd, &leaf.corners[1]).minus(centre).turned_back(&own.r);
    let r = Vectors::load(simd, &leaf.corners[2]).minus(centre).turned_back(&own.r);
    let hull = &solid.hull;
    let (low, high) = (p.min(q).min(r), p.max(q).max(r));
    let from_boxes = hull.distance_of_boxes(simd, low, high);
    let (e, f) = (q.minus(p), r.minus(q));
    let n = e.cross(f);
    let over = n.dot(p).abs() - hull.shadow(simd, n);
    // the normal has an error of the slack times the edges, with the corner and the box as lever
    let lever = p.one_norm() + hull.size();
    let rounding = (n.one_norm() + (e.one_norm() + f.one_norm()) * lever * 2.0) * (2.0 * slack);
    let length = n.dot(n).max(f32x8::splat(simd, 1e-30)).sqrt();
    let across_plane = (over - rounding) / length;
    // the solid's projection extends to either side of its centre
    let along = own.along_a(direction);
    let shadow = hull.shadow(simd, Vectors::splat(simd, &along));
    let (a, b, c) = (p.along(&along), q.along(&along), r.along(&along));
    let beyond = a.min(b).min(c).max(f32x8::splat(simd, 0.0) - a.max(b).max(c)) - shadow;
    from_boxes.max(across_plane).max(beyond) - 4.0 * slack
}

/// As [`lower_bounds_of_triangles`] for the cubes of a leaf, without the balls around them; `relative` places their tree in the solid's.
#[inline(always)]
pub(crate) fn lower_bounds_of_cubes<S: Simd>(
    simd: S,
    solid: &SolidLeaf,
    cubes: &CubeLeaf,
    relative: &Relative,
) -> f32x8<S> {
    let slack = triangle_slack(relative);
    // the cubes in the frame of the solid
    let own = relative.of_nodes(&Axes::IDENTITY, &solid.axes);
    let [x, y, z] = solid.axes.turned(&solid.centre);
    let centre =
        Vectors::load(simd, &cubes.centre).placed(&own.r, &[own.t[0] - x, own.t[1] - y, own.t[2] - z]);
    let half = f32x8::from_slice(simd, &cubes.half_edge);
    let [u, v, w] = &own.r;
    let shadow = |row: &[f32; 3]| row[0].abs() + row[1].abs() + row[2].abs();
    let shadow = Vectors { x: half * shadow(u), y: half * shadow(v), z: half * shadow(w) };
    let from_hull = solid.hull.distance_of_boxes(simd, centre.minus(shadow), centre.plus(shadow));
    from_hull - half * (16.0 * f32::EPSILON) - 4.0 * slack
}

impl Hull {
    /// Extent of the solid along n from its centre, times |n|.
    #[inline(always)]
    fn shadow<S: Simd>(&self, simd: S, n: Vectors<S>) -> f32x8<S> {
        let n = n.abs();
        let round = (n.x * n.x + n.y * n.y).sqrt() * self.disc + n.norm() * self.ball;
        n.dot(Vectors::splat(simd, &self.half_extents)) + round
    }

    /// Of boxes with these corners.
    #[inline(always)]
    fn distance_of_boxes<S: Simd>(&self, simd: S, low: Vectors<S>, high: Vectors<S>) -> f32x8<S> {
        let zero = Vectors::splat(simd, &[0.0; 3]);
        let gap = low.max(zero.minus(high)).minus(Vectors::splat(simd, &self.half_extents)).max(zero);
        let aside = ((gap.x * gap.x + gap.y * gap.y).sqrt() - self.disc).max(0.0);
        (aside * aside + gap.z * gap.z).sqrt() - self.ball
    }

    /// Upper bound on the 1-norm of the box around it.
    fn size(&self) -> f32 {
        self.half_extents.iter().sum::<f32>() + 3.0 * (self.disc + self.ball)
    }
}
