//! Segments of capsules in single precision: of one state, or of eight states in SIMD lanes.

use std::ops::Sub;

use clearance_geometry::simd::{LANES, Real, Simd, Vectors, f32x8};

/// A segment `centre ± half`, in single precision.
#[derive(Clone, Copy, Debug)]
pub struct Segment<V> {
    pub centre: [V; 3],
    pub half: [V; 3],
}

/// A segment `centre ± half` of one state, in single precision: the centre and an unused number, then the half and an
/// unused number.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub struct PlacedSegment(pub(super) [f32; LANES]);

impl PlacedSegment {
    #[inline(always)]
    pub fn centre(&self) -> &[f32; 4] {
        self.0.first_chunk().expect("there are eight")
    }

    #[inline(always)]
    pub fn half(&self) -> &[f32; 4] {
        self.0.last_chunk().expect("there are eight")
    }
}

/// The nearest f32 that is not smaller; infinite for NaN.
pub fn round_up(x: f64) -> f32 {
    let nearest = x.single();
    if f64::from(nearest) >= x {
        nearest
    } else if x.is_nan() {
        f32::INFINITY
    } else {
        nearest.next_up()
    }
}

/// Eight segments of one state, in lanes.
#[inline(always)]
pub fn gather<S: Simd>(simd: S, segments: &[PlacedSegment], of: &[usize; LANES]) -> Segment<f32x8<S>> {
    Segment { centre: centres(simd, segments, of), half: halves(simd, segments, of) }
}

/// The centres of eight segments of one state, in lanes.
#[inline(always)]
pub fn centres<S: Simd>(simd: S, segments: &[PlacedSegment], of: &[usize; LANES]) -> [f32x8<S>; 3] {
    let centre = |lane: usize| segments[of[lane]].centre();
    let [a, b, c, d] = [centre(0), centre(1), centre(2), centre(3)];
    let Vectors { x, y, z } = Vectors::gather(simd, [a, b, c, d, centre(4), centre(5), centre(6), centre(7)]);
    [x, y, z]
}

/// The halves of eight segments of one state, in lanes.
#[inline(always)]
pub fn halves<S: Simd>(simd: S, segments: &[PlacedSegment], of: &[usize; LANES]) -> [f32x8<S>; 3] {
    let half = |lane: usize| segments[of[lane]].half();
    let [a, b, c, d] = [half(0), half(1), half(2), half(3)];
    let Vectors { x, y, z } = Vectors::gather(simd, [a, b, c, d, half(4), half(5), half(6), half(7)]);
    [x, y, z]
}

/// a - b, component by component.
#[inline(always)]
pub fn difference<T: Copy + Sub<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
