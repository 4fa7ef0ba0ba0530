//! Volumes in the root frame, in single precision: capsules of the robot's parts, capsules and boxes of the world.
//!
//! # The bounds
//!
//! Of two capsules as at level 0 ([`super::capsule_lanes`]). Of a capsule and a box likewise: in the frame of the box the axis is
//! `w + s·u` with s in [-1, 1], and for *any* direction n it is at least as far from a box of half extents e as along n,
//!
//! > D ≥ (n·w - |n·u| - |n₁|e₁ - |n₂|e₂ - |n₃|e₃) / |n|.
//!
//! n is sought by going to and fro between the axis and the box. Axes and their products take four roundings more of w and u. But
//! here E and H are those of both volumes *added*, so that |w| ≤ √3·E and every term of level 0's table that has |w| is half of
//! what it is there: 64 roundings are more than enough.

use super::capsule_lanes::{LEAST_SQUARE, PARALLEL, SLACK};
use super::capsules::{Segment, up};
use crate::bvh::AxisBox;
use crate::math::{Extremes, MatrixPose, Point};
use crate::query::PieceVolume;
use crate::robot::Reach;
use crate::simd::Real;

/// Steps to and fro that come near enough to the nearest points.
const STEPS: usize = 2;

/// All points within `radius` (m) of a segment, in the root frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct RootCapsule {
    segment: Segment<f32>,
    /// 1 / |half|² (1/m²).
    over_square: f32,
    radius: f32,
    /// E + H of the bounds (m): the largest coordinate that it was made from, and how far it reaches from its centre.
    size: f32,
}

/// A box in the root frame; axes are rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct RootBox {
    centre: [f32; 3],
    axes: [[f32; 3]; 3],
    half_extents: [f32; 3],
    /// Safety distance (m) around it.
    padding: f32,
    /// As of a capsule.
    size: f32,
}

/// Where a piece of the world is.
#[derive(Clone, Copy, Debug)]
pub(super) enum RootVolume {
    Capsule(RootCapsule),
    Box(RootBox),
}

impl RootCapsule {
    /// All that is within `padding` (m) of what something reaches.
    #[must_use]
    pub fn of_reach(reach: &Reach, padding: f64) -> Self {
        let [a, b] = reach.ends;
        let segment = Segment { centre: single((a + b) * 0.5), half: single((b - a) * 0.5) };
        Self::new(segment, [0.0; 3], up(reach.radius + padding))
    }

    /// A segment as seen from `origin` (m, root frame), and all within `radius` (m) of it.
    #[inline(always)]
    #[must_use]
    pub fn new(Segment { centre: [x, y, z], half }: Segment<f32>, origin: [f32; 3], radius: f32) -> Self {
        let [p, q, r] = origin;
        let extent = (x.abs() + p.abs()).greater(y.abs() + q.abs()).greater(z.abs() + r.abs());
        let reach = half[0].abs() + half[1].abs() + half[2].abs() + radius;
        let over_square = 1.0 / dot(half, half).greater(LEAST_SQUARE);
        Self {
            segment: Segment { centre: [x + p, y + q, z + r], half },
            over_square,
            radius,
            size: extent + reach,
        }
    }

    /// A box around all that is within `by` (m) of it.
    #[inline(always)]
    #[must_use]
    pub fn axis_box(&self, by: f32) -> AxisBox {
        let Segment { centre, half: [u, v, w] } = self.segment;
        let farther = self.radius + by + SLACK * (self.size + by);
        around(centre, [u.abs() + farther, v.abs() + farther, w.abs() + farther])
    }

    /// A number never larger than the distance (m) from another one, less than zero where they overlap; what is no number bounds
    /// nothing.
    #[inline(always)]
    fn bound_of_capsule(&self, other: &Self) -> f32 {
        let (u, v) = (self.segment.half, other.segment.half);
        let w = minus(other.segment.centre, self.segment.centre);
        let (uu, vv, uv, uw, vw) = (dot(u, u), dot(v, v), dot(u, v), dot(u, w), dot(v, w));
        let determinant = (uu * vv - uv * uv).greater(PARALLEL * uu * vv).greater(LEAST_SQUARE);
        let s = share((uw * vv - uv * vw) / determinant);
        let t = share((uv * s - vw) * other.over_square);
        let s = share((uv * t + uw) * self.over_square);
        let n = minus(along(w, v, t), along([0.0; 3], u, s));
        let gap = dot(n, w) - dot(n, u).abs() - dot(n, v).abs();
        gap / length(n) - (self.radius + other.radius + SLACK * (self.size + other.size))
    }

