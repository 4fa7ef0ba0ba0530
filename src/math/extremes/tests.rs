use super::Extremes;
use crate::simd::{Level, dispatch};

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

/// The lowest and the highest of each coordinate, as boxes are made.
#[inline(always)]
fn extent<const N: usize>(points: &[[f32; 9]; N]) -> [[f32; 6]; 2] {
    let of = |p: &[f32; 9]| std::array::from_fn(|i| p[i] - (p[i + 3].abs() + p[6] + p[7] + p[8]));
    let first: [f32; 6] = of(&points[0]);
    points[1..].iter().map(of).fold([first; 2], |[lo, hi], next: [f32; 6]| {
        [std::array::from_fn(|i| lo[i].lesser(next[i])), std::array::from_fn(|i| hi[i].greater(next[i]))]
    })
}

fn none_is_forgotten<const N: usize>() {
    for at in 0..N {
        for far in [100.0, -100.0] {
            let mut points = [[1.0; 9]; N];
            points[at] = [far, far, far, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            let [lo, hi] = dispatch!(Level::new(), simd => { let _ = simd; extent(&points) });
            let found = if far > 0.0 { hi } else { lo };
            assert_eq!(found[..3], [far; 3], "number {at} of {N}");
        }
    }
}

#[test]
fn short_loops_forget_none() {
    none_is_forgotten::<3>();
    none_is_forgotten::<5>();
    none_is_forgotten::<6>();
    none_is_forgotten::<7>();
    none_is_forgotten::<8>();
    none_is_forgotten::<11>();
    none_is_forgotten::<13>();
    none_is_forgotten::<15>();
}
