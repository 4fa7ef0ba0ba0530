//! Fits a tight capsule around points or shapes.

use clearance_geometry::math::{Extremes, Point, Pose, RotationMatrix, UnitVector, Vector, symmetric_eigen};
use clearance_geometry::{Primitive, Shape};
use nalgebra::Vector2;

use super::link_capsule::LinkCapsule;

/// A capsule around shapes; a single round shape is its own capsule. Shapes with a plane get infinite radius, which
/// level 0 never proves apart. `None` without shapes.
pub fn capsule_around(shapes: &[(Pose, Shape)]) -> Option<LinkCapsule> {
    if let [(pose, Shape::Primitive(primitive))] = shapes {
        match *primitive {
            Primitive::Sphere { radius } => return Some(around_axis(pose, 0.0, radius)),
            Primitive::Capsule { radius, half_length } => {
                return Some(around_axis(pose, half_length, radius));
            }
            _ => {}
        }
    }
    if shapes.iter().any(|(_, shape)| matches!(shape, Shape::Plane(_))) {
        return Some(LinkCapsule { a: Point::origin(), b: Point::origin(), radius: f64::INFINITY });
    }
    let mut points = Vec::new();
    for (pose, shape) in shapes {
        match shape {
            Shape::Mesh(mesh) => {
                points.extend(mesh.triangles().iter().flatten().map(|&v| pose * mesh.vertices()[v as usize]));
            }
            // a capsule around all of them would also do, but takes longer to fit
            Shape::Points(cloud) => points.extend(corners(cloud.bounds()).map(|p| pose * p)),
            Shape::Voxels(voxels) => points.extend(corners(voxels.bounds()).map(|p| pose * p)),
            Shape::Plane(_) => {}
            Shape::Primitive(primitive) => points.extend(primitive.hull_points().map(|p| pose * p)),
        }
    }
    points.sort_by(|p, q| p.iter().map(|c| c.to_bits()).cmp(q.iter().map(|c| c.to_bits())));
    points.dedup();
    fit_capsule(&points)
}

/// Corners of the axis-aligned box between two points.
pub fn corners((low, high): (Point, Point)) -> impl Iterator<Item = Point> {
    let side = move |i: usize, axis: usize| if i & (1 << axis) == 0 { low[axis] } else { high[axis] };
    (0..8).map(move |i| Point::new(side(i, 0), side(i, 1), side(i, 2)))
}

fn around_axis(pose: &Pose, half_length: f64, radius: f64) -> LinkCapsule {
    let end = |z: f64| pose * Point::new(0.0, 0.0, z);
    let rounding = 8.0 * f64::EPSILON * (pose.translation.vector.amax() + half_length + radius);
    LinkCapsule { a: end(-half_length), b: end(half_length), radius: radius + rounding }
}

/// A tight capsule around `points`; `None` if there are none.
///
/// The axis starts as the best of the three principal axes, and is turned as long as the volume shrinks. For each axis
/// the capsule has the smallest circle around the projected points, and the shortest segment whose caps contain all
/// points. At the end the radius is the distance of the farthest point, rounded outward.
#[must_use]
pub fn fit_capsule(points: &[Point]) -> Option<LinkCapsule> {
    let count = u32::try_from(points.len()).ok().filter(|&n| n > 0)?;
    let mean = points.iter().map(|p| p.coords).sum::<Vector>() / f64::from(count);
    let spread: RotationMatrix =
        points.iter().map(|p| (p.coords - mean) * (p.coords - mean).transpose()).sum();
    let axes = symmetric_eigen(&spread).eigenvectors;
    let principal =
        (0..3).map(|i| along(points, mean, &UnitVector::new_normalize(axes.column(i).into_owned())));
    let mut best = principal.min_by(Fit::by_volume)?;
    let mut turn = 0.25_f64;
    while turn > 1e-3 {
        let (x, y) = square_to(&best.axis);
        let turned =
            [x, -x, y, -y].map(|aside| UnitVector::new_normalize(best.axis.into_inner() + aside * turn));
        match turned.iter().map(|axis| along(points, mean, axis)).min_by(Fit::by_volume) {
            Some(better) if better.volume() < best.volume() => best = better,
            _ => turn *= 0.5,
        }
    }
    let farthest = points.iter().map(|p| best.capsule.axis_distance(p)).fold(0.0, f64::greater);
    // distances round by a few units in the last place of the coordinates
    let rounding = 8.0 * f64::EPSILON * points.iter().map(|p| p.coords.amax()).fold(0.0, f64::greater);
    Some(LinkCapsule { radius: farthest + rounding, ..best.capsule })
}

