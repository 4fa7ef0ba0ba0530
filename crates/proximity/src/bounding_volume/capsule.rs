//! Capsules, or line swept spheres: all points within a radius of a segment (Larsen, Gottschalk, Lin & Manocha 1999).

use clearance_geometry::math::{Extremes, RotationMatrix, Vector};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, Vectors, f32x8};

use super::outline::{Outline, convex_outline};
use super::principal_axes::principal_axes;
use super::relative::Relative;
use super::rounding::{lanes, round, round_up};
use super::volume_trait::BoundingVolume;

/// A segment and a radius around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Ends of the segment (m).
    pub ends: [[f32; 3]; 2],
    /// Radius (m).
    pub radius: f32,
}

/// Eight capsules of one frame.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub struct CapsulePack {
    ends: [[[f32; LANES]; 3]; 2],
    radius: [f32; LANES],
}

/// Eight capsules of a frame, transformed to another frame.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct SeenCapsules {
    ends: [[[f32; LANES]; 3]; 2],
    radius: [f32; LANES],
}

/// Eight capsules, prepared for tests.
#[derive(Clone, Copy, Debug)]
pub struct FacingCapsules<S: Simd> {
    ends: [Vectors<S>; 2],
    radius: f32x8<S>,
}

impl BoundingVolume for Capsule {
    type Pack = CapsulePack;
    type Seen = SeenCapsules;
    type Facing<S: Simd> = FacingCapsules<S>;

    fn axes(_: &[Vector]) -> RotationMatrix {
        RotationMatrix::identity()
    }

    /// The segment is along the direction of largest spread, through the middle across it, and as short as the radius allows.
    fn fit(points: &[Vector]) -> Self {
        let axes = principal_axes(points);
        let local: Vec<Vector> = points.iter().map(|p| axes.tr_mul(p)).collect();
        let middle = |i: usize| {
            let (lo, hi) = (local.iter())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| (lo.lesser(p[i]), hi.greater(p[i])));
            0.5 * (lo + hi)
        };
        let (y, z) = (middle(1), middle(2));
        let off = |p: &Vector| (p.y - y).hypot(p.z - z);
        let radius = local.iter().map(off).fold(0.0, f64::greater);
        let cap = |p: &Vector| (radius * radius - off(p).powi(2)).greater(0.0).sqrt();
        let from = local.iter().map(|p| p.x + cap(p)).fold(f64::INFINITY, f64::lesser);
        let to = local.iter().map(|p| p.x - cap(p)).fold(f64::NEG_INFINITY, f64::greater);
        let (from, to) = if from <= to { (from, to) } else { (0.5 * (from + to), 0.5 * (from + to)) };
        let ends = [from, to].map(|x| {
            let end = axes * Vector::new(x, y, z);
            std::array::from_fn(|i| round(end[i]))
        });
        let [p, q] = ends.map(|end: [f32; 3]| Vector::from(end.map(f64::from)));
        let radius = points.iter().map(|x| distance_from_segment(x, &p, &q)).fold(0.0, f64::greater);
        Self { ends, radius: round_up(radius) }
    }

    fn outline(&self) -> Outline {
        let [p, q] = self.ends.map(|end| Vector::from(end.map(f64::from)));
        let farthest = |direction: &Vector| {
            let end = if (q - p).dot(direction) > 0.0 { q } else { p };
            end + direction * f64::from(self.radius)
        };
        Outline::Triangles(convex_outline(farthest))
    }

    fn pack(volumes: &[Self]) -> CapsulePack {
        CapsulePack {
            ends: std::array::from_fn(|e| std::array::from_fn(|i| lanes(volumes, |v| v.ends[e][i]))),
            radius: lanes(volumes, |v| v.radius),
        }
    }

    #[inline(always)]
    fn splat(&self) -> CapsulePack {
        let end = |[x, y, z]: [f32; 3]| [[x; LANES], [y; LANES], [z; LANES]];
        CapsulePack { ends: [end(self.ends[0]), end(self.ends[1])], radius: [self.radius; LANES] }
    }

    #[inline(always)]
    fn seen<S: Simd>(simd: S, pack: &CapsulePack, relative: &Relative) -> SeenCapsules {
        let [p, q] = [Vectors::load(simd, &pack.ends[0]), Vectors::load(simd, &pack.ends[1])];
        let (r, t) = (&relative.r, &relative.t);
        SeenCapsules { ends: [p.placed(r, t).store(), q.placed(r, t).store()], radius: pack.radius }
    }

    #[inline(always)]
    fn facing<S: Simd>(simd: S, pack: &CapsulePack, _: &Relative) -> FacingCapsules<S> {
        FacingCapsules {
            ends: [Vectors::load(simd, &pack.ends[0]), Vectors::load(simd, &pack.ends[1])],
            radius: f32x8::from_slice(simd, &pack.radius),
        }
    }

    #[inline(always)]
    fn coarse_bounds<S: Simd>(simd: S, seen: &SeenCapsules, other: &Self, _: &Relative) -> f32x8<S> {
        let ends = [Vectors::load(simd, &seen.ends[0]), Vectors::load(simd, &seen.ends[1])];
        let gap = segment_bounds(simd, &other.ends, ends);
        gap - f32x8::from_slice(simd, &seen.radius) - other.radius
    }

    #[inline(always)]
    fn bounds<S: Simd, const SEPARATE: bool>(
        simd: S,
        facing: &FacingCapsules<S>,
        seen: &SeenCapsules,
        lane: usize,
        _: &Relative,
    ) -> f32x8<S> {
        let [p, q] = &seen.ends;
        let ends = [[p[0][lane], p[1][lane], p[2][lane]], [q[0][lane], q[1][lane], q[2][lane]]];
        segment_bounds(simd, &ends, facing.ends) - facing.radius - seen.radius[lane]
    }
}

