//! Eight pairs of capsules at once, in single precision: what proves them apart.
//!
//! # The bound
//!
//! Segments are `c₁ + s·u` and `c₂ + t·v` with s, t in [−1, 1]; let w = c₂ − c₁. For *any* direction n they are at
//! least as far apart as their projections onto n,
//!
//! > D ≥ (n·w − |n·u| − |n·v|) / |n|,
//!
//! with equality when n joins the nearest points. So nearest points are sought carelessly (Ericson, *Real-Time
//! Collision Detection*, 5.1.9, with parallel and degenerate segments not set apart), and n between them still gives a
//! bound. Where it is loose, as for nearly parallel or touching segments, it is loose downward.
//!
//! # Its rounding
//!
//! Let ε = 2⁻²⁴ be the rounding of f32, E the largest coordinate of any centre, H the largest |u| + |v| + radii of any
//! pair, C the largest distance of a centre from the origin of its body. Where bodies are relative to the first is found in
//! f64, the rest in f32: a centre is t + Rc with |t| ≤ E + C in each coordinate, where R, c and t are rounded and three products
//! and three sums are. Each coordinate of it is off by at most ε(5C + (E + C) + E), so with the subtraction those of w by
//! ε(12C + 6E), and each of u and v by 5ε|u| and 5ε|v|. For the n that was computed, whatever it is, and with |w| ≤ 2√3·E:
//!
//! | what | off by at most, in ε·\|n\| |
//! |---|---|
//! | w for its true value | √3(12C + 6E) < 21C + 10.4E |
//! | n·w: three roundings | 3\|w\| < 10.4E |
//! | n·u, n·v: three roundings, and u, v themselves | (3 + 5√3)(\|u\| + \|v\|) < 11.7H |
//! | the two differences | 2(\|w\| + \|u\| + \|v\|) < 7E + 2H |
//! | \|n\| and the quotient, or the squares in its stead | 4D ≤ 4\|w\| < 14E |
//! | sums with radii and margin, up to D | 3(D + H) < 10.4E + 3H |
//!
//! Together less than 53E + 17H + 21C; 64ε(E + max(H, C)) = 2⁻¹⁸(E + max(H, C)) is taken off every bound: 4 µm at a metre. The
//! sphere test before has fewer terms: 21C + 10.4E for w and 4\|w\| for the squares. A tiny constant added to |n|² keeps the quotient
//! defined where the segments touch, and only lowers a positive bound.

use std::ops::Sub;

use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{Simd, f32x8, low_byte};

use super::capsules::Segment;

/// Rounding taken off every bound, relative to coordinates and sizes: 64 roundings of f32.
pub(super) const SLACK: f32 = 64.0 / 16_777_216.0;

/// Added to |n|², m².
pub(super) const LEAST_SQUARE: f32 = 1e-30;

/// Segments whose squared sine is less count as parallel: below, f32 tells nothing about where they are nearest.
pub(super) const PARALLEL: f32 = 1e-6;

/// Eight pairs of segments.
pub(super) struct Lanes<S: Simd> {
    /// From the first centre to the second (m).
    pub w: [f32x8<S>; 3],
    /// Half of the first.
    pub u: [f32x8<S>; 3],
    /// Half of the second.
    pub v: [f32x8<S>; 3],
}

/// Eight pairs' constants, in lanes.
pub(super) struct Constants<S: Simd> {
    pub uu: f32x8<S>,
    pub vv: f32x8<S>,
    pub over_uu: f32x8<S>,
    pub over_vv: f32x8<S>,
    pub least: f32x8<S>,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    pub fn of_eight_states(a: &Segment<f32x8<S>>, b: &Segment<f32x8<S>>) -> Self {
        Self { w: difference(b.centre, a.centre), u: a.half, v: b.half }
    }

    /// In which lanes the axes may be no farther apart along n than `radii`, with margin and slack.
    #[inline(always)]
    pub fn near_along(&self, n: [f32x8<S>; 3], radii: f32x8<S>) -> u8 {
        let separation = self.separation(n).max(0.0);
        low_byte(!(separation * separation).simd_gt(radii * radii * square(n)).to_bitmask())
    }

    /// Lower bounds of the distance of the axes, less `radii`.
    #[inline(always)]
    pub fn lower_bound(&self, radii: f32x8<S>, constants: &Constants<S>) -> f32x8<S> {
        let n = self.direction(constants);
        self.separation(n) / square(n).sqrt() - radii
    }

    /// From about where the first segment is nearest to the second, to there.
    #[inline(always)]
    pub fn direction(&self, c: &Constants<S>) -> [f32x8<S>; 3] {
        let Self { w, u, v } = *self;
        let (uv, uw, vw) = (dot(u, v), dot(u, w), dot(v, w));
        let s = unit_interval((uw * c.vv - uv * vw) / (c.uu * c.vv - uv * uv).max(c.least));
        let t = unit_interval((uv * s - vw) * c.over_vv);
        let s = unit_interval((uv * t + uw) * c.over_uu);
        [w[0] + v[0] * t - u[0] * s, w[1] + v[1] * t - u[1] * s, w[2] + v[2] * t - u[2] * s]
    }

    /// How far apart the segments are along n, times |n|.
    #[inline(always)]
    fn separation(&self, n: [f32x8<S>; 3]) -> f32x8<S> {
        dot(n, self.w) - dot(n, self.u).abs() - dot(n, self.v).abs()
    }
}

/// In which lanes spheres around segments may be near: `w` is between the centres, `reach` the sum of radii, margin and slack.
#[inline(always)]
pub(super) fn spheres_near<S: Simd>(w: [f32x8<S>; 3], reach: f32x8<S>) -> u8 {
    // what compares false for want of a number is near
    low_byte(!dot(w, w).simd_gt(reach * reach).to_bitmask())
}

#[inline(always)]
pub(super) fn difference<T: Copy + Sub<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> f32x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// |n|², never zero.
#[inline(always)]
fn square<S: Simd>(n: [f32x8<S>; 3]) -> f32x8<S> {
    dot(n, n) + LEAST_SQUARE
}

#[inline(always)]
fn unit_interval<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    x.max(-1.0).min(1.0)
}
