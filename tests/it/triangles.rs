//! Tests of nearest points and contact of two triangles, against independent methods.

use clearance::geometry::Triangle;
use clearance::geometry::math::{Point, Vector};

use crate::random::Random;

/// Least distance of two triangles by alternating projection between the convex sets, from many starts: an upper bound
/// that converges to the truth (Cheney & Goldstein 1959). The projection is solved by brute force over active sets of
/// the barycentric quadratic program.
fn distance_by_projection(s: &Triangle, t: &Triangle) -> f64 {
    let mut p = s.a;
    let mut least = f64::INFINITY;
    for _ in 0..4000 {
        let q = project(t, &p);
        p = project(s, &q);
        let d = nalgebra::distance(&p, &q);
        if least - d < 1e-15 && least < f64::INFINITY {
            break;
        }
        least = d;
    }
    least
}

/// Nearest point of a triangle by golden-section search in two nested directions: slow, and only convexity is used.
fn project(t: &Triangle, p: &Point) -> Point {
    let at = |u: f64, v: f64| t.a + (t.b - t.a) * (u * (1.0 - v)) + (t.c - t.a) * (u * v);
    let best_v = |u: f64| search(|v| nalgebra::distance_squared(&at(u, v), p));
    let u = search(|u| nalgebra::distance_squared(&at(u, best_v(u)), p));
    at(u, best_v(u))
}

fn search(f: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0f64.sqrt() - 1.0);
    let (mut lo, mut hi) = (0.0, 1.0);
    for _ in 0..60 {
        let (x, y) = (hi - ratio * (hi - lo), lo + ratio * (hi - lo));
        if f(x) < f(y) { hi = y } else { lo = x }
    }
    0.5 * (lo + hi)
}

#[test]
fn nearest_point_agrees_with_a_search() {
    let mut random = Random::new(1);
    for _ in 0..300 {
        let t = random.triangle(1.0);
        let p = random.point(2.0);
        let fast = nalgebra::distance(&p, &t.nearest_point(&p));
        let slow = nalgebra::distance(&p, &project(&t, &p));
        assert!((fast - slow).abs() < 1e-7, "{fast} {slow}");
    }
}

#[test]
fn distance_is_never_above_and_hardly_below_alternating_projection() {
    let mut random = Random::new(2);
    for _ in 0..40 {
        let s = random.triangle(1.0);
        let shift = random.vector(1.0);
        let t = random.triangle(1.0);
        let t = Triangle { a: t.a + shift, b: t.b + shift, c: t.c + shift };
        let [p, q] = s.nearest_points(&t);
        let fast = nalgebra::distance(&p, &q);
        let slow = distance_by_projection(&s, &t);
        assert!(fast <= slow + 1e-9, "{fast} {slow}");
        assert!(fast >= slow - 1e-3, "{fast} {slow}");
        // the plane through the middle, normal to the line between the points, separates: a proof of the distance
        if fast > 1e-6 {
            let n = (q - p) / fast;
            let above = t.corners().map(|c| n.dot(&(c - q))).into_iter().fold(f64::INFINITY, f64::min);
            let below = s.corners().map(|c| n.dot(&(c - p))).into_iter().fold(f64::NEG_INFINITY, f64::max);
            assert!(above > -1e-9 && below < 1e-9, "{above} {below}");
        }
    }
}

#[test]
fn the_separating_plane_proves_every_distance_and_a_common_point_every_contact() {
    let mut random = Random::new(3);
    let (mut apart, mut touching) = (0, 0);
    for _ in 0..50_000 {
        let s = random.triangle(1.0);
        let t = random.triangle(1.0);
        let [p, q] = s.nearest_points(&t);
        let d = nalgebra::distance(&p, &q);
        let contact = s.contact_point(&t);
        assert_eq!(contact.is_some(), d <= 1e-9, "{s:?} {t:?} {d}");
        if let Some(point) = contact {
            touching += 1;
            for triangle in [&s, &t] {
                let off = nalgebra::distance(&point, &triangle.nearest_point(&point));
                assert!(off < 1e-9, "the common point is off by {off}");
            }
        } else {
            apart += 1;
            let n = (q - p) / d;
            for c in t.corners() {
                assert!(n.dot(&(c - q)) > -1e-9);
            }
            for c in s.corners() {
                assert!(n.dot(&(c - p)) < 1e-9);
            }
        }
    }
    assert!(apart > 10_000 && touching > 5_000, "{apart} {touching}");
}

#[test]
fn symmetric_and_invariant_under_rigid_motion() {
    let mut random = Random::new(4);
    for _ in 0..5_000 {
        let (s, t) = (random.triangle(1.0), random.triangle(1.0));
        let pose = random.pose(3.0);
        let d = |s: &Triangle, t: &Triangle| {
            let [p, q] = s.nearest_points(t);
            nalgebra::distance(&p, &q)
        };
        assert!((d(&s, &t) - d(&t, &s)).abs() < 1e-12);
        assert!((d(&s, &t) - d(&s.transformed(&pose), &t.transformed(&pose))).abs() < 1e-10);
    }
}

