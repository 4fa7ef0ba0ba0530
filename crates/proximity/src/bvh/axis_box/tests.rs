//! Tests of axis-aligned boxes: a union of any number of boxes contains each of them.

use clearance_geometry::simd::{Level, Simd, dispatch};

use super::AxisBox;

/// A ball that was given as much as boxes of capsules are made of.
type Ball = [f32; 9];

fn box_of([x, y, z, u, v, w, radius, padding, slack]: Ball) -> AxisBox {
    let (p, reach) = ([x, y, z], radius + padding + slack);
    let half = [u, v, w].map(|c| c.abs() + reach);
    AxisBox { lo: std::array::from_fn(|i| p[i] - half[i]), hi: std::array::from_fn(|i| p[i] + half[i]) }
}

#[inline(always)]
fn around_all<S: Simd, const N: usize>(_: S, balls: &[Ball; N]) -> AxisBox {
    balls[1..].iter().fold(box_of(balls[0]), |all, ball| all.union(&box_of(*ball)))
}

/// Why: `math/extremes.rs`.
fn none_of_so_many_is_forgotten<const N: usize>() {
    for at in 0..N {
        for far in [100.0, -100.0] {
            let mut balls = [[1.0; 9]; N];
            balls[at][..3].fill(far);
            let found = dispatch!(Level::new(), simd => around_all(simd, &balls));
            let side = if far > 0.0 { found.hi } else { found.lo };
            assert!(side.iter().all(|c| c.abs() > 100.0), "number {at} of {N}: {found:?}");
        }
    }
}

#[test]
fn short_loops_forget_none() {
    none_of_so_many_is_forgotten::<3>();
    none_of_so_many_is_forgotten::<5>();
    none_of_so_many_is_forgotten::<6>();
    none_of_so_many_is_forgotten::<7>();
    none_of_so_many_is_forgotten::<8>();
    none_of_so_many_is_forgotten::<11>();
    none_of_so_many_is_forgotten::<13>();
    none_of_so_many_is_forgotten::<15>();
}
