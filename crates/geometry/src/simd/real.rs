//! A double-precision number, or eight in lanes: arithmetic with bit-identical results for both.
//!
//! Only operations that IEEE 754 rounds correctly are used, in one written order and never fused, so every
//! instruction set and every lane agrees with the scalar to the last bit.

use std::ops::{Add, Mul, Neg, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{f32x8, f64x8, u64x8};

/// A number, or eight of them in lanes.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// Value needed to create a number: nothing for a scalar, the SIMD level for lanes.
    type Token: Copy;

    /// The corresponding type in single precision.
    type Single: super::Single;

    /// The same number in every lane.
    fn splat(token: Self::Token, value: f64) -> Self;

    /// Magnitude.
    #[must_use]
    fn abs(self) -> Self;

    /// Square root, correctly rounded.
    #[must_use]
    fn sqrt(self) -> Self;

    /// Rounded to nearest.
    fn single(self) -> Self::Single;

    /// Whether every lane lies in `[-limit, limit]`; a NaN does not.
    fn all_within(self, limit: f64) -> bool;

    /// The unit vector `(cos, sin)` rotated by the number of quarter turns in the lowest two mantissa bits of `self`; returned as `(sin,
    /// cos)`.
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self);

    /// `(sin, cos)`, but the standard library's if `self` lies beyond `[-limit, limit]`.
    fn exact_beyond(self, limit: f64, sin: Self, cos: Self) -> (Self, Self);
}

/// The lowest mantissa bit of [`SHIFTER`]` + n` is the lowest bit of the integer n, for |n| < 2⁵¹; adding it rounds to
/// the nearest integer, ties to even, at every level.
const SHIFTER: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52

/// π/2 in three parts (fdlibm's); the first two have 33 bits, so their products with integers below 2²⁰ are exact.
const HALF_PI: [f64; 3] = [f64::from_bits(0x3ff9_21fb_5440_0000), f64::from_bits(0x3dd0_b461_1a60_0000), {
    f64::from_bits(0x3ba3_198a_2e03_7073)
}];

/// Largest argument (rad) reduced here; for larger ones the standard library is used. 2²⁰ quarter turns would be 1.6e6.
const LARGEST_REDUCED: f64 = 1e5;

/// Minimax polynomials on [-π/4, π/4] (fdlibm's `k_sin.c`, `k_cos.c`), highest power first: sin r = r + r³·S(r²),
/// cos r = 1 − r²/2 + r⁴·C(r²), both to 2⁻⁵⁷.
const SIN: [f64; 6] = [
    1.589_690_995_211_55e-10,
    -2.505_076_025_340_686_3e-8,
    2.755_731_370_707_006_8e-6,
    -1.984_126_982_985_795e-4,
    8.333_333_333_322_49e-3,
    -1.666_666_666_666_663_2e-1,
];
const COS: [f64; 6] = [
    -1.135_964_755_778_819_5e-11,
    2.087_572_321_298_175e-9,
    -2.755_731_435_139_066_3e-7,
    2.480_158_728_947_673e-5,
    -1.388_888_888_887_411e-3,
    4.166_666_666_666_66e-2,
];

/// Sine and cosine, within 3e-16 of the true values for every argument.
///
/// For |x| ≤ 1e5 the quarter turn n = round(2x/π) is subtracted in three parts (Cody and Waite): the first difference
/// is exact, the next two round by at most 2⁻⁵⁴ each; polynomial and final sums add at most 1.5·2⁻⁵³.
#[inline(always)]
pub fn sin_cos<T: Real>(x: T) -> (T, T) {
    let shifted = x * std::f64::consts::FRAC_2_PI + SHIFTER;
    let n = shifted - SHIFTER;
    let r = x - n * HALF_PI[0] - n * HALF_PI[1] - n * HALF_PI[2];
    let z = r * r;
    let zz = z * z;
    let sin = r + r * (z * polynomial(z, zz, SIN));
    let cos = zz * polynomial(z, zz, COS) - z * 0.5 + 1.0;
    let (sin, cos) = shifted.quarter_turns(sin, cos);
    if x.all_within(LARGEST_REDUCED) { (sin, cos) } else { x.exact_beyond(LARGEST_REDUCED, sin, cos) }
}

/// A polynomial of z, from z and z²: even and odd powers are computed separately, as two chains of half the length (Estrin 1960).
#[inline(always)]
fn polynomial<T: Real>(z: T, zz: T, c: [f64; 6]) -> T {
    let odd = (zz * c[0] + c[2]) * zz + c[4];
    let even = (zz * c[1] + c[3]) * zz + c[5];
    odd * z + even
}

const SIGN: u32 = 63;

impl Real for f64 {
    type Token = ();
    type Single = f32;

    #[inline(always)]
    fn splat((): (), value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
    fn single(self) -> f32 {
        self as f32
    }

    #[inline(always)]
    fn all_within(self, limit: f64) -> bool {
        f64::abs(self) <= limit
    }

    #[inline(always)]
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let quarters = self.to_bits();
        // no branch: the quarter cannot be predicted
        let swap = (sin.to_bits() ^ cos.to_bits()) & (quarters & 1).wrapping_neg();
        let negative = |quarters: u64| quarters >> 1 << SIGN;
        (
            f64::from_bits(sin.to_bits() ^ swap ^ negative(quarters)),
            f64::from_bits(cos.to_bits() ^ swap ^ negative(quarters + 1)),
        )
    }

