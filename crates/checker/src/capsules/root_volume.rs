//! Bounding volumes in the root frame, in single precision, with lower bounds on their distances: capsules of robot
//! parts, capsules and boxes of obstacles.
//!
//! # The bounds
//!
//! For two capsules the bound is the one of level 0 ([`super::segment_lanes`]). For a capsule and a box it is similar:
//! in the frame of the box the axis is `w + s·u` with s in [-1, 1]. For *any* direction n, its distance from a box of
//! half extents e is at least the distance along n,
//!
//! > D ≥ (n·w - |n·u| - |n₁|e₁ - |n₂|e₂ - |n₃|e₃) / |n|.
//!
//! The search for n steps from the axis to the box, back to the axis, and to the box again; its last step is n. Axes
//! and their products add four roundings to w and u. But here E and H are the *sums* over both volumes, and E includes
//! C, so that |w| ≤ √3·E. Every term of level 0's table that contains |w| is therefore half as large, and so is the
//! term of C: 64 roundings are more than enough, also where the centre and the half extents of a box are rounded from
//! its corners. Where only a limit matters, squares are compared as at level 0.

use clearance_geometry::math::{MatrixPose, Point};
use clearance_geometry::simd::{LANES, Real, Simd, Single, Vectors, f32x8, low_byte, not_beyond};
use clearance_proximity::PieceVolume;
use clearance_proximity::bvh::{AxisBox, EightBoxes};
use clearance_robot::Reach;

use super::segment::{Segment, round_up};
use super::segment_lanes::{LEAST_SQUARE, PARALLEL, SLACK};

/// Capsule in the root frame: all points within `radius` (m) of a segment. Holds one capsule, or eight in lanes.
#[derive(Clone, Copy, Debug)]
pub struct RootCapsule<V = f32> {
    segment: Segment<V>,
    /// 1 / |half|² (1/m²).
    over_square: V,
    radius: V,
    /// E + H of the bounds (m): the largest coordinate it was computed from, plus the distance from its centre to its
    /// farthest point.
    size: V,
}

/// An oriented box in the root frame; the rows of its matrix are the axes.
#[derive(Clone, Copy, Debug)]
pub struct RootBox<V = f32> {
    centre: [V; 3],
    axes: [[V; 3]; 3],
    half_extents: [V; 3],
    /// Safety distance (m) around the box.
    padding: V,
    /// E + H of the bounds (m), as for a capsule.
    size: V,
}

/// Bounding volume of a piece of an obstacle, in the root frame.
#[derive(Clone, Copy, Debug)]
pub enum RootVolume {
    Capsule(RootCapsule),
    Box(RootBox),
}

impl RootCapsule {
    /// The volume grown by `padding` (m).
    #[must_use]
    pub fn of_reach(reach: &Reach, padding: f64) -> Self {
        let [a, b] = reach.ends;
        let segment = Segment { centre: single((a + b) * 0.5), half: single((b - a) * 0.5) };
        Self::new((), segment, [0.0; 3], round_up(reach.radius + padding), 0.0)
    }

    /// Axis-aligned box around the volume, grown by `by` (m).
    #[inline(always)]
    #[must_use]
    pub fn axis_box(&self, by: f32) -> AxisBox {
        let [lo, hi] = self.corners(by);
        AxisBox { lo, hi }
    }

    /// Lower bounds (m) on the distances to eight boxes; NaN is no bound.
    #[inline(always)]
    #[must_use]
    pub fn bounds_of_boxes<S: Simd>(&self, simd: S, EightBoxes { lo, hi }: &EightBoxes) -> [f32; LANES] {
        let part: RootCapsule<f32x8<S>> = self.splat(simd);
        let (lo, hi) = (load(simd, lo), load(simd, hi));
        let (doubled, edges) = (plus(lo, hi), minus(hi, lo));
        let half = splat(simd, [0.5; 3]);
        let (centre, half_extents) = (times(doubled, half), times(edges, half));
        let w = minus(part.segment.centre, centre);
        let gap = part.axis_gap(w, part.segment.half, half_extents, simd);
        let farthest = |i: usize| lo[i].abs().greater(hi[i].abs());
        let size = farthest(0).greater(farthest(1)).greater(farthest(2))
            + half_extents[0]
            + half_extents[1]
            + half_extents[2];
        (gap.length() - (part.radius + (part.size + size) * SLACK)).into()
    }

