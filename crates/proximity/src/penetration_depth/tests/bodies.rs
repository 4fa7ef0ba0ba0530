//! Test helper: bodies for the tests of penetration depths.

use std::sync::Arc;

use clearance_geometry::math::{Point, Pose};
use clearance_geometry::{Primitive, Shape, TriangleMesh};

use crate::CollisionBody;
use crate::penetration_depth::SolidBody;

/// A body for depths, and the same for other queries.
pub struct Body {
    pub solid: SolidBody,
    pub whole: CollisionBody,
    pub shapes: Vec<(Pose, Shape)>,
}

impl Body {
    pub fn new(shapes: Vec<(Pose, Shape)>) -> Self {
        let list = || shapes.iter().map(|(pose, shape)| (pose, shape));
        let (solid, whole) = (SolidBody::new(list()), CollisionBody::with_solid_meshes(list()).unwrap());
        Self { solid, whole, shapes }
    }

    pub fn of(shape: Shape) -> Self {
        Self::new(vec![(Pose::identity(), shape)])
    }
}

pub fn mesh(vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Shape {
    Shape::Mesh(Arc::new(TriangleMesh::new(vertices, faces).unwrap()))
}

pub fn cuboid_mesh(half: [f64; 3]) -> Shape {
    let at = |i: usize, k: usize| if i >> k & 1 == 0 { -half[k] } else { half[k] };
    let vertices = (0..8).map(|i| Point::new(at(i, 0), at(i, 1), at(i, 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    mesh(vertices, quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}

/// A prism over an outline that is star-shaped about a point.
pub fn prism(outline: &[[f64; 2]], half: f64, middle: [f64; 2]) -> Shape {
    let n = u32::try_from(outline.len()).unwrap();
    let mut vertices: Vec<Point> =
        [-half, half].iter().flat_map(|z| outline.iter().map(|[x, y]| Point::new(*x, *y, *z))).collect();
    vertices.extend([-half, half].map(|z| Point::new(middle[0], middle[1], z)));
    let side = |i: u32| {
        let j = (i + 1) % n;
        [[i, j, n + j], [i, n + j, n + i], [2 * n, j, i], [2 * n + 1, n + i, n + j]]
    };
    mesh(vertices, (0..n).flat_map(side).collect())
}

pub fn angle() -> Shape {
    prism(&[[0.0, 0.0], [0.6, 0.0], [0.6, 0.2], [0.2, 0.2], [0.2, 0.6], [0.0, 0.6]], 0.1, [0.1, 0.1])
}

pub fn gear() -> Shape {
    let corner = |i: u32| {
        let (turn, radius) = (f64::from(i) / 24.0 * std::f64::consts::TAU, [0.5, 0.38][i as usize / 2 % 2]);
        [radius * turn.cos(), radius * turn.sin()]
    };
    prism(&(0..24).map(corner).collect::<Vec<_>>(), 0.15, [0.0, 0.0])
}

pub fn torus() -> Shape {
    let (around, across) = (24, 12);
    let at = |i: u32, j: u32| {
        let [u, v] = [f64::from(i) / 24.0, f64::from(j) / 12.0].map(|share| share * std::f64::consts::TAU);
        let radius = 0.5 + 0.2 * v.cos();
        Point::new(radius * u.cos(), radius * u.sin(), 0.2 * v.sin())
    };
    let vertices = (0..around).flat_map(|i| (0..across).map(move |j| at(i, j))).collect();
    let number = |i: u32, j: u32| (i % around) * across + j % across;
    let quad = |i: u32, j: u32| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    mesh(vertices, (0..around).flat_map(|i| (0..across).flat_map(move |j| quad(i, j))).collect())
}

/// A link of two shapes that overlap.
pub fn hammer() -> Vec<(Pose, Shape)> {
    vec![
        (Pose::identity(), Shape::Primitive(Primitive::Capsule { radius: 0.08, half_length: 0.4 })),
        (Pose::translation(0.05, 0.0, 0.4), cuboid_mesh([0.3, 0.12, 0.1])),
    ]
}

pub fn bodies() -> Vec<Body> {
    let mut bodies: Vec<Body> = [angle(), gear(), torus(), cuboid_mesh([0.2, 0.3, 0.4])].map(Body::of).into();
    bodies.push(Body::of(Shape::Primitive(Primitive::Cylinder { radius: 0.2, half_length: 0.3 })));
    bodies.push(Body::new(hammer()));
    bodies
}
