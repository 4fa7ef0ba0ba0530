//! Text of proven bounds: lower bounds are rounded down, upper bounds up, so that the text is proven, too.

/// Part of the last decimal that takes a rounded number safely past the next one.
const STEP: f64 = 0.75;

/// A lower bound with so many decimals, rounded down.
pub fn at_least(lower: f64, decimals: usize) -> String {
    let nearest = decimal(lower, decimals);
    let is_below = nearest.parse().is_ok_and(|shown: f64| shown <= lower);
    if is_below { nearest } else { decimal(lower - STEP * unit(decimals), decimals) }
}

/// An upper bound with so many decimals, rounded up.
pub fn at_most(upper: f64, decimals: usize) -> String {
    let nearest = decimal(upper, decimals);
    let is_above = nearest.parse().is_ok_and(|shown: f64| shown >= upper);
    if is_above { nearest } else { decimal(upper + STEP * unit(decimals), decimals) }
}

/// The nearest decimal number; zero has no sign.
fn decimal(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = |digits: &str| digits.bytes().all(|digit| matches!(digit, b'0' | b'.'));
    match text.strip_prefix('-') {
        Some(digits) if is_zero(digits) => digits.to_owned(),
        _ => text,
    }
}

/// The last decimal.
fn unit(decimals: usize) -> f64 {
    format!("1e-{decimals}").parse().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_rounded_to_the_outside() {
        for (value, lower, upper) in [
            (0.0, "0.000", "0.000"),
            (1.0, "1.000", "1.000"),
            (0.3, "0.300", "0.300"),
            (0.0004, "0.000", "0.001"),
            (0.0006, "0.000", "0.001"),
            (0.0009, "0.000", "0.001"),
            (0.560_546_875, "0.560", "0.561"),
            (0.1235, "0.123", "0.124"),
            (12.345_999, "12.345", "12.346"),
            (-0.0006, "-0.001", "0.000"),
            (f64::INFINITY, "inf", "inf"),
        ] {
            assert_eq!((at_least(value, 3).as_str(), at_most(value, 3).as_str()), (lower, upper), "{value}");
        }
    }

    #[test]
    fn no_text_is_beyond_its_bound() {
        let mut random = fastrand::Rng::with_seed(1);
        for decimals in 0..9 {
            for _ in 0..1000 {
                let value = random.f64() * 10.0_f64.powi(random.i32(-8..4));
                let [low, high] = [at_least(value, decimals), at_most(value, decimals)];
                let [low, high] = [low, high].map(|text| text.parse::<f64>().unwrap());
                assert!(low <= value && value <= high, "{low} to {high}: {value}");
                assert!(high - low < 1.001 * unit(decimals), "{low} to {high}: {value}");
            }
        }
    }
}
