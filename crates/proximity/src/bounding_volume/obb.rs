//! Oriented bounding boxes: boxes along the axes of their frame, tested by separating axes (Gottschalk, Lin & Manocha
//! 1996, *OBBTree*, section 5).

use clearance_geometry::math::{Extremes, Point, RotationMatrix, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, Vectors, f32x8};

use super::outline::Outline;
use super::principal_axes::principal_axes;
use super::relative::Relative;
use super::rounding::{lanes, round, round_up};
use super::volume_trait::BoundingVolume;

/// A box along the axes of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obb {
    /// Centre along the axes of the frame (m).
    pub centre: [f32; 3],
    /// Half extents along the axes of the frame (m).
    pub half_extents: [f32; 3],
}

/// Eight boxes of one frame.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub struct ObbPack {
    centre: [[f32; LANES]; 3],
    half_extents: [[f32; LANES]; 3],
}

/// Eight boxes of a frame a, transformed to another frame, b.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct SeenObbs {
    /// Centres along the axes of b.
    pub(super) centre: [[f32; LANES]; 3],
    /// Half the extents along the axes of b.
    shadow: [[f32; LANES]; 3],
    /// Centres along the boxes' own axes, from the anchor of b.
    pub(super) centre_along_own: [[f32; LANES]; 3],
    pub(super) half_extents: [[f32; LANES]; 3],
}

/// Eight boxes of b, and the same along the axes of a.
#[derive(Clone, Copy, Debug)]
pub struct FacingObbs<S: Simd> {
    pub(super) centre: Vectors<S>,
    pub(super) half_extents: Vectors<S>,
    pub(super) centre_along_a: Vectors<S>,
    shadow: Vectors<S>,
}

impl BoundingVolume for Obb {
    type Pack = ObbPack;
    type Seen = SeenObbs;
    type Facing<S: Simd> = FacingObbs<S>;

    /// The axes of the tree or the principal ones, whichever give the smaller box: faces of machined parts are often along the former.
    fn axes(points: &[Vector]) -> RotationMatrix {
        let principal = principal_axes(points);
        let own = RotationMatrix::identity();
        if area_along(&principal, points) < area_along(&own, points) { principal } else { own }
    }

    fn fit(points: &[Vector]) -> Self {
        let mut lo = Vector::repeat(f64::INFINITY);
        let mut hi = Vector::repeat(f64::NEG_INFINITY);
        for p in points {
            lo = lo.inf(p);
            hi = hi.sup(p);
        }
        let centre: [f32; 3] = std::array::from_fn(|i| round(0.5 * (lo[i] + hi[i])));
        let half = |i: usize| (hi[i] - f64::from(centre[i])).greater(f64::from(centre[i]) - lo[i]);
        Self { centre, half_extents: std::array::from_fn(|i| round_up(half(i))) }
    }

    fn outline(&self) -> Outline {
        let centre = Point::from(self.centre.map(f64::from));
        Outline::Box { centre, half_extents: Vector::from(self.half_extents.map(f64::from)) }
    }

    fn pack(volumes: &[Self]) -> ObbPack {
        ObbPack {
            centre: std::array::from_fn(|i| lanes(volumes, |v| v.centre[i])),
            half_extents: std::array::from_fn(|i| lanes(volumes, |v| v.half_extents[i])),
        }
    }

    #[inline(always)]
    fn splat(&self) -> ObbPack {
        let [x, y, z] = self.centre;
        let [u, v, w] = self.half_extents;
        ObbPack {
            centre: [[x; LANES], [y; LANES], [z; LANES]],
            half_extents: [[u; LANES], [v; LANES], [w; LANES]],
        }
    }

    #[inline(always)]
    fn seen<S: Simd>(simd: S, pack: &ObbPack, relative: &Relative) -> SeenObbs {
        let centre = Vectors::load(simd, &pack.centre);
        let half_extents = Vectors::load(simd, &pack.half_extents);
        let r = &relative.r;
        let anchor = Vectors::splat(simd, &relative.along_a(&relative.t));
        let zero = Vectors::splat(simd, &[0.0; 3]);
        SeenObbs {
            centre: centre.placed(r, &relative.t).store(),
            shadow: half_extents.placed(&magnitudes(r), &[0.0; 3]).store(),
            centre_along_own: centre.minus(zero.minus(anchor)).store(),
            half_extents: pack.half_extents,
        }
    }

    #[inline(always)]
    fn facing<S: Simd>(simd: S, pack: &ObbPack, relative: &Relative) -> FacingObbs<S> {
        let centre = Vectors::load(simd, &pack.centre);
        let half_extents = Vectors::load(simd, &pack.half_extents);
        FacingObbs {
            centre,
            half_extents,
            centre_along_a: centre.turned_back(&relative.r),
            shadow: half_extents.turned_back(&magnitudes(&relative.r)),
        }
    }

    #[inline(always)]
    fn coarse_bounds<S: Simd>(simd: S, seen: &SeenObbs, other: &Self, relative: &Relative) -> f32x8<S> {
        let r = magnitudes(&relative.r);
        let own = relative.along_a(&other.centre);
        let h = &other.half_extents;
        let shadow = [
            r[0][0] * h[0] + r[1][0] * h[1] + r[2][0] * h[2],
            r[0][1] * h[0] + r[1][1] * h[1] + r[2][1] * h[2],
            r[0][2] * h[0] + r[1][2] * h[1] + r[2][2] * h[2],
        ];
        let along_b = (Vectors::load(simd, &seen.centre).minus(Vectors::splat(simd, &other.centre)).abs())
            .minus(Vectors::load(simd, &seen.shadow))
            .minus(Vectors::splat(simd, h));
        let along_a = (Vectors::load(simd, &seen.centre_along_own).minus(Vectors::splat(simd, &own)).abs())
            .minus(Vectors::load(simd, &seen.half_extents))
            .minus(Vectors::splat(simd, &shadow));
        along_b.max(along_a).largest()
    }

