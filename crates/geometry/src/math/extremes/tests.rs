//! Test of minimum and maximum with NaN.

use super::Extremes;

#[test]
fn what_is_no_number_is_passed_over() {
    assert_eq!((2.0_f64.lesser(f64::NAN), f64::NAN.lesser(2.0)), (2.0, 2.0));
    assert_eq!((2.0_f32.greater(f32::NAN), f32::NAN.greater(2.0)), (2.0, 2.0));
    assert!(f64::NAN.lesser(f64::NAN).is_nan() && f32::NAN.greater(f32::NAN).is_nan());
    assert_eq!(
        (1.0_f32.lesser(2.0), 1.0_f32.greater(2.0), f64::NEG_INFINITY.greater(-1.0)),
        (1.0, 2.0, -1.0)
    );
}