    #[cold]
    fn exact_beyond(self, limit: f64, sin: Self, cos: Self) -> (Self, Self) {
        if self.all_within(limit) { (sin, cos) } else { self.sin_cos() }
    }
}

impl<S: Simd> Real for f64x8<S> {
    type Token = S;
    type Single = f32x8<S>;

    #[inline(always)]
    fn splat(simd: S, value: f64) -> Self {
        SimdBase::splat(simd, value)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        SimdBase::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        SimdFloat::sqrt(self)
    }

    #[inline(always)]
    fn single(self) -> f32x8<S> {
        self.narrow(self).split().0
    }

    #[inline(always)]
    fn all_within(self, limit: f64) -> bool {
        SimdBase::abs(self).simd_le(limit).all_true()
    }

    #[inline(always)]
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let quarters: u64x8<S> = self.bitcast();
        let even = (quarters & 1).simd_eq(0);
        (negate(even.select(sin, cos), quarters), negate(even.select(cos, sin), quarters + 1))
    }

    #[inline(always)]
    fn exact_beyond(self, limit: f64, sin: Self, cos: Self) -> (Self, Self) {
        let (sin, cos) = each_beyond(self.into(), limit, sin.into(), cos.into());
        (sin.simd_into(self.simd), cos.simd_into(self.simd))
    }
}

/// `x`, negated where the second lowest bit of `quarters` is set.
#[inline(always)]
fn negate<S: Simd>(x: f64x8<S>, quarters: u64x8<S>) -> f64x8<S> {
    (x.bitcast::<u64x8<S>>() ^ (quarters >> 1 << SIGN)).bitcast()
}

#[cold]
#[inline(never)]
fn each_beyond(x: [f64; 8], limit: f64, mut sin: [f64; 8], mut cos: [f64; 8]) -> ([f64; 8], [f64; 8]) {
    for lane in 0..8 {
        (sin[lane], cos[lane]) = x[lane].exact_beyond(limit, sin[lane], cos[lane]);
    }
    (sin, cos)
}

#[cfg(test)]
#[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
mod tests {
    use super::*;
    use crate::simd::dispatch;
    use crate::testing::{Random, levels};

    /// Test arguments: all magnitudes, and the neighbourhoods of the quarter turns.
    fn arguments(random: &mut Random, count: usize) -> Vec<f64> {
        let mut xs = vec![
            0.0,
            -0.0,
            f64::MIN_POSITIVE,
            f64::from_bits(1),
            -f64::from_bits(0x000f_ffff_ffff_ffff),
            1e-160,
            LARGEST_REDUCED,
            LARGEST_REDUCED.next_up(),
            -LARGEST_REDUCED,
            -LARGEST_REDUCED.next_up(),
            1e22,
            -1e300,
            f64::MAX,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ];
        for _ in 0..count {
            let near = std::f64::consts::FRAC_PI_4 * random.within(2e5).round();
            xs.push(near);
            xs.push(f64::from_bits(near.to_bits().wrapping_add_signed(random.within(9.0).round() as i64)));
            xs.push(random.within(8.0));
            xs.push(random.within(LARGEST_REDUCED));
            xs.push(random.within(1.0) * 10f64.powf(random.within(30.0)));
        }
        xs.resize(xs.len().next_multiple_of(8), 1.0);
        xs
    }

    #[test]
    fn sine_and_cosine_are_true() {
        let mut worst = 0.0_f64;
        for x in arguments(&mut Random::new(1), 1_000_000) {
            let ((sin, cos), (true_sin, true_cos)) = (sin_cos(x), x.sin_cos());
            if x.is_finite() {
                worst = worst.max((sin - true_sin).abs()).max((cos - true_cos).abs());
            } else {
                assert!(sin.is_nan() && cos.is_nan());
            }
        }
        println!("worst absolute error {worst:e}");
        assert!(worst <= 3e-16, "{worst:e}");
    }

    #[test]
    fn small_angles_are_relatively_true() {
        let mut random = Random::new(2);
        for _ in 0..1_000_000 {
            let x = random.within(1.0) * 10f64.powf(-random.within(300.0).abs());
            let sin = sin_cos(x).0;
            assert!((sin - x.sin()).abs() <= 3e-16 * x.sin().abs(), "{x:e}");
        }
    }

    #[inline(always)]
    fn in_lanes<S: Simd>(simd: S, xs: &[f64]) -> Vec<(f64, f64)> {
        let lanes = |eight: &[f64]| sin_cos(f64x8::from_slice(simd, eight));
        (xs.chunks_exact(8).map(lanes)).flat_map(|(s, c)| (0..8).map(move |i| (s[i], c[i]))).collect()
    }

    #[test]
    fn lanes_equal_the_scalar_to_the_bit() {
        let xs = arguments(&mut Random::new(3), 200_000);
        for level in levels() {
            let lanes = dispatch!(level, simd => in_lanes(simd, &xs));
            for (&x, lane) in xs.iter().zip(lanes) {
                let (sin, cos) = sin_cos(x);
                let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
                assert!(same(sin, lane.0) && same(cos, lane.1), "{level:?}: {x:e}");
            }
        }
    }
}
