//! Eight 3D points or directions in SIMD lanes: vector algebra and transforms.

use super::prelude::*;
use super::{LANES, Simd, f32x4, f32x8};

/// Eight points or directions.
#[derive(Clone, Copy, Debug)]
pub struct Vectors<S: Simd> {
    /// First components.
    pub x: f32x8<S>,
    /// Second components.
    pub y: f32x8<S>,
    /// Third components.
    pub z: f32x8<S>,
}

impl<S: Simd> Vectors<S> {
    /// Loads components, ordered by coordinate and lane.
    #[inline(always)]
    pub fn load(simd: S, components: &[[f32; LANES]; 3]) -> Self {
        Self {
            x: f32x8::from_slice(simd, &components[0]),
            y: f32x8::from_slice(simd, &components[1]),
            z: f32x8::from_slice(simd, &components[2]),
        }
    }

    /// The first three numbers of each of eight.
    #[inline(always)]
    pub fn gather(simd: S, of: [&[f32; 4]; LANES]) -> Self {
        let [a, b, c, d, e, f, g, h] = of;
        let (front, back) = (columns(simd, [a, b, c, d]), columns(simd, [e, f, g, h]));
        Self { x: front[0].combine(back[0]), y: front[1].combine(back[1]), z: front[2].combine(back[2]) }
    }

    /// The same vector in all eight lanes.
    #[inline(always)]
    pub fn splat(simd: S, v: &[f32; 3]) -> Self {
        Self { x: f32x8::splat(simd, v[0]), y: f32x8::splat(simd, v[1]), z: f32x8::splat(simd, v[2]) }
    }

    /// Components, ordered by coordinate and lane.
    #[inline(always)]
    #[must_use]
    pub fn store(self) -> [[f32; LANES]; 3] {
        [self.x.into(), self.y.into(), self.z.into()]
    }

    /// `r * self + t`.
    #[inline(always)]
    #[must_use]
    pub fn placed(self, r: &[[f32; 3]; 3], t: &[f32; 3]) -> Self {
        Self { x: self.along(&r[0]) + t[0], y: self.along(&r[1]) + t[1], z: self.along(&r[2]) + t[2] }
    }

    /// The transpose of `r` times `self`.
    #[inline(always)]
    #[must_use]
    pub fn turned_back(self, r: &[[f32; 3]; 3]) -> Self {
        Self {
            x: self.along(&[r[0][0], r[1][0], r[2][0]]),
            y: self.along(&[r[0][1], r[1][1], r[2][1]]),
            z: self.along(&[r[0][2], r[1][2], r[2][2]]),
        }
    }

    /// Dot products with one vector.
    #[inline(always)]
    #[must_use]
    pub fn along(self, v: &[f32; 3]) -> f32x8<S> {
        self.x * v[0] + self.y * v[1] + self.z * v[2]
    }

    /// Dot products, lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn dot(self, other: Self) -> f32x8<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Cross products, lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Products with one number for each lane.
    #[inline(always)]
    #[must_use]
    pub fn scaled(self, by: f32x8<S>) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }

    /// Sums, lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }

    /// Differences, lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn minus(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    /// Magnitudes of the components.
    #[inline(always)]
    #[must_use]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// Smaller components, lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        Self { x: self.x.min(other.x), y: self.y.min(other.y), z: self.z.min(other.z) }
    }

    /// Larger components, lane by lane.
    #[inline(always)]
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    /// The largest component of each.
    #[inline(always)]
    #[must_use]
    pub fn largest(self) -> f32x8<S> {
        self.x.max(self.y).max(self.z)
    }

    /// Sums of the components' magnitudes.
    #[inline(always)]
    #[must_use]
    pub fn one_norm(self) -> f32x8<S> {
        self.x.abs() + self.y.abs() + self.z.abs()
    }

    /// Euclidean lengths.
    #[inline(always)]
    #[must_use]
    pub fn norm(self) -> f32x8<S> {
        self.dot(self).sqrt()
    }

    /// `self` in the lanes where the mask holds, else `other`.
    #[inline(always)]
    #[must_use]
    pub fn or(self, mask: impl Select<f32x8<S>> + Copy, other: Self) -> Self {
        Self {
            x: mask.select(self.x, other.x),
            y: mask.select(self.y, other.y),
            z: mask.select(self.z, other.z),
        }
    }
}

/// The first three columns of four rows.
#[inline(always)]
fn columns<S: Simd>(simd: S, [a, b, c, d]: [&[f32; 4]; 4]) -> [f32x4<S>; 3] {
    let (a, b) = (f32x4::from_slice(simd, a), f32x4::from_slice(simd, b));
    let (c, d) = (f32x4::from_slice(simd, c), f32x4::from_slice(simd, d));
    let (odd, even) = (a.zip_low(c), b.zip_low(d));
    [odd.zip_low(even), odd.zip_high(even), a.zip_high(c).zip_low(b.zip_high(d))]
}
