//! Outline of a link: few points whose convex hull, enlarged by a radius, contains the link.

use clearance_geometry::math::{MatrixPose, Point, Pose, Vector};
use clearance_geometry::{Primitive, Shape};

/// Number of directions in which outermost points are kept.
const DIRECTIONS: usize = 40;

/// Steps of the search for the point of the hull that is nearest to a vertex.
const STEPS: usize = 24;

/// Points of a body whose convex hull, enlarged by `excess`, contains the body.
#[derive(Clone, Debug)]
pub struct Outline {
    points: Vec<Point>,
    /// Points of the body itself.
    held: Vec<Point>,
    /// Radius (m).
    excess: f64,
    /// All vertices, if there are not too many: their hull is exact.
    vertices: Vec<Point>,
}

/// Largest number of vertices whose exact extent is computed.
const MOST_VERTICES: usize = 1500;

impl Outline {
    /// Outline of shapes at their poses; `None` if a shape is infinite.
    #[must_use]
    pub fn new(shapes: &[(Pose, Shape)]) -> Option<Self> {
        let (mut all, mut of_body) = (Vec::new(), Vec::new());
        for (pose, shape) in shapes {
            all.extend(corners(shape)?.into_iter().map(|p| pose * p));
            of_body.extend(points_of(shape).into_iter().map(|p| pose * p));
        }
        let held = outermost(&of_body);
        let points = outermost(&all);
        let excess = all.iter().map(|p| distance_from_hull(p, &points)).fold(0.0, f64::max);
        // the distances are rounded
        let excess = excess * (1.0 + 1e-9) + 1e-12;
        all.sort_by(|p, q| {
            (p.x, p.y, p.z).partial_cmp(&(q.x, q.y, q.z)).unwrap_or(std::cmp::Ordering::Equal)
        });
        all.dedup();
        let vertices = if all.len() <= MOST_VERTICES { all } else { Vec::new() };
        Some(Self { points, held, excess, vertices })
    }

    /// The same outline with its points at a pose.
    #[must_use]
    pub fn placed(&self, pose: &MatrixPose) -> Self {
        let mut placed =
            Self { points: Vec::new(), held: Vec::new(), excess: self.excess, vertices: Vec::new() };
        self.place(pose, &mut placed);
        placed
    }

    /// As [`Self::placed`], into memory of an earlier outline.
    pub fn place(&self, pose: &MatrixPose, placed: &mut Self) {
        placed.points.clear();
        placed.points.extend(self.points.iter().map(|p| pose * *p));
        placed.held.clear();
        placed.held.extend(self.held.iter().map(|p| pose * *p));
        placed.excess = self.excess;
    }

    /// Upper bound (m) on the distance of any point of the body from an axis.
    #[must_use]
    pub fn reach(&self, origin: &Point, axis: &Vector) -> f64 {
        let squared = self.points.iter().map(|p| axis.cross(&(p - origin)).norm_squared());
        squared.fold(0.0, f64::max).sqrt() + self.excess
    }

    /// The coordinate (m) of a point of the body along a unit vector, and an upper bound for all points.
    #[must_use]
    pub fn extent_along(&self, direction: &Vector) -> [f64; 2] {
        let largest = |points: &[Point]| {
            points.iter().map(|p| direction.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max)
        };
        [largest(&self.held), largest(&self.points) + self.excess]
    }

    /// Upper bound (m) on the coordinate of all points along a unit vector, in the frame that the outline was made in.
    #[must_use]
    pub fn exact_extent(&self, direction: &Vector) -> f64 {
        let farthest = |points: &[Point]| {
            points.iter().map(|p| direction.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max)
        };
        if self.vertices.is_empty() { farthest(&self.points) + self.excess } else { farthest(&self.vertices) }
    }

    /// Upper bound (m) on |v·(x - origin)| over all points x of the body.
    #[must_use]
    pub fn largest_product(&self, v: &Vector, origin: &Point) -> f64 {
        let products = self.points.iter().map(|p| v.dot(&(p - origin)).abs());
        products.fold(0.0, f64::max) + self.excess * v.norm()
    }

    /// The largest coordinate (m) of any point.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max) + self.excess
    }
}

/// The points that are farthest along one of many directions.
fn outermost(all: &[Point]) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    for direction in directions() {
        let farthest =
            all.iter().max_by(|p, q| direction.dot(&p.coords).total_cmp(&direction.dot(&q.coords)));
        points.extend(farthest.filter(|p| !points.contains(p)));
    }
    points
}

