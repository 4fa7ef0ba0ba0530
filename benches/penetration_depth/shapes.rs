//! Closed non-convex meshes for the penetration depth bench: torus, knot and bumpy sphere.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use clearance::geometry::math::{Point, Pose, Vector};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::proximity::{CollisionBody, SolidBody};

/// A mesh in all forms.
pub struct Body {
    pub mesh: Arc<TriangleMesh>,
    pub solid: SolidBody,
    pub whole: CollisionBody,
    /// As the checker has it: a surface.
    pub surface: CollisionBody,
}

impl Body {
    pub fn new(mesh: TriangleMesh) -> Self {
        let mesh = Arc::new(mesh);
        let shape = Shape::Mesh(Arc::clone(&mesh));
        let shapes = [(&Pose::identity(), &shape)];
        let surface = CollisionBody::new(shapes).expect("a body with a shape");
        let whole = CollisionBody::with_solid_meshes(shapes).expect("a body with a shape");
        let solid = SolidBody::of_body(&surface, shapes);
        Self { mesh, solid, whole, surface }
    }
}

/// Three meshes of about so many triangles: a torus, a knot, a bumpy sphere.
pub fn meshes(triangles: u32) -> [TriangleMesh; 3] {
    match triangles {
        1_000 => [torus(32, 16), knot(64, 8), bumpy_sphere(32, 17)],
        10_000 => [torus(100, 50), knot(250, 20), bumpy_sphere(100, 51)],
        _ => [torus(320, 160), knot(800, 64), bumpy_sphere(320, 160)],
    }
}

/// Surface over a grid that closes in both directions.
fn closed_grid(around: u32, across: u32, at: impl Fn(f64, f64) -> Point) -> TriangleMesh {
    let angle = |i: u32, count: u32| f64::from(i) / f64::from(count) * TAU;
    let vertices = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let vertices = vertices.map(|(i, j)| at(angle(i, around), angle(j, across))).collect();
    let number = |i: u32, j: u32| (i % around) * across + j % across;
    let quads = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let faces = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh::new(vertices, faces.collect()).expect("a valid mesh")
}

fn torus(around: u32, across: u32) -> TriangleMesh {
    closed_grid(around, across, |u, v| {
        let radius = 0.5 + 0.2 * v.cos();
        Point::new(radius * u.cos(), radius * u.sin(), 0.2 * v.sin())
    })
}

/// A tube along a trefoil knot.
fn knot(around: u32, across: u32) -> TriangleMesh {
    let centre = |u: f64| {
        let double = 2.0 * u;
        Vector::new(u.sin() + 2.0 * double.sin(), u.cos() - 2.0 * double.cos(), -(3.0 * u).sin()) * 0.2
    };
    closed_grid(around, across, move |u, v| {
        let along = (centre(u + 1e-4) - centre(u - 1e-4)).normalize();
        let normal = along.cross(&Vector::new(0.3, 0.1, 1.0)).normalize();
        Point::from(centre(u) + (normal * v.cos() + along.cross(&normal) * v.sin()) * 0.08)
    })
}

/// A sphere whose radius depends on the direction.
fn bumpy_sphere(around: u32, rings: u32) -> TriangleMesh {
    let at = |polar: f64, azimuth: f64| {
        let n = Vector::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos());
        let bumps = 0.25 * (5.0 * n.x).sin() * (4.0 * n.y + 1.0).cos() + 0.1 * (9.0 * n.z).sin();
        Point::from(n * (0.4 * (1.0 + bumps)))
    };
    let ring = |i: u32| PI * f64::from(i) / f64::from(rings);
    let mut vertices = vec![at(0.0, 0.0), at(PI, 0.0)];
    let grid = (1..rings).flat_map(|i| (0..around).map(move |j| (i, j)));
    vertices.extend(grid.map(|(i, j)| at(ring(i), TAU * f64::from(j) / f64::from(around))));
    let number = |i: u32, j: u32| 2 + (i - 1) * around + j % around;
    let mut faces: Vec<[u32; 3]> = (0..around)
        .flat_map(|j| {
            let last = rings - 1;
            [[0, number(1, j), number(1, j + 1)], [1, number(last, j + 1), number(last, j)]]
        })
        .collect();
    for (i, j) in (1..rings - 1).flat_map(|i| (0..around).map(move |j| (i, j))) {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        faces.extend([[a, b, c], [a, c, d]]);
    }
    TriangleMesh::new(vertices, faces).expect("a valid mesh")
}