    #[inline(always)]
    fn splat<V: Single>(&self, token: V::Token) -> RootCapsule<V> {
        let Segment { centre, half } = self.segment;
        RootCapsule {
            segment: Segment { centre: splat(token, centre), half: splat(token, half) },
            over_square: V::splat(token, self.over_square),
            radius: V::splat(token, self.radius),
            size: V::splat(token, self.size),
        }
    }
}

impl<V: Single> RootCapsule<V> {
    /// Capsule around a segment relative to `origin` (m, root frame), with `radius` (m). `offset` (m) or the
    /// coordinates of its centre are the largest numbers that the centre was computed from.
    #[inline(always)]
    #[must_use]
    pub fn new(token: V::Token, segment: Segment<V>, origin: [V; 3], radius: V, offset: V) -> Self {
        let (Segment { centre: [x, y, z], half }, [p, q, r]) = (segment, origin);
        let extent = (x.abs() + p.abs()).greater(y.abs() + q.abs()).greater(z.abs() + r.abs());
        let reach = half[0].abs() + half[1].abs() + half[2].abs() + radius;
        let least = V::splat(token, LEAST_SQUARE);
        Self {
            segment: Segment { centre: [x + p, y + q, z + r], half },
            over_square: V::splat(token, 1.0) / dot(half, half).greater(least),
            radius,
            size: extent + offset + reach,
        }
    }

    /// Lower and upper corner of an axis-aligned box around the capsule, grown by `by` (m).
    #[inline(always)]
    fn corners(&self, by: f32) -> [[V; 3]; 2] {
        let Segment { centre, half: [u, v, w] } = self.segment;
        let farther = self.radius + by + (self.size + by) * SLACK;
        around(centre, [u.abs() + farther, v.abs() + farther, w.abs() + farther])
    }

    /// Lower bound (m) on the distance to another capsule, negative where they overlap; NaN is no bound.
    #[inline(always)]
    fn bound_of_capsule(&self, other: &Self, token: V::Token) -> V {
        self.shadow_on_capsule(other, token).length() - self.around_axes(other)
    }

    #[inline(always)]
    fn shadow_on_capsule(&self, other: &Self, token: V::Token) -> Shadow<V> {
        let (u, v) = (self.segment.half, other.segment.half);
        let w = minus(other.segment.centre, self.segment.centre);
        let (uu, vv, uv, uw, vw) = (dot(u, u), dot(v, v), dot(u, v), dot(u, w), dot(v, w));
        let least = (uu * vv * PARALLEL).greater(V::splat(token, LEAST_SQUARE));
        let one = V::splat(token, 1.0);
        let s = share((uw * vv - uv * vw) / (uu * vv - uv * uv).greater(least), one);
        let t = share((uv * s - vw) * other.over_square, one);
        let s = share((uv * t + uw) * self.over_square, one);
        let n = minus(along(w, v, t), scaled(u, s));
        Shadow { gap: dot(n, w) - dot(n, u).abs() - dot(n, v).abs(), square: square(n) }
    }

    /// Amount subtracted from the distance between the axes.
    #[inline(always)]
    fn around_axes(&self, other: &Self) -> V {
        self.radius + other.radius + (self.size + other.size) * SLACK
    }

    /// As [`Self::bound_of_capsule`], for a box.
    #[inline(always)]
    fn bound_of_box(&self, to: &RootBox<V>, token: V::Token) -> V {
        self.shadow_on_box(to, token).length() - self.around_box(to)
    }

    #[inline(always)]
    fn shadow_on_box(&self, to: &RootBox<V>, token: V::Token) -> Shadow<V> {
        let w = turned(&to.axes, minus(self.segment.centre, to.centre));
        let u = turned(&to.axes, self.segment.half);
        self.axis_gap(w, u, to.half_extents, token)
    }

    #[inline(always)]
    fn around_box(&self, to: &RootBox<V>) -> V {
        self.radius + to.padding + (self.size + to.size) * SLACK
    }

