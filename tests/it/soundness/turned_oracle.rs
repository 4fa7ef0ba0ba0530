//! Test oracle: distance of a solid cylinder or cone from a triangle or another such solid, by golden-section search.
//!
//! The distance of a point from one has a closed form and is convex; over a convex set its least value is found by
//! golden-section searches nested in one another (Kiefer 1953): slow, simple, and without any idea of GJK.

use clearance::geometry::math::{Point, Vector};

use super::triangle_oracle::Nearest;

/// What a straight edge makes that turns about z: its radii at the lower end and the upper.
#[derive(Clone, Copy, Debug)]
pub struct Turned {
    pub foot: f64,
    pub top: f64,
    pub half_length: f64,
}

/// Steps of one search: the bracket shrinks to 1e-11 of its length.
const STEPS: usize = 52;

impl Turned {
    fn radius(&self, z: f64) -> f64 {
        if self.half_length == 0.0 {
            return self.foot.max(self.top);
        }
        let share = (0.5 * (z / self.half_length + 1.0)).clamp(0.0, 1.0);
        // a cylinder's is exact
        self.foot + (self.top - self.foot) * share
    }

    fn nearest_point(&self, p: &Point) -> Point {
        let across = (p.x * p.x + p.y * p.y).sqrt();
        let [r, z] = self.nearest_in_section([across, p.z]);
        let (x, y) = if across > 0.0 { (p.x / across, p.y / across) } else { (1.0, 0.0) };
        Point::new(r * x, r * y, z)
    }

    fn distance(&self, p: &Point) -> f64 {
        let section = [(p.x * p.x + p.y * p.y).sqrt(), p.z];
        let nearest = self.nearest_in_section(section);
        length(minus(section, nearest))
    }

    /// In the half plane through the axis: inside, or on the disc below, the disc above or the edge.
    fn nearest_in_section(&self, p: [f64; 2]) -> [f64; 2] {
        let h = self.half_length;
        if p[1].abs() <= h && p[0] <= self.radius(p[1]) {
            return p;
        }
        let corners = [[0.0, -h], [self.foot, -h], [self.top, h], [0.0, h]];
        let sides = (0..3).map(|i| nearest_on_side(p, corners[i], corners[i + 1]));
        let nearer = |x: &[f64; 2], y: &[f64; 2]| length(minus(*x, p)).total_cmp(&length(minus(*y, p)));
        sides.min_by(nearer).expect("three sides")
    }

    /// `corners` and the answer in its own frame.
    pub fn nearest_of_triangle(&self, [a, b, c]: &[Point; 3]) -> Nearest {
        let at = |u: f64, v: f64| a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v);
        self.rounded(least(0.0, 1.0, |u| {
            least(0.0, 1.0, |v| {
                let p = at(u, v);
                (self.distance(&p), p)
            })
        }))
    }

    /// `into_own_frame` leads from the other's frame into this one's, in which the answer is.
    pub fn nearest_of_turned(&self, other: &Self, into_own_frame: impl Fn(&Point) -> Point) -> Nearest {
        let h = other.half_length;
        self.rounded(least(-h, h, |z| {
            let r = other.radius(z);
            least(-r, r, |x| {
                let width = ((r - x) * (r + x)).max(0.0).sqrt();
                least(-width, width, |y| {
                    let p = into_own_frame(&Point::new(x, y, z));
                    (self.distance(&p), p)
                })
            })
        }))
    }

    fn rounded(&self, (distance, p): (f64, Point)) -> Nearest {
        let direction: Vector = p - self.nearest_point(&p);
        Nearest { squared: distance * distance, direction }
    }
}

fn minus(p: [f64; 2], q: [f64; 2]) -> [f64; 2] {
    [p[0] - q[0], p[1] - q[1]]
}

fn length(v: [f64; 2]) -> f64 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}

fn nearest_on_side(p: [f64; 2], from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let (along, offset) = (minus(to, from), minus(p, from));
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { (along[0] * offset[0] + along[1] * offset[1]) / squared } else { 0.0 };
    match share {
        share if share <= 0.0 => from,
        share if share >= 1.0 => to,
        share => [from[0] + along[0] * share, from[1] + along[1] * share],
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