/// Lower bounds on the distances of one segment to eight others.
///
/// Approximately nearest points are found with clamped parameters (Ericson, *Real-Time Collision Detection*, 5.1.9). Whatever their
/// rounding errors, the gap of the segments along the direction between these points is a lower bound.
#[inline(always)]
fn segment_bounds<S: Simd>(simd: S, one: &[[f32; 3]; 2], eight: [Vectors<S>; 2]) -> f32x8<S> {
    let (zero, unit) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    let tiny = f32x8::splat(simd, f32::MIN_POSITIVE);
    let p = Vectors::splat(simd, &one[0]);
    let d1 = Vectors::splat(simd, &one[1]).minus(p);
    let d2 = eight[1].minus(eight[0]);
    let w = p.minus(eight[0]);
    let (a, e, b) = (d1.dot(d1), d2.dot(d2), d1.dot(d2));
    let (c, f) = (d1.dot(w), d2.dot(w));
    let s = ((b * f - c * e) / (a * e - b * b).max(tiny)).max(zero).min(unit);
    let t = ((b * s + f) / e.max(tiny)).max(zero).min(unit);
    let s = ((b * t - c) / a.max(tiny)).max(zero).min(unit);
    let n = d2.scaled(t).minus(d1.scaled(s)).minus(w);
    let length = n.norm();
    // along n, from p: one segment spans 0 to n·d1, the other n·(q - p) to that plus n·d2
    let gap = (n.dot(d2).min(zero) - n.dot(w)) - n.dot(d1).max(zero);
    length.simd_gt(f32x8::splat(simd, 1e-15)).select(gap / length.max(tiny), zero)
}

fn distance_from_segment(x: &Vector, p: &Vector, q: &Vector) -> f64 {
    let along = q - p;
    let length = along.norm_squared();
    let t = if length > 0.0 { ((x - p).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (x - (p + along * t)).norm()
}