/// Outer points of a shape itself: vertices of faces, and of a curved primitive the ends of its axis and points on its equator.
fn points_of(shape: &Shape) -> Vec<Point> {
    let ends = |z: f64| vec![Point::new(0.0, 0.0, z), Point::new(0.0, 0.0, -z)];
    let around = |r: f64| {
        [Point::new(r, 0.0, 0.0), Point::new(-r, 0.0, 0.0), Point::new(0.0, r, 0.0), Point::new(0.0, -r, 0.0)]
    };
    match shape {
        Shape::Mesh(mesh) => {
            mesh.triangles().iter().flatten().map(|v| mesh.vertices()[*v as usize]).collect()
        }
        Shape::Primitive(Primitive::Box { .. }) => corners(shape).unwrap_or_default(),
        Shape::Primitive(Primitive::Sphere { radius }) => [ends(*radius), around(*radius).to_vec()].concat(),
        Shape::Primitive(Primitive::Capsule { radius, half_length }) => {
            [ends(radius + half_length), around(*radius).to_vec()].concat()
        }
        Shape::Primitive(Primitive::Cylinder { radius, half_length }) => {
            [ends(*half_length), around(*radius).to_vec()].concat()
        }
        // half as wide in the middle
        Shape::Primitive(Primitive::Cone { radius, half_length }) => {
            [ends(*half_length), around(0.5 * radius).to_vec()].concat()
        }
        Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => Vec::new(),
    }
}

/// Points around a shape; those of meshes are its vertices.
fn corners(shape: &Shape) -> Option<Vec<Point>> {
    let of_box = |[x, y, z]: [f64; 3]| {
        let sign = |i: usize, bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
        (0..8).map(|i| Point::new(sign(i, 1) * x, sign(i, 2) * y, sign(i, 4) * z)).collect()
    };
    Some(match shape {
        Shape::Mesh(mesh) => mesh.vertices().to_vec(),
        Shape::Primitive(Primitive::Box { half_extents }) => of_box(*half_extents),
        Shape::Primitive(Primitive::Sphere { radius }) => of_box([*radius; 3]),
        Shape::Primitive(Primitive::Capsule { radius, half_length }) => {
            of_box([*radius, *radius, radius + half_length])
        }
        Shape::Primitive(
            Primitive::Cylinder { radius, half_length } | Primitive::Cone { radius, half_length },
        ) => {
            // a regular octagon around the circle
            let (r, z, t) = (*radius, *half_length, radius * (std::f64::consts::PI / 8.0).tan());
            let octagon = [(r, t), (t, r), (-t, r), (-r, t), (-r, -t), (-t, -r), (t, -r), (r, -t)];
            octagon.iter().flat_map(|(x, y)| [Point::new(*x, *y, -z), Point::new(*x, *y, z)]).collect()
        }
        Shape::Plane(_) | Shape::Points(_) | Shape::Voxels(_) => return None,
    })
}

/// Directions spread over the sphere, and the axes.
pub fn directions() -> impl Iterator<Item = Vector> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let spread = (0..DIRECTIONS).map(move |i| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vector::new(r * cos, r * sin, z)
    });
    let axes = [Vector::x(), Vector::y(), Vector::z()];
    axes.into_iter().flat_map(|axis| [axis, -axis]).chain(spread)
}

/// Upper bound (m) on the distance of a point from the convex hull of points (Gilbert 1966): the distance of a point of the hull.
fn distance_from_hull(p: &Point, hull: &[Point]) -> f64 {
    let nearest = |q: &&Point, r: &&Point| (*q - p).norm_squared().total_cmp(&(*r - p).norm_squared());
    let Some(mut x) = hull.iter().min_by(nearest).copied() else { return 0.0 };
    for _ in 0..STEPS {
        let out = p - x;
        let along = |q: &Point| out.dot(&(q - x));
        let Some(best) = hull.iter().max_by(|q, r| along(q).total_cmp(&along(r))) else { break };
        let (step, gain) = (best - x, along(best));
        if gain <= 1e-12 || out.norm_squared() < 1e-16 {
            break;
        }
        x += step * (gain / step.norm_squared()).clamp(0.0, 1.0);
    }
    (p - x).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clearance_geometry::TriangleMesh;
    use std::sync::Arc;

    #[test]
    fn the_outline_bounds_the_reach_of_every_vertex_and_nearly_meets_it() {
        let mut random = fastrand::Rng::with_seed(7);
        for _ in 0..20 {
            let mut number = || random.f64() - 0.5;
            let vertices: Vec<Point> =
                (0..60).map(|_| Point::new(number(), number(), 2.0 * number())).collect();
            let mesh = TriangleMesh::new(vertices.clone(), vec![[0, 1, 2]]).unwrap();
            let outline = Outline::new(&[(Pose::identity(), Shape::Mesh(Arc::new(mesh)))]).unwrap();
            for _ in 0..50 {
                let origin = Point::new(number(), number(), number());
                let axis = Vector::new(number(), number(), number()).normalize();
                let reach = outline.reach(&origin, &axis);
                let exact = vertices.iter().map(|p| axis.cross(&(p - origin)).norm()).fold(0.0, f64::max);
                assert!(exact <= reach && reach <= exact + 0.25, "{exact} {reach}");
            }
        }
    }
}
