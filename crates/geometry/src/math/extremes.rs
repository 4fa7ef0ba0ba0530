//! The lesser and the greater of two numbers.
//!
//! `f32::min` and its kin are the compiler's own, and LLVM 22 (rustc 1.95) makes loops of them into vectors as it should not: where
//! the processor can gather numbers, and it is known how many there are, it forgets those that do not fill a vector (boxes around
//! eight capsules were boxes around five). Comparisons are left as they are. `clippy.toml` refuses the others.

/// Numbers of which one may be no number.
pub trait Extremes: Copy {
    /// The lesser of two, or the one that is a number.
    #[must_use]
    fn lesser(self, other: Self) -> Self;

    /// The greater of two, or the one that is a number.
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
