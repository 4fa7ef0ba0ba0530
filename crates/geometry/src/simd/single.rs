//! A single-precision number, or eight in lanes: one formula for both, with bit-identical results unless one is NaN.

use std::ops::{Add, Div, Mul, Neg, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

/// A number of single precision, or eight of them in lanes.
pub trait Single:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    /// Value needed to create a number: nothing for a scalar, the SIMD level for lanes.
    type Token: Copy;

    /// The same number in every lane.
    fn splat(token: Self::Token, value: f32) -> Self;

    /// Magnitude.
    #[must_use]
    fn abs(self) -> Self;

    /// Square root, correctly rounded.
    #[must_use]
    fn sqrt(self) -> Self;

    /// The larger of two; either of them if one is NaN.
    #[must_use]
    fn greater(self, other: Self) -> Self;

    /// The smaller of two; either of them if one is NaN.
    #[must_use]
    fn lesser(self, other: Self) -> Self;
}

impl Single for f32 {
    type Token = ();

    #[inline(always)]
    fn splat((): (), value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
}

impl<S: Simd> Single for f32x8<S> {
    type Token = S;

    #[inline(always)]
    fn splat(simd: S, value: f32) -> Self {
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
    fn greater(self, other: Self) -> Self {
        SimdBase::max(self, other)
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        SimdBase::min(self, other)
    }
}
