//! Test helper: bodies and shapes for tests of contacts, with brute-force tests of points inside them.

use std::f64::consts::TAU;
use std::sync::Arc;

use clearance_geometry::math::{Extremes, Point, Pose, Vector};
use clearance_geometry::{Primitive, Shape, TriangleMesh};

use crate::{CollisionBody, SolidBody};

/// A body in all forms.
pub struct Body {
    pub solid: SolidBody,
    pub hollow: CollisionBody,
    pub shapes: Vec<(Pose, Shape)>,
}

impl Body {
    pub fn new(shapes: Vec<(Pose, Shape)>) -> Self {
        let list = || shapes.iter().map(|(pose, shape)| (pose, shape));
        let (solid, hollow) = (SolidBody::new(list()), CollisionBody::new(list()).unwrap());
        Self { solid, hollow, shapes }
    }

    pub fn of(shape: Shape) -> Self {
        Self::new(vec![(Pose::identity(), shape)])
    }

    /// Whether a point is inside one of the shapes, or on it.
    pub fn holds(&self, p: &Point, slack: f64) -> bool {
        self.shapes.iter().any(|(pose, shape)| holds(shape, &pose.inverse_transform_point(p), slack))
    }
}

/// Kinds and sizes of the shapes.
impl std::fmt::Display for Body {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (_, shape) in &self.shapes {
            match shape {
                Shape::Primitive(primitive) => write!(f, "{primitive:?} ")?,
                Shape::Mesh(mesh) => write!(f, "mesh of {} ", mesh.triangles().len())?,
                other => write!(f, "{} ", other.kind())?,
            }
        }
        Ok(())
    }
}

fn holds(shape: &Shape, p: &Point, slack: f64) -> bool {
    match shape {
        Shape::Primitive(primitive) => distance(primitive, p) <= slack,
        Shape::Mesh(mesh) => {
            let triangles = || (0..mesh.triangles().len()).map(|i| mesh.triangle(i));
            let angle: f64 = triangles().map(|t| solid_angle(t.corners().map(|c| c - p))).sum();
            angle.abs() > TAU || triangles().any(|t| distance_of_triangle(&t.corners(), p) <= slack)
        }
        // the side where other bodies are not
        Shape::Plane(plane) => plane.height(p) <= slack,
        Shape::Points(cloud) => {
            let centres = cloud.points().iter().map(|c| Point::from(c.map(f64::from)));
            centres.into_iter().any(|c| (p - c).norm() <= cloud.radius() + slack)
        }
        Shape::Voxels(voxels) => voxels.cubes().iter().any(|cube| {
            let from = p - Point::from(cube.centre.map(f64::from));
            from.amax() <= f64::from(cube.half_edge) + slack
        }),
    }
}

/// Distance (m) of a point from a primitive; zero inside.
fn distance(primitive: &Primitive, p: &Point) -> f64 {
    let across = p.x.hypot(p.y);
    match *primitive {
        Primitive::Box { half_extents } => {
            (p.coords.abs() - Vector::from(half_extents)).map(|c| c.greater(0.0)).norm()
        }
        Primitive::Sphere { radius } => (p.coords.norm() - radius).greater(0.0),
        Primitive::Cylinder { radius, half_length } => {
            (across - radius).greater(0.0).hypot((p.z.abs() - half_length).greater(0.0))
        }
        Primitive::Capsule { radius, half_length } => {
            (across.hypot((p.z.abs() - half_length).greater(0.0)) - radius).greater(0.0)
        }
        Primitive::Cone { radius, half_length } => {
            // nearest point of the triangle in the half plane through the axis, by samples of its sides
            let corners = [[0.0, half_length], [radius, -half_length], [0.0, -half_length]];
            let flat = corners.map(|[r, z]| Point::new(r, z, 0.0));
            distance_of_triangle(&flat, &Point::new(across, p.z, 0.0))
        }
    }
}

/// Solid angle of a triangle seen from the origin (Van Oosterom & Strackee 1983).
fn solid_angle([a, b, c]: [Vector; 3]) -> f64 {
    let (x, y, z) = (a.norm(), b.norm(), c.norm());
    let below = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
    2.0 * a.dot(&b.cross(&c)).atan2(below)
}

