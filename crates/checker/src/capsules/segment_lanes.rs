//! Lower bounds on the distances of eight pairs of capsules at once, in single precision.
//!
//! # The bound
//!
//! Segments are `c₁ + s·u` and `c₂ + t·v` with s, t in [−1, 1]; let w = c₂ − c₁. For *any* direction n they are at
//! least as far apart as their projections onto n,
//!
//! > D ≥ (n·w − |n·u| − |n·v|) / |n|,
//!
//! with equality when n joins the nearest points. So the nearest points need not be exact (Ericson, *Real-Time
//! Collision Detection*, 5.1.9, without special cases for parallel and degenerate segments): n between approximate ones
//! still gives a bound. Where the bound is loose, as for nearly parallel or touching segments, it is too small, never
//! too large.
//!
//! # Its rounding
//!
//! Let ε = 2⁻²⁴ be the rounding of f32, E the largest coordinate of any centre, H the largest |u| + |v| + radii of any
//! pair, C the largest distance of a centre from the origin of its body. Body poses relative to the first body are
//! computed in f64, the rest in f32. A centre is t + Rc with |t| ≤ E + C in each coordinate; R, c and t are rounded,
//! and so are three products and three sums. Each coordinate of a centre has an error of at most ε(5C + (E + C) + E).
//! With the subtraction, the coordinates of w have an error of at most ε(12C + 6E), and those of u and v at most 5ε|u|
//! and 5ε|v|. For the computed n, whatever its value, and with |w| ≤ 2√3·E:
//!
//! | quantity | error of at most, in ε·\|n\| |
//! |---|---|
//! | w against its true value | √3(12C + 6E) < 21C + 10.4E |
//! | n·w: three roundings | 3\|w\| < 10.4E |
//! | n·u, n·v: three roundings, and u, v themselves | (3 + 5√3)(\|u\| + \|v\|) < 11.7H |
//! | the two differences | 2(\|w\| + \|u\| + \|v\|) < 7E + 2H |
//! | \|n\| and the quotient, or the squares in its stead | 4D ≤ 4\|w\| < 14E |
//! | sums with radii and margin, up to D | 3(D + H) < 10.4E + 3H |
//!
//! The sum is less than 53E + 17H + 21C. Every bound is reduced by 64ε(E + max(H, C)) = 2⁻¹⁸(E + max(H, C)): 4 µm at
//! one metre. The preceding sphere test has fewer terms: 21C + 10.4E for w and 4\|w\| for the squares. A tiny constant
//! added to |n|² keeps the quotient defined where the segments touch, and only lowers a positive bound.

use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{Simd, f32x8, low_byte};

use super::segment::{Segment, difference};

/// Rounding taken off every bound, relative to coordinates and sizes: 64 roundings of f32.
pub const SLACK: f32 = 64.0 / 16_777_216.0;

/// Added to |n|², m².
pub const LEAST_SQUARE: f32 = 1e-30;

/// Segments with a smaller squared sine count as parallel: below this value, f32 does not resolve where they are
/// nearest.
pub const PARALLEL: f32 = 1e-6;

/// Eight pairs of segments.
pub struct Lanes<S: Simd> {
    /// From the centre of the first segment to the centre of the second (m).
    pub w: [f32x8<S>; 3],
    /// Half of the first segment, from its centre to an end (m).
    pub u: [f32x8<S>; 3],
    /// Half of the second segment, from its centre to an end (m).
    pub v: [f32x8<S>; 3],
}

/// Constants of eight pairs, in lanes.
pub struct Constants<S: Simd> {
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

    /// Mask of the lanes whose axes may be no farther apart along n than `radii` plus margin and rounding slack.
    #[inline(always)]
    pub fn near_along(&self, n: [f32x8<S>; 3], radii: f32x8<S>) -> u8 {
        let separation = self.separation(n).max(0.0);
        low_byte(!(separation * separation).simd_gt(radii * radii * square(n)).to_bitmask())
    }

    /// Lower bounds on the distances between the axes, minus `radii`.
    #[inline(always)]
    pub fn lower_bound(&self, radii: f32x8<S>, constants: &Constants<S>) -> f32x8<S> {
        let n = self.direction(constants);
        self.separation(n) / square(n).sqrt() - radii
    }

    /// Vector from the approximately nearest point of the first segment to the nearest point of the second.
    #[inline(always)]
    pub fn direction(&self, c: &Constants<S>) -> [f32x8<S>; 3] {
        let Self { w, u, v } = *self;
        let (uv, uw, vw) = (dot(u, v), dot(u, w), dot(v, w));
        let s = unit_interval((uw * c.vv - uv * vw) / (c.uu * c.vv - uv * uv).max(c.least));
        let t = unit_interval((uv * s - vw) * c.over_vv);
        let s = unit_interval((uv * t + uw) * c.over_uu);
        [w[0] + v[0] * t - u[0] * s, w[1] + v[1] * t - u[1] * s, w[2] + v[2] * t - u[2] * s]
    }

    /// Separation of the segments along n, times |n|.
    #[inline(always)]
    fn separation(&self, n: [f32x8<S>; 3]) -> f32x8<S> {
        dot(n, self.w) - dot(n, self.u).abs() - dot(n, self.v).abs()
    }
}

/// Mask of the lanes whose bounding spheres may be near: `w` joins the centres, `reach` is the sum of radii, margin and
/// rounding slack.
#[inline(always)]
pub fn spheres_near<S: Simd>(w: [f32x8<S>; 3], reach: f32x8<S>) -> u8 {
    // a comparison with NaN is false, which counts as near
    low_byte(!dot(w, w).simd_gt(reach * reach).to_bitmask())
}

#[inline(always)]
fn dot<S: Simd>(a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> f32x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// |n|², made larger than zero.
#[inline(always)]
fn square<S: Simd>(n: [f32x8<S>; 3]) -> f32x8<S> {
    dot(n, n) + LEAST_SQUARE
}

#[inline(always)]
fn unit_interval<S: Simd>(x: f32x8<S>) -> f32x8<S> {
    x.max(-1.0).min(1.0)
}
