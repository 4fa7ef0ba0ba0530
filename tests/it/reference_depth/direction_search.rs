//! Test oracle: penetration depth of two small solid meshes by a dense search over directions.
//!
//! Along one direction the result is exact: each pair of triangles overlaps for an interval of translations, which is the part of a line
//! inside the Minkowski difference of the two, the convex hull of nine points. The solids come apart at the first translation that is in
//! none of these intervals, unless one solid is inside the other there.

use clearance::geometry::math::{Point, Vector};

/// Corners of triangles, wound outward.
pub type Triangles = [[Point; 3]];

/// Directions of the first search.
const DIRECTIONS: u32 = 400;

/// Length (m) of the shortest translation of b that the search finds after which the solids are apart: at least the penetration depth.
pub fn searched_depth(a: &Triangles, b: &Triangles) -> f64 {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let spread = (0..DIRECTIONS).map(|i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(DIRECTIONS);
        let (across, angle) = ((1.0 - z * z).sqrt(), golden_angle * f64::from(i));
        Vector::new(across * angle.cos(), across * angle.sin(), z)
    });
    let normals = a.iter().map(normal).chain(b.iter().map(|t| -normal(t)));
    let mut found: Vec<(f64, Vector)> = normals.chain(spread).map(|n| (length_along(a, b, &n), n)).collect();
    found.sort_by(|p, q| p.0.total_cmp(&q.0));
    found.iter().take(8).map(|(length, n)| refined(a, b, *length, *n)).fold(f64::INFINITY, f64::min)
}

fn normal([a, b, c]: &[Point; 3]) -> Vector {
    (b - a).cross(&(c - a)).normalize()
}

/// Turns a direction in smaller and smaller steps to where the translation is shorter.
fn refined(a: &Triangles, b: &Triangles, length: f64, direction: Vector) -> f64 {
    let (mut best, mut n, mut step) = (length, direction, 0.1);
    while step > 1e-5 {
        let u = n.cross(&Vector::ith(n.iamin(), 1.0)).normalize();
        let turned = [u, -u, n.cross(&u), -n.cross(&u)].map(|aside| (n + aside * step).normalize());
        let tried = turned.map(|n| (length_along(a, b, &n), n));
        let shortest = tried.into_iter().min_by(|p, q| p.0.total_cmp(&q.0)).unwrap();
        if shortest.0 < best { (best, n) = shortest } else { step *= 0.5 }
    }
    best
}

/// The least length of a translation along a unit vector after which the solids are apart.
pub fn length_along(a: &Triangles, b: &Triangles, direction: &Vector) -> f64 {
    let mut blocked: Vec<[f64; 2]> = Vec::new();
    for s in a {
        for t in b {
            blocked.extend(interval(s, t, direction));
        }
    }
    blocked.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let mut length = 0.0;
    for next in blocked.iter().chain([&[f64::INFINITY; 2]]) {
        // somewhere in the gap before the next overlap of surfaces
        let middle = if next[0].is_finite() { 0.5 * (length + next[0]) } else { length + 1.0 };
        if next[0] > length + 1e-9 && !is_one_inside(a, b, &(direction * middle)) {
            return length;
        }
        length = length.max(next[1]);
    }
    length
}

/// Translations along a direction after which two triangles touch.
fn interval(s: &[Point; 3], t: &[Point; 3], direction: &Vector) -> Option<[f64; 2]> {
    let u = direction.cross(&Vector::ith(direction.iamin(), 1.0)).normalize();
    let v = direction.cross(&u);
    let points: Vec<[f64; 3]> = (s.iter())
        .flat_map(|p| t.iter().map(move |q| p - q))
        .map(|d| [d.dot(&u), d.dot(&v), d.dot(direction)])
        .collect();
    let sides = [0, 1].map(|k| {
        let range = points.iter().map(|p| p[k]);
        range.clone().all(|x| x > 0.0) || range.clone().all(|x| x < 0.0)
    });
    if sides.contains(&true) {
        return None;
    }
    let mut found: Option<[f64; 2]> = None;
    for i in 0..points.len() {
        for j in 0..i {
            for k in 0..j {
                let Some(height) = height_over_origin([points[i], points[j], points[k]]) else { continue };
                let [low, high] = found.unwrap_or([height; 2]);
                found = Some([low.min(height), high.max(height)]);
            }
        }
    }
    found
}

/// The third coordinate of a triangle over the origin of the first two.
fn height_over_origin(corners: [[f64; 3]; 3]) -> Option<f64> {
    let cross = |p: [f64; 3], q: [f64; 3]| p[0] * q[1] - p[1] * q[0];
    let [p, q, r] = corners;
    let weights = [cross(q, r), cross(r, p), cross(p, q)];
    let area: f64 = weights.iter().sum();
    let is_inside = weights.iter().all(|w| *w >= 0.0) || weights.iter().all(|w| *w <= 0.0);
    let height = weights.iter().zip(corners).map(|(w, corner)| w * corner[2]).sum::<f64>();
    (is_inside && area.abs() > 1e-15).then_some(height / area)
}

/// Whether a corner of one solid is inside the other, after a translation of b.
fn is_one_inside(a: &Triangles, b: &Triangles, translation: &Vector) -> bool {
    let encloses = |solid: &Triangles, p: Point| {
        let angle: f64 = solid.iter().map(|t| solid_angle(t.map(|c| c - p))).sum();
        angle.abs() > std::f64::consts::TAU
    };
    encloses(a, b[0][0] + translation) || encloses(b, a[0][0] - translation)
}

/// Solid angle of a triangle seen from the origin (Van Oosterom & Strackee 1983).
fn solid_angle([a, b, c]: [Vector; 3]) -> f64 {
    let (x, y, z) = (a.norm(), b.norm(), c.norm());
    let below = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
    2.0 * a.dot(&b.cross(&c)).atan2(below)
}