    /// Separation of the axis `w + s·u` (in the box frame) from a box of the given half extents, along an approximately
    /// nearest line.
    #[inline(always)]
    fn axis_gap(&self, w: [V; 3], u: [V; 3], half_extents: [V; 3], token: V::Token) -> Shadow<V> {
        let one = V::splat(token, 1.0);
        let p = along(w, u, share(-dot(w, u) * self.over_square, one));
        let q = within(half_extents, p);
        let p = along(w, u, share(dot(minus(q, w), u) * self.over_square, one));
        let n = minus(p, within(half_extents, p));
        let shadow = dot([n[0].abs(), n[1].abs(), n[2].abs()], half_extents);
        Shadow { gap: dot(n, w) - dot(n, u).abs() - shadow, square: square(n) }
    }
}

impl<S: Simd> RootCapsule<f32x8<S>> {
    /// Bit mask of the lanes that are not proven farther from a capsule than `limit` (m).
    #[inline(always)]
    fn not_beyond_capsule(&self, other: &Self, limit: f32, simd: S) -> u64 {
        self.shadow_on_capsule(other, simd).not_beyond(self.around_axes(other) + limit, simd)
    }

    /// As above, for a box.
    #[inline(always)]
    fn not_beyond_box(&self, to: &RootBox<f32x8<S>>, limit: f32, simd: S) -> u64 {
        self.shadow_on_box(to, simd).not_beyond(self.around_box(to) + limit, simd)
    }

    /// Axis-aligned boxes around the capsules, each grown by `by` (m).
    #[inline(always)]
    #[must_use]
    pub fn axis_boxes(&self, by: f32) -> EightBoxes {
        let [[x, y, z], [u, v, w]] = self.corners(by);
        EightBoxes { lo: [x.into(), y.into(), z.into()], hi: [u.into(), v.into(), w.into()] }
    }
}

impl RootBox {
    fn axis_box(&self) -> AxisBox {
        let [x, y, z] = self.axes;
        let [a, b, c] = self.half_extents;
        let shadow = |i: usize| x[i].abs() * a + y[i].abs() * b + z[i].abs() * c;
        let farther = self.padding + SLACK * self.size;
        let [lo, hi] = around(self.centre, [shadow(0) + farther, shadow(1) + farther, shadow(2) + farther]);
        AxisBox { lo, hi }
    }

    #[inline(always)]
    fn splat<V: Single>(&self, token: V::Token) -> RootBox<V> {
        let [x, y, z] = self.axes;
        RootBox {
            centre: splat(token, self.centre),
            axes: [splat(token, x), splat(token, y), splat(token, z)],
            half_extents: splat(token, self.half_extents),
            padding: V::splat(token, self.padding),
            size: V::splat(token, self.size),
        }
    }
}

impl RootVolume {
    /// Bounding volume of a piece of a body at its pose in the root frame, grown by `padding` (m).
    #[must_use]
    pub fn of_piece(volume: &PieceVolume, pose: &MatrixPose, padding: f64) -> Self {
        match volume {
            PieceVolume::Capsule { ends, radius } => {
                let reach = Reach { ends: ends.map(|end| (pose * end).coords), radius: *radius };
                Self::Capsule(RootCapsule::of_reach(&reach, padding))
            }
            PieceVolume::Box { centre, axes, half_extents } => {
                let axes = pose.rotation * axes;
                let centre: Point = pose * *centre;
                let reach = half_extents.sum() + padding;
                Self::Box(RootBox {
                    centre: single(centre.coords),
                    axes: [0, 1, 2].map(|k| single(axes.column(k).into())),
                    half_extents: [0, 1, 2].map(|i| round_up(half_extents[i])),
                    padding: round_up(padding),
                    size: round_up(centre.coords.amax() + reach),
                })
            }
        }
    }

    /// Box along the root frame's axes around the volume, padding included.
    #[must_use]
    pub fn axis_box(&self) -> AxisBox {
        match self {
            Self::Capsule(capsule) => capsule.axis_box(0.0),
            Self::Box(of_box) => of_box.axis_box(),
        }
    }

    /// Lower bound (m) on the distance to a robot part, negative where they overlap.
    #[inline(always)]
    #[must_use]
    pub fn lower_bound(&self, part: &RootCapsule) -> f32 {
        let bound = self.bound(part, ());
        // NaN is no bound
        if bound.is_nan() { f32::NEG_INFINITY } else { bound }
    }