    /// The same of a box.
    #[inline(always)]
    fn bound_of_box(&self, to: &RootBox) -> f32 {
        let turned = |v: [f32; 3]| to.axes.map(|axis| dot(axis, v));
        let w = turned(minus(self.segment.centre, to.centre));
        let u = turned(self.segment.half);
        let mut p = along(w, u, share(-dot(w, u) * self.over_square));
        for _ in 0..STEPS {
            let q = to.nearest(p);
            p = along(w, u, share(dot(minus(q, w), u) * self.over_square));
        }
        let n = minus(p, to.nearest(p));
        let [x, y, z] = n.map(f32::abs);
        let [a, b, c] = to.half_extents;
        let gap = dot(n, w) - dot(n, u).abs() - (x * a + y * b + z * c);
        gap / length(n) - (self.radius + to.padding + SLACK * (self.size + to.size))
    }
}

impl RootBox {
    /// The point of it, in its frame, nearest to one.
    #[inline(always)]
    fn nearest(&self, p: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = self.half_extents;
        [p[0].greater(-a).lesser(a), p[1].greater(-b).lesser(b), p[2].greater(-c).lesser(c)]
    }

    fn axis_box(&self) -> AxisBox {
        let [x, y, z] = self.axes;
        let [a, b, c] = self.half_extents;
        let shadow = |i: usize| x[i].abs() * a + y[i].abs() * b + z[i].abs() * c;
        let farther = self.padding + SLACK * self.size;
        around(self.centre, [shadow(0) + farther, shadow(1) + farther, shadow(2) + farther])
    }
}

impl RootVolume {
    /// A piece of a body at its pose in the root frame, and all within `padding` (m) of it.
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
                    half_extents: [0, 1, 2].map(|i| up(half_extents[i])),
                    padding: up(padding),
                    size: up(centre.coords.amax() + reach),
                })
            }
        }
    }

    /// A box around it along the root's axes, padding included.
    #[must_use]
    pub fn axis_box(&self) -> AxisBox {
        match self {
            Self::Capsule(capsule) => capsule.axis_box(0.0),
            Self::Box(of_box) => of_box.axis_box(),
        }
    }

    /// A number never larger than the distance (m) of a part, less than zero where they overlap.
    #[inline(always)]
    #[must_use]
    pub fn lower_bound(&self, part: &RootCapsule) -> f32 {
        let bound = match self {
            Self::Capsule(capsule) => part.bound_of_capsule(capsule),
            Self::Box(of_box) => part.bound_of_box(of_box),
        };
        // what is no number bounds nothing
        if bound.is_nan() { f32::NEG_INFINITY } else { bound }
    }
}

/// A share of a half length.
#[inline(always)]
fn share(of: f32) -> f32 {
    of.clamp(-1.0, 1.0)
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// From a point so much along a vector.
#[inline(always)]
fn along(p: [f32; 3], u: [f32; 3], s: f32) -> [f32; 3] {
    [p[0] + u[0] * s, p[1] + u[1] * s, p[2] + u[2] * s]
}

/// Never zero.
#[inline(always)]
fn length(v: [f32; 3]) -> f32 {
    (dot(v, v) + LEAST_SQUARE).sqrt()
}

fn around([x, y, z]: [f32; 3], [u, v, w]: [f32; 3]) -> AxisBox {
    AxisBox { lo: [x - u, y - v, z - w], hi: [x + u, y + v, z + w] }
}

fn single(v: crate::math::Vector) -> [f32; 3] {
    [v.x.single(), v.y.single(), v.z.single()]
}

#[cfg(test)]
mod tests;