/// Distance (m) of a point from a triangle: its projection if that is inside, or the nearest point of an edge.
pub fn distance_of_triangle([a, b, c]: &[Point; 3], p: &Point) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let inside = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(from, to)| normal.dot(&(*to - *from).cross(&(p - *from))) >= 0.0);
    let of_edge = |from: &Point, to: &Point| {
        let along = to - from;
        let share = if along.norm() > 0.0 { (p - from).dot(&along) / along.norm_squared() } else { 0.0 };
        (from + along * share.clamp(0.0, 1.0) - p).norm()
    };
    let of_edges = of_edge(a, b).lesser(of_edge(b, c)).lesser(of_edge(c, a));
    if inside && normal.norm() > 0.0 {
        (normal.dot(&(p - a)).abs() / normal.norm()).lesser(of_edges)
    } else {
        of_edges
    }
}

pub fn mesh(vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Shape {
    Shape::Mesh(Arc::new(TriangleMesh::new(vertices, faces).unwrap()))
}

pub fn cuboid(half_extents: [f64; 3]) -> Shape {
    Shape::Primitive(Primitive::Box { half_extents })
}

pub fn ball(radius: f64) -> Shape {
    Shape::Primitive(Primitive::Sphere { radius })
}

/// Boxes given by centre and half extents, as one mesh.
pub fn box_meshes(boxes: &[([f64; 3], [f64; 3])]) -> Shape {
    let (mut vertices, mut faces): (Vec<Point>, Vec<[u32; 3]>) = Default::default();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for (centre, half) in boxes {
        let first = u32::try_from(vertices.len()).unwrap();
        let at = |i: usize, k: usize| centre[k] + if i >> k & 1 == 0 { -half[k] } else { half[k] };
        vertices.extend((0..8).map(|i| Point::new(at(i, 0), at(i, 1), at(i, 2))));
        faces.extend(quads.iter().flat_map(|q| {
            let [a, b, c, d] = q.map(|v| v + first);
            [[a, b, c], [a, c, d]]
        }));
    }
    mesh(vertices, faces)
}

/// Surface over a grid that closes in both directions.
pub fn closed_grid(around: u32, across: u32, at: impl Fn(f64, f64) -> Point) -> Shape {
    let angle = |i: u32, count: u32| f64::from(i) / f64::from(count) * TAU;
    let all = || (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let vertices = all().map(|(i, j)| at(angle(i, around), angle(j, across))).collect();
    let number = |i: u32, j: u32| (i % around) * across + j % across;
    let quad = |(i, j): (u32, u32)| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    mesh(vertices, all().flat_map(quad).collect())
}

pub fn torus(around: u32, across: u32) -> Shape {
    closed_grid(around, across, |u, v| {
        let radius = 0.5 + 0.2 * v.cos();
        Point::new(radius * u.cos(), radius * u.sin(), 0.2 * v.sin())
    })
}

/// A sphere of radius 1 m times `scale`, made of rings of triangles around the z axis.
pub fn sphere_mesh(rings: u32, scale: f64) -> Shape {
    let around = 2 * rings;
    let polar = |i: u32| std::f64::consts::PI * f64::from(i) / f64::from(rings);
    let at = |i: u32, j: u32| {
        let turn = TAU * f64::from(j) / f64::from(around);
        Point::new(polar(i).sin() * turn.cos(), polar(i).sin() * turn.sin(), polar(i).cos()) * scale
    };
    let mut vertices = vec![Point::new(0.0, 0.0, scale), Point::new(0.0, 0.0, -scale)];
    vertices.extend((1..rings).flat_map(|i| (0..around).map(move |j| (i, j))).map(|(i, j)| at(i, j)));
    let number = |i: u32, j: u32| 2 + (i - 1) * around + j % around;
    let ends =
        |j: u32| [[0, number(1, j), number(1, j + 1)], [1, number(rings - 1, j + 1), number(rings - 1, j)]];
    let mut faces: Vec<[u32; 3]> = (0..around).flat_map(ends).collect();
    for (i, j) in (1..rings - 1).flat_map(|i| (0..around).map(move |j| (i, j))) {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        faces.extend([[a, b, c], [a, c, d]]);
    }
    mesh(vertices, faces)
}

/// A table or chair: a plate at height 0 on four legs that end at -0.4 m.
pub fn table_boxes() -> Vec<([f64; 3], [f64; 3])> {
    let legs = [[-0.3, -0.2], [0.3, -0.2], [-0.3, 0.2], [0.3, 0.2]];
    let mut boxes = vec![([0.0, 0.0, 0.0], [0.35, 0.25, 0.02])];
    boxes.extend(legs.map(|[x, y]| ([x, y, -0.2], [0.02, 0.03, 0.2])));
    boxes
}
