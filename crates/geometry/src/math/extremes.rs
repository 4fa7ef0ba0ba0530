//! Minimum and maximum of two floating-point numbers.
//!
//! `f32::min` and similar functions are compiler intrinsics, and LLVM 22 (rustc 1.95) vectorises loops over them incorrectly. If the
//! processor has gather instructions and the number of elements is known, elements that do not fill a vector are lost (boxes around eight
//! capsules were boxes around five). Comparisons are not affected. `clippy.toml` forbids the other functions.

/// Numbers, of which one may be NaN.
pub trait Extremes: Copy {
    /// The smaller of two numbers, or the one that is not NaN.
    #[must_use]
    fn lesser(self, other: Self) -> Self;

    /// The larger of two numbers, or the one that is not NaN.
    #[must_use]
    fn greater(self, other: Self) -> Self;
}

macro_rules! compared {
    ($number:ty) => {
        impl Extremes for $number {
            #[inline(always)]
            fn lesser(self, other: Self) -> Self {
                if self < other || other.is_nan() { self } else { other }
            }

            #[inline(always)]
            fn greater(self, other: Self) -> Self {
                if self > other || other.is_nan() { self } else { other }
            }
        }
    };
}

compared!(f32);
compared!(f64);

#[cfg(test)]
mod tests;
