//! SIMD arithmetic with eight lanes, and dispatch by instruction set; the only module that uses the SIMD crate.
//!
//! The instruction set is selected at run time ([`Level::new`]). Every level gives bit-identical results: no operation here fuses,
//! reorders or approximates. Code that is generic over [`Simd`] must be inlined into the dispatched function to be compiled for its
//! level. Closures and `array::map` are not always inlined, hence plain functions and written-out components.

mod real;
mod single;
mod vectors;

#[doc(hidden)]
pub use fearless_simd;
pub use fearless_simd::{Level, Simd, f32x4, f32x8, f64x4, f64x8, mask32x8};
pub use real::{Real, sin_cos};
pub use single::Single;
pub use vectors::Vectors;

use prelude::*;

/// Traits with the methods of vectors and masks.
pub mod prelude {
    pub use fearless_simd::{
        Select, SimdBase, SimdCombine, SimdFloat, SimdFrom, SimdInto, SimdMask, SimdNarrow, SimdSplit,
    };
}

/// Number of lanes in a vector.
pub const LANES: usize = 8;

/// The baseline level, which every machine of this architecture supports.
#[must_use]
#[inline]
pub fn baseline() -> Level {
    Level::baseline()
}

/// Evaluates an expression that is compiled for AVX2 and for the baseline, at the level of this machine. AVX-512 gains little for vectors
/// of eight f32, slows the scalar code between them, and its compilers have errors (`math/extremes.rs`).
///
/// With `baseline` in place of a level it is compiled for the baseline only: for code that is large, and whose time is spent elsewhere.
#[macro_export]
macro_rules! dispatch {
    (baseline, $simd:ident => $body:expr) => {{
        let level = $crate::simd::baseline();
        #[cfg(target_arch = "x86_64")]
        {
            let $simd = level.as_sse2().expect("every x86-64 has SSE2");
            $crate::simd::Simd::vectorize($simd, #[inline(always)] || $body)
        }
        #[cfg(not(target_arch = "x86_64"))]
        $crate::simd::fearless_simd::dispatch!(level, $simd => $body)
    }};
    ($level:expr, $simd:ident => $body:expr) => {{
        #[cfg(target_arch = "x86_64")]
        {
            match $level.as_avx2() {
                Some($simd) => $crate::simd::Simd::vectorize($simd, #[inline(always)] || $body),
                None => {
                    let $simd = $level.as_sse2().expect("every x86-64 has SSE2");
                    $crate::simd::Simd::vectorize($simd, #[inline(always)] || $body)
                }
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        $crate::simd::fearless_simd::dispatch!($level, $simd => $body)
    }};
}

pub use crate::dispatch;

/// Bit mask of the lanes that are not proven to lie beyond `limit`; NaN proves nothing.
#[inline(always)]
pub fn not_beyond<S: Simd>(bounds: f32x8<S>, limit: f32) -> u64 {
    !bounds.simd_gt(limit).to_bitmask()
}

/// The first eight bits.
#[inline(always)]
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "the other bits are meant to go")]
pub fn low_byte(bits: u64) -> u8 {
    bits as u8
}