    #[inline(always)]
    fn extents<S: Simd>(simd: S, pack: &ObbPack, direction: &[f32; 3]) -> [f32x8<S>; 2] {
        let [x, y, z] = direction;
        let centre = Vectors::load(simd, &pack.centre).along(direction);
        let half = Vectors::load(simd, &pack.half_extents).along(&[x.abs(), y.abs(), z.abs()]);
        [centre - half, centre + half]
    }

    #[inline(always)]
    fn bounds<S: Simd, const SEPARATE: bool>(
        simd: S,
        facing: &FacingObbs<S>,
        seen: &SeenObbs,
        lane: usize,
        relative: &Relative,
    ) -> f32x8<S> {
        let d = facing.centre.minus(Vectors::splat(simd, &taken(&seen.centre, lane)));
        let along_b =
            (d.abs().minus(facing.half_extents)).minus(Vectors::splat(simd, &taken(&seen.shadow, lane)));
        let own = taken(&seen.half_extents, lane);
        let along_a =
            (facing.centre_along_a.minus(Vectors::splat(simd, &taken(&seen.centre_along_own, lane))))
                .abs()
                .minus(facing.shadow)
                .minus(Vectors::splat(simd, &own));
        let gap = along_b.max(along_a).largest();
        if SEPARATE {
            if gap.simd_gt(relative.slack).all_true() {
                return gap;
            }
            return gap.max(edge_gaps(d, facing.half_extents, &own, relative));
        }
        let zero = Vectors::splat(simd, &[0.0; 3]);
        let apart = along_b.max(zero).norm().max(along_a.max(zero).norm());
        apart.simd_gt(f32x8::splat(simd, 0.0)).select(apart, gap)
    }
}

/// The largest gap along the nine axes normal to an edge of each box: one with half extents `own`, and eight at offsets `d` with half
/// extents `h`. The axes have length at most one, hence the gap is at most the distance.
#[inline(always)]
fn edge_gaps<S: Simd>(d: Vectors<S>, h: Vectors<S>, own: &[f32; 3], relative: &Relative) -> f32x8<S> {
    let r = &relative.r;
    let mut gap = edge_gap([d.y, d.z], [h.y, h.z], own, [&r[0], &r[1], &r[2]], 0);
    gap = gap.max(edge_gap([d.y, d.z], [h.y, h.z], own, [&r[0], &r[1], &r[2]], 1));
    gap = gap.max(edge_gap([d.y, d.z], [h.y, h.z], own, [&r[0], &r[1], &r[2]], 2));
    gap = gap.max(edge_gap([d.z, d.x], [h.z, h.x], own, [&r[1], &r[2], &r[0]], 0));
    gap = gap.max(edge_gap([d.z, d.x], [h.z, h.x], own, [&r[1], &r[2], &r[0]], 1));
    gap = gap.max(edge_gap([d.z, d.x], [h.z, h.x], own, [&r[1], &r[2], &r[0]], 2));
    gap = gap.max(edge_gap([d.x, d.y], [h.x, h.y], own, [&r[2], &r[0], &r[1]], 0));
    gap = gap.max(edge_gap([d.x, d.y], [h.x, h.y], own, [&r[2], &r[0], &r[1]], 1));
    gap.max(edge_gap([d.x, d.y], [h.x, h.y], own, [&r[2], &r[0], &r[1]], 2))
}

/// The gap along the axis normal to b's axis 0 and a's axis `j`; offsets and half extents along b's axes 1 and 2, and
/// `rows` of the rotation, in turn from b's axis 0.
#[inline(always)]
fn edge_gap<S: Simd>(
    d: [f32x8<S>; 2],
    h: [f32x8<S>; 2],
    own: &[f32; 3],
    rows: [&[f32; 3]; 3],
    j: usize,
) -> f32x8<S> {
    let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
    let (p, q) = (rows[1][j], rows[2][j]);
    let reach_a = own[j1] * rows[0][j2].abs() + own[j2] * rows[0][j1].abs();
    (d[1] * p - d[0] * q).abs() - h[0] * q.abs() - h[1] * p.abs() - reach_a
}

/// Half the surface area (m²) of the box around points along some axes: proportional to the probability that a line hits it.
fn area_along(axes: &RotationMatrix, points: &[Vector]) -> f64 {
    let mut lo = Vector::repeat(f64::INFINITY);
    let mut hi = Vector::repeat(f64::NEG_INFINITY);
    for p in points {
        let along = axes.tr_mul(p);
        lo = lo.inf(&along);
        hi = hi.sup(&along);
    }
    let d = hi - lo;
    d.x * d.y + d.y * d.z + d.z * d.x
}

#[inline(always)]
fn magnitudes(r: &[[f32; 3]; 3]) -> [[f32; 3]; 3] {
    [
        [r[0][0].abs(), r[0][1].abs(), r[0][2].abs()],
        [r[1][0].abs(), r[1][1].abs(), r[1][2].abs()],
        [r[2][0].abs(), r[2][1].abs(), r[2][2].abs()],
    ]
}

#[inline(always)]
pub(super) fn taken(components: &[[f32; LANES]; 3], lane: usize) -> [f32; 3] {
    [components[0][lane & 7], components[1][lane & 7], components[2][lane & 7]]
}