/// A capsule around points, and the direction it was made along.
struct Fit {
    capsule: LinkCapsule,
    axis: UnitVector,
}

impl Fit {
    fn volume(&self) -> f64 {
        let LinkCapsule { a, b, radius } = self.capsule;
        radius * radius * ((b - a).norm() + radius * (4.0 / 3.0))
    }

    fn by_volume(&self, other: &Self) -> std::cmp::Ordering {
        self.volume().total_cmp(&other.volume())
    }
}

/// The smallest capsule around `points` along `axis`.
fn along(points: &[Point], mean: Vector, axis: &UnitVector) -> Fit {
    let (x, y) = square_to(axis);
    let projected = |p: &Point| Vector2::new(x.dot(&(p.coords - mean)), y.dot(&(p.coords - mean)));
    let circle = smallest_circle(&points.iter().map(projected).collect::<Vec<_>>());
    // a cap's centre may lie this far behind a point and still reach it
    let depth = |p: &Point| {
        (circle.radius.powi(2) - (projected(p) - circle.centre).norm_squared()).greater(0.0).sqrt()
    };
    let height = |p: &Point| axis.dot(&(p.coords - mean));
    let low = points.iter().map(|p| height(p) + depth(p)).fold(f64::INFINITY, f64::lesser);
    let high = points.iter().map(|p| height(p) - depth(p)).fold(f64::NEG_INFINITY, f64::greater);
    // where a single ball reaches all, low lies above high
    let (low, high) = if low < high { (low, high) } else { (low.midpoint(high), low.midpoint(high)) };
    let at = |h: f64| Point::from(mean + x * circle.centre.x + y * circle.centre.y + axis.into_inner() * h);
    Fit { capsule: LinkCapsule { a: at(low), b: at(high), radius: circle.radius }, axis: *axis }
}

/// Two directions square to `axis` and to each other.
fn square_to(axis: &UnitVector) -> (Vector, Vector) {
    let x = axis.cross(&Vector::ith(axis.iamin(), 1.0)).normalize();
    (x, axis.cross(&x))
}

#[derive(Clone, Copy, Debug)]
struct Circle {
    centre: Vector2<f64>,
    radius: f64,
}

/// The smallest circle around points. While a point lies outside, the farthest one is added to the two or three points
/// that support the circle. The circle grows in each round, so the search ends.
fn smallest_circle(points: &[Vector2<f64>]) -> Circle {
    let mut support = vec![points[0]];
    let mut circle = Circle { centre: points[0], radius: 0.0 };
    // a few rounds in practice; the limit covers rounding, with which circles could repeat
    for _ in 0..100 {
        let distance = |p: &Vector2<f64>| (p - circle.centre).norm_squared();
        let farthest = points.iter().max_by(|a, b| distance(a).total_cmp(&distance(b)));
        let Some(outside) = farthest.filter(|p| distance(p) > circle.radius.powi(2) * (1.0 + 1e-12)) else {
            break;
        };
        support.push(*outside);
        (circle, support) = smallest_circle_of_few(&support);
    }
    circle
}

/// The smallest circle around at most four points, and the points that support it.
fn smallest_circle_of_few(points: &[Vector2<f64>]) -> (Circle, Vec<Vector2<f64>>) {
    let mut best = (Circle { centre: points[0], radius: f64::INFINITY }, points.to_vec());
    let mut consider = |circle: Circle, support: &[Vector2<f64>]| {
        let all = points.iter().all(|p| (p - circle.centre).norm() <= circle.radius * (1.0 + 1e-12));
        if all && circle.radius < best.0.radius {
            best = (circle, support.to_vec());
        }
    };
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate().skip(i + 1) {
            consider(Circle { centre: (a + b) * 0.5, radius: (a - b).norm() * 0.5 }, &[*a, *b]);
            for c in &points[j + 1..] {
                if let Some(circle) = circle_through(a, b, c) {
                    consider(circle, &[*a, *b, *c]);
                }
            }
        }
    }
    best
}

/// The circle through three points; `None` when they lie on a line.
fn circle_through(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> Option<Circle> {
    let (b, c) = (b - a, c - a);
    let double_area = 2.0 * b.perp(&c);
    let (bb, cc) = (b.norm_squared(), c.norm_squared());
    let centre = Vector2::new(c.y * bb - b.y * cc, b.x * cc - c.x * bb) / double_area;
    let radius = centre.norm();
    radius.is_finite().then_some(Circle { centre: a + centre, radius })
}
