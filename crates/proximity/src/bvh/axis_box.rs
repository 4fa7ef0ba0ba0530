//! Axis-aligned boxes of one common frame, in f32: single boxes, and eight in SIMD lanes.

use clearance_geometry::math::{Extremes, Point};
use clearance_geometry::simd::prelude::*;
use clearance_geometry::simd::{LANES, Simd, f32x8, mask32x8};

/// A box along the axes (m), rounded outward. If its lower corner is above the upper one, it is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisBox {
    /// Lower corner (m).
    pub lo: [f32; 3],
    /// Upper corner (m).
    pub hi: [f32; 3],
}

impl AxisBox {
    /// The box without points.
    pub const EMPTY: Self = Self { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };

    /// The unbounded box.
    pub const ALL: Self = Self { lo: [f32::NEG_INFINITY; 3], hi: [f32::INFINITY; 3] };

    /// The box around points, enlarged by `radius` (m). NaN makes it unbounded.
    #[must_use]
    #[inline]
    pub fn around(points: impl IntoIterator<Item = Point>, radius: f64) -> Self {
        let mut found = Self::EMPTY;
        for p in points {
            for i in 0..3 {
                found.lo[i] = found.lo[i].lesser(down(p[i] - radius));
                found.hi[i] = found.hi[i].greater(-down(-p[i] - radius));
            }
        }
        found
    }

    /// True if all coordinates are finite.
    #[must_use]
    #[inline]
    pub fn is_bounded(&self) -> bool {
        self.lo.iter().chain(&self.hi).all(|c| c.is_finite())
    }

    /// The smallest box around both.
    #[must_use]
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            lo: std::array::from_fn(|i| self.lo[i].lesser(other.lo[i])),
            hi: std::array::from_fn(|i| self.hi[i].greater(other.hi[i])),
        }
    }

    /// The box enlarged by `by` (m, not negative) on all sides.
    #[must_use]
    #[inline]
    pub fn grown(&self, by: f64) -> Self {
        Self { lo: self.lo.map(|c| down(f64::from(c) - by)), hi: self.hi.map(|c| -down(-f64::from(c) - by)) }
    }

    /// The sum of its edges (m).
    #[must_use]
    #[inline]
    pub fn girth(&self) -> f32 {
        (0..3).map(|i| self.hi[i] - self.lo[i]).sum()
    }

    /// Twice its centre.
    #[must_use]
    #[inline]
    pub fn doubled_centre(&self) -> [f32; 3] {
        std::array::from_fn(|i| self.lo[i] + self.hi[i])
    }
}

/// Eight boxes, by coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct EightBoxes {
    /// Lower corners (m), by coordinate and lane.
    pub lo: [[f32; LANES]; 3],
    /// Upper corners (m), by coordinate and lane.
    pub hi: [[f32; LANES]; 3],
}

impl EightBoxes {
    /// Eight boxes without points.
    pub const EMPTY: Self = Self { lo: [[f32::INFINITY; LANES]; 3], hi: [[f32::NEG_INFINITY; LANES]; 3] };

    /// The box in a lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, lane: usize) -> AxisBox {
        let [x, y, z] = &self.lo;
        let [u, v, w] = &self.hi;
        AxisBox { lo: [x[lane], y[lane], z[lane]], hi: [u[lane], v[lane], w[lane]] }
    }

    /// Replaces the box in a lane.
    #[inline]
    pub fn set(&mut self, lane: usize, bounds: &AxisBox) {
        for i in 0..3 {
            (self.lo[i][lane], self.hi[i][lane]) = (bounds.lo[i], bounds.hi[i]);
        }
    }

    /// The smallest box around all.
    #[must_use]
    #[inline]
    pub fn union(&self) -> AxisBox {
        (0..LANES).fold(AxisBox::EMPTY, |all, lane| all.union(&self.lane(lane)))
    }

    /// Mask of the lanes whose boxes lie beyond a box along one axis.
    #[inline(always)]
    pub(super) fn beyond<S: Simd>(&self, simd: S, i: usize, from: &AxisBox) -> mask32x8<S> {
        let Self { lo, hi } = self;
        let (lo, hi) = (f32x8::from_slice(simd, &lo[i]), f32x8::from_slice(simd, &hi[i]));
        lo.simd_gt(from.hi[i]) | hi.simd_lt(from.lo[i])
    }
}

/// The nearest f32 that is not larger; negative infinity for NaN.
#[allow(clippy::cast_possible_truncation)] // rounded down right after
fn down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) <= x {
        nearest
    } else if x.is_nan() {
        f32::NEG_INFINITY
    } else {
        nearest.next_down()
    }
}

#[cfg(test)]
mod tests;
