//! Rounding to f32, and gathering of one number of each volume into lanes.

use clearance_geometry::simd::LANES;

/// One number of each volume in the lanes; unused lanes repeat the last one.
pub(super) fn lanes<V>(volumes: &[V], number: impl Fn(&V) -> f32) -> [f32; LANES] {
    std::array::from_fn(|lane| number(&volumes[lane.min(volumes.len() - 1)]))
}

/// The least f32 that is not less than `x`.
#[allow(clippy::cast_possible_truncation)] // it is rounded up right after
pub(super) fn round_up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

/// Nearest f32.
#[allow(clippy::cast_possible_truncation)] // rounding is what this does
pub(super) fn round(x: f64) -> f32 {
    x as f32
}