    /// Bit mask of the eight lanes that are not proven farther away than `limit` (m).
    #[inline(always)]
    #[must_use]
    pub fn near<S: Simd>(&self, simd: S, eight: &RootCapsule<f32x8<S>>, limit: f32) -> u8 {
        low_byte(match self {
            Self::Capsule(capsule) => eight.not_beyond_capsule(&capsule.splat(simd), limit, simd),
            Self::Box(of_box) => eight.not_beyond_box(&of_box.splat(simd), limit, simd),
        })
    }

    /// As [`Self::lower_bound`], without the handling of NaN.
    #[inline(always)]
    fn bound<V: Single>(&self, part: &RootCapsule<V>, token: V::Token) -> V {
        match self {
            Self::Capsule(capsule) => part.bound_of_capsule(&capsule.splat(token), token),
            Self::Box(of_box) => part.bound_of_box(&of_box.splat(token), token),
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, numbers: &[[f32; LANES]; 3]) -> [f32x8<S>; 3] {
    let Vectors { x, y, z } = Vectors::load(simd, numbers);
    [x, y, z]
}

#[inline(always)]
fn splat<V: Single>(token: V::Token, [x, y, z]: [f32; 3]) -> [V; 3] {
    [V::splat(token, x), V::splat(token, y), V::splat(token, z)]
}

/// A fraction of a half length; `one` is the whole half length.
#[inline(always)]
fn share<V: Single>(of: V, one: V) -> V {
    of.greater(-one).lesser(one)
}

#[inline(always)]
fn dot<V: Single>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn minus<V: Single>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn plus<V: Single>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Component-wise.
#[inline(always)]
fn times<V: Single>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// The point of a box nearest to a given point, both in the frame of the box; the box is given by its half extents.
#[inline(always)]
fn within<V: Single>([a, b, c]: [V; 3], [x, y, z]: [V; 3]) -> [V; 3] {
    [x.greater(-a).lesser(a), y.greater(-b).lesser(b), z.greater(-c).lesser(c)]
}

#[inline(always)]
fn scaled<V: Single>(u: [V; 3], s: V) -> [V; 3] {
    [u[0] * s, u[1] * s, u[2] * s]
}

/// The point at a multiple of a vector from a start point.
#[inline(always)]
fn along<V: Single>(p: [V; 3], u: [V; 3], s: V) -> [V; 3] {
    [p[0] + u[0] * s, p[1] + u[1] * s, p[2] + u[2] * s]
}

/// Transforms a vector into a frame whose axes are the rows.
#[inline(always)]
fn turned<V: Single>(axes: &[[V; 3]; 3], v: [V; 3]) -> [V; 3] {
    [dot(axes[0], v), dot(axes[1], v), dot(axes[2], v)]
}

/// |v|², made larger than zero.
#[inline(always)]
fn square<V: Single>(v: [V; 3]) -> V {
    dot(v, v) + LEAST_SQUARE
}

/// Separation of two volumes along a direction n, times |n|; and |n|².
struct Shadow<V> {
    gap: V,
    square: V,
}

impl<V: Single> Shadow<V> {
    /// The separation (m).
    #[inline(always)]
    fn length(&self) -> V {
        self.gap / self.square.sqrt()
    }
}

impl<S: Simd> Shadow<f32x8<S>> {
    /// Bit mask of the lanes whose separation is not proven larger than `limit` (m, not negative).
    #[inline(always)]
    fn not_beyond(&self, limit: f32x8<S>, simd: S) -> u64 {
        let gap = self.gap.greater(Single::splat(simd, 0.0));
        not_beyond(gap * gap - limit * limit * self.square, 0.0)
    }
}

/// The corners of a box.
#[inline(always)]
fn around<V: Single>([x, y, z]: [V; 3], [u, v, w]: [V; 3]) -> [[V; 3]; 2] {
    [[x - u, y - v, z - w], [x + u, y + v, z + w]]
}

fn single(v: clearance_geometry::math::Vector) -> [f32; 3] {
    [v.x.single(), v.y.single(), v.z.single()]
}

#[cfg(test)]
mod tests;
