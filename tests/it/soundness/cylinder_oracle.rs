//! How far a solid cylinder is from a triangle or another cylinder, by nothing but convexity.
//!
//! The distance of a point from a cylinder has a closed form and is convex; over a convex set its least value is found by
//! golden-section searches nested in one another (Kiefer 1953): slow, simple, and without any idea of GJK.

use clearance::math::Point;

/// A cylinder along z around the origin.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder {
    pub radius: f64,
    pub half_length: f64,
}

/// Steps of one search: the bracket shrinks to 1e-11 of its length.
const STEPS: usize = 52;

impl Cylinder {
    pub fn distance_to_point(&self, p: &Point) -> f64 {
        let beside = (p.x.hypot(p.y) - self.radius).max(0.0);
        let above = (p.z.abs() - self.half_length).max(0.0);
        beside.hypot(above)
    }

    /// `corners` in the cylinder's frame.
    pub fn distance_to_triangle(&self, [a, b, c]: &[Point; 3]) -> f64 {
        let at = |u: f64, v: f64| a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v);
        least(0.0, 1.0, |u| least(0.0, 1.0, |v| self.distance_to_point(&at(u, v))))
    }

    /// `into_own_frame` leads from the other cylinder's frame into this one's.
    pub fn distance_to_cylinder(&self, other: &Self, into_own_frame: impl Fn(&Point) -> Point) -> f64 {
        let (r, h) = (other.radius, other.half_length);
        let at = |x: f64, y: f64, z: f64| self.distance_to_point(&into_own_frame(&Point::new(x, y, z)));
        least(-h, h, |z| {
            least(-r, r, |x| {
                let width = ((r - x) * (r + x)).max(0.0).sqrt();
                least(-width, width, |y| at(x, y, z))
            })
        })
    }
}

/// The least value of a convex function that is never negative.
fn least(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0f64.sqrt() - 1.0);
    let (mut lo, mut hi) = (from, to);
    let (mut x, mut y) = (hi - ratio * (hi - lo), lo + ratio * (hi - lo));
    let (mut fx, mut fy) = (f(x), f(y));
    let mut best = f(from).min(f(to)).min(fx).min(fy);
    for _ in 0..STEPS {
        if best == 0.0 {
            break;
        }
        if fx < fy {
            (hi, y, fy) = (y, x, fx);
            x = hi - ratio * (hi - lo);
            fx = f(x);
        } else {
            (lo, x, fx) = (x, y, fy);
            y = lo + ratio * (hi - lo);
            fy = f(y);
        }
        best = best.min(fx).min(fy);
    }
    best
}