/// On a small integer grid every answer is definite: crossing and touching can be decided in exact integers.
#[test]
fn grid_triangles_agree_with_exact_integer_arithmetic() {
    let mut random = Random::new(5);
    let mut touching = 0;
    for _ in 0..100_000 {
        let mut corner = || [0; 3].map(|_| i64::from(random.below(4)));
        let (s, t) = ([corner(), corner(), corner()], [corner(), corner(), corner()]);
        let exact = exact::touch(&s, &t);
        let float = |c: [[i64; 3]; 3]| {
            #[allow(clippy::cast_precision_loss)]
            let [a, b, c] = c.map(|p| Point::from(p.map(|x| x as f64)));
            Triangle { a, b, c }
        };
        let found = float(s).contact_point(&float(t)).is_some();
        assert_eq!(found, exact, "{s:?} {t:?}");
        touching += u32::from(exact);
    }
    assert!(touching > 10_000);
}

/// Slivers of aspect 1 : 10⁷ that cross by construction are never missed.
#[test]
fn crossing_slivers_are_found() {
    let mut random = Random::new(6);
    for _ in 0..50_000 {
        let common = random.point(1.0);
        let s = sliver_through(&mut random, common);
        let t = sliver_through(&mut random, common);
        let [p, q] = s.nearest_points(&t);
        assert!(nalgebra::distance(&p, &q) < 1e-9, "{s:?} {t:?}");
        assert!(s.contact_point(&t).is_some(), "{s:?} {t:?}");
    }
}

/// A triangle one long and 1e-7 wide that holds `point`.
fn sliver_through(random: &mut Random, point: Point) -> Triangle {
    let along: Vector = random.vector(1.0).normalize();
    let across = along.cross(&random.vector(1.0)).normalize() * 1e-7;
    let t = random.within(0.1, 0.9);
    let tip = point + along * t;
    let tail = point - along * (1.0 - t);
    Triangle { a: tip, b: tail + across, c: tail - across }
}

/// Two triangles with integer corners touch iff they share a point: decided without rounding. A segment meets a
/// triangle iff the linear program has a solution; for triangles it suffices to test every edge of one against the
/// other, both ways, each by exact orientation signs (coplanar cases in the projection along the largest normal axis).
mod exact {
    type P = [i64; 3];

    pub fn touch(s: &[P; 3], t: &[P; 3]) -> bool {
        let edges = |c: &[P; 3]| [[c[0], c[1]], [c[1], c[2]], [c[2], c[0]]];
        edges(s).iter().any(|e| segment_meets(e, t)) || edges(t).iter().any(|e| segment_meets(e, s))
    }

    fn sub(a: P, b: P) -> P {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
    }

    fn cross(a: P, b: P) -> P {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    }

    fn dot(a: P, b: P) -> i64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    fn segment_meets(e: &[P; 2], t: &[P; 3]) -> bool {
        let n = cross(sub(t[1], t[0]), sub(t[2], t[0]));
        if n == [0; 3] {
            return [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].iter().any(|f| segments_meet(e, f));
        }
        let (hp, hq) = (dot(n, sub(e[0], t[0])), dot(n, sub(e[1], t[0])));
        if hp.signum() * hq.signum() > 0 {
            return false;
        }
        if hp == 0 && hq == 0 {
            let borders = [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
            return inside(e[0], t, n) || borders.iter().any(|f| segments_meet(e, f));
        }
        // the point where the line meets the plane, times the common denominator hp - hq
        let d = hp - hq;
        let point = [0, 1, 2].map(|k| e[0][k] * d + (e[1][k] - e[0][k]) * hp);
        let scaled = t.map(|c| c.map(|x| x * d));
        inside(point, &scaled, n)
    }

    /// Whether a point of the triangle's plane lies in the triangle.
    fn inside(p: P, t: &[P; 3], n: P) -> bool {
        let side = |a: P, b: P| dot(cross(sub(b, a), sub(p, a)), n).signum();
        let s = [side(t[0], t[1]), side(t[1], t[2]), side(t[2], t[0])];
        s.iter().all(|x| *x >= 0) || s.iter().all(|x| *x <= 0)
    }

    fn segments_meet(e: &[P; 2], f: &[P; 2]) -> bool {
        let (d1, d2, r) = (sub(e[1], e[0]), sub(f[1], f[0]), sub(f[0], e[0]));
        let n = cross(d1, d2);
        if n == [0; 3] {
            return on_segment(e[0], f) || on_segment(e[1], f) || on_segment(f[0], e) || on_segment(f[1], e);
        }
        if dot(r, n) != 0 {
            return false;
        }
        let n2 = dot(n, n);
        let (a, b) = (dot(cross(r, d2), n), dot(cross(r, d1), n));
        (0..=n2).contains(&a) && (0..=n2).contains(&b)
    }

    fn on_segment(p: P, e: &[P; 2]) -> bool {
        let (d, r) = (sub(e[1], e[0]), sub(p, e[0]));
        if d == [0; 3] {
            return r == d;
        }
        cross(d, r) == [0; 3] && (0..=dot(d, d)).contains(&dot(d, r))
    }
}
