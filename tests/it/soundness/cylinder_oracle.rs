//! How far a solid cylinder is from a triangle or another cylinder, by nothing but convexity.
//!
//! The distance of a point from a cylinder has a closed form and is convex; over a convex set its least value is found by
//! golden-section searches nested in one another (Kiefer 1953): slow, simple, and without any idea of GJK.

use clearance::math::{Point, Vector};

use super::triangle_oracle::Nearest;

/// A cylinder along z around the origin.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder {
    pub radius: f64,
    pub half_length: f64,
}

/// Steps of one search: the bracket shrinks to 1e-11 of its length.
const STEPS: usize = 52;

impl Cylinder {
    fn nearest_point(&self, p: &Point) -> Point {
        let across = p.x.hypot(p.y);
        let scale = if across > self.radius { self.radius / across } else { 1.0 };
        Point::new(p.x * scale, p.y * scale, p.z.clamp(-self.half_length, self.half_length))
    }

    fn distance(&self, p: &Point) -> f64 {
        let beside = ((p.x * p.x + p.y * p.y).sqrt() - self.radius).max(0.0);
        let above = (p.z.abs() - self.half_length).max(0.0);
        (beside * beside + above * above).sqrt()
    }

    /// `corners` and the answer in the cylinder's frame.
    pub fn nearest_of_triangle(&self, [a, b, c]: &[Point; 3]) -> Nearest {
        let at = |u: f64, v: f64| a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v);
        self.told(least(0.0, 1.0, |u| {
            least(0.0, 1.0, |v| {
                let p = at(u, v);
                (self.distance(&p), p)
            })
        }))
    }

    /// `into_own_frame` leads from the other cylinder's frame into this one's, in which the answer is.
    pub fn nearest_of_cylinder(&self, other: &Self, into_own_frame: impl Fn(&Point) -> Point) -> Nearest {
        let (r, h) = (other.radius, other.half_length);
        self.told(least(-h, h, |z| {
            least(-r, r, |x| {
                let width = ((r - x) * (r + x)).max(0.0).sqrt();
                least(-width, width, |y| {
                    let p = into_own_frame(&Point::new(x, y, z));
                    (self.distance(&p), p)
                })
            })
        }))
    }

    fn told(&self, (distance, p): (f64, Point)) -> Nearest {
        let direction: Vector = p - self.nearest_point(&p);
        Nearest { squared: distance * distance, direction }
    }
}

/// The least value of a convex function that is never negative, and where it is found.
fn least(from: f64, to: f64, f: impl Fn(f64) -> (f64, Point)) -> (f64, Point) {
    let ratio = 0.5 * (5.0f64.sqrt() - 1.0);
    let (mut lo, mut hi) = (from, to);
    let (mut x, mut y) = (hi - ratio * (hi - lo), lo + ratio * (hi - lo));
    let (mut fx, mut fy) = (f(x), f(y));
    let better = |p: (f64, Point), q: (f64, Point)| if q.0 < p.0 { q } else { p };
    let mut best = [f(to), fx, fy].into_iter().fold(f(from), better);
    for _ in 0..STEPS {
        if best.0 == 0.0 {
            break;
        }
        if fx.0 < fy.0 {
            (hi, y, fy) = (y, x, fx);
            x = hi - ratio * (hi - lo);
            fx = f(x);
            best = better(best, fx);
        } else {
            (lo, x, fx) = (x, y, fy);
            y = lo + ratio * (hi - lo);
            fy = f(y);
            best = better(best, fy);
        }
    }
    best
}
