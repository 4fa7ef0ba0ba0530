//! Sum of the angles of many complex numbers with a single arctangent: the angle of their product, and the full turns that the product
//! has made.

use std::f64::consts::TAU;

use crate::math::Extremes;

/// Magnitude below which a number is too small to be scaled.
const LEAST_MAGNITUDE: f64 = 1e-300;

/// Sum of angles in (-π, π], as `im.atan2(re)` gives them.
#[derive(Clone, Copy, Debug)]
pub(super) struct AngleSum {
    /// The product, scaled: only its angle counts.
    re: f64,
    im: f64,
    /// Full turns of the product.
    turns: f64,
    /// Angles of numbers that are too small for the product.
    rest: f64,
}

impl Default for AngleSum {
    fn default() -> Self {
        Self { re: 1.0, im: 0.0, turns: 0.0, rest: 0.0 }
    }
}

impl AngleSum {
    /// Adds the angle of a number, `[re, im]`; that of zero is zero.
    pub fn add(&mut self, [re, im]: [f64; 2]) {
        if re.abs().greater(im.abs()) < LEAST_MAGNITUDE {
            self.rest += im.atan2(re);
            return;
        }
        let product = [self.re * re - self.im * im, self.re * im + self.im * re];
        // the sum of two angles of one sign leaves the half plane of their sign only by a half turn
        let [before, added, after] = [self.im, im, product[1]].map(f64::is_sign_negative);
        if before == added && after != before {
            self.turns += if before { -1.0 } else { 1.0 };
        }
        let scale = 1.0 / product[0].abs().greater(product[1].abs());
        (self.re, self.im) = (product[0] * scale, product[1] * scale);
    }

    /// The sum (rad).
    pub fn value(&self) -> f64 {
        self.im.atan2(self.re) + TAU * self.turns + self.rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;
    use std::f64::consts::PI;

    fn sum(numbers: &[[f64; 2]]) -> [f64; 2] {
        let mut product = AngleSum::default();
        for z in numbers {
            product.add(*z);
        }
        [product.value(), numbers.iter().map(|[re, im]| im.atan2(*re)).sum()]
    }

    #[test]
    fn the_sum_is_that_of_the_arctangents() {
        let mut random = Random::new(11);
        for count in 0..300 {
            let scale = 10.0_f64.powf(random.within(30.0));
            let numbers: Vec<[f64; 2]> = (0..count)
                .map(|_| match random.below(6) {
                    0 => [-scale, random.within(1e-12) * scale],
                    1 => [scale, random.within(1e-12) * scale],
                    2 => [0.0, random.within(1.0)],
                    3 => [random.within(1e-305), random.within(1e-305)],
                    _ => [random.within(scale), random.within(scale)],
                })
                .collect();
            let [found, expected] = sum(&numbers);
            assert!((found - expected).abs() < 1e-12 * f64::from(count + 1), "{found} {expected}");
        }
    }

    /// Angles of 0 and π, with both signs of zero.
    #[test]
    fn half_turns_are_counted() {
        let ends = [[1.0, 0.0], [1.0, -0.0], [-1.0, 0.0], [-1.0, -0.0], [0.0, 1.0], [0.0, -1.0], [0.0, 0.0]];
        for a in ends {
            for b in ends {
                for c in ends {
                    let [found, expected] = sum(&[a, b, c]);
                    assert!((found - expected).abs() < 1e-12, "{a:?} {b:?} {c:?}: {found} {expected}");
                }
            }
        }
        let [found, _] = sum(&[[-1.0, 0.0]; 9]);
        assert!((found - 9.0 * PI).abs() < 1e-12, "{found}");
    }
}
