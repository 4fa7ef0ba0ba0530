//! Penetration depth of overlapping meshes: ratio of the bounds, and time, by number of triangles.
//!
//! `cargo bench --bench penetration_depth`, pinned to one core by `taskset -c 1`.

#[path = "../tests/it/random.rs"]
#[allow(dead_code)] // the tests use the rest
mod random;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use std::time::Instant;

use clearance::geometry::math::{MatrixPose, Point, Pose, Vector};
use clearance::geometry::{Shape, TriangleMesh};
use clearance::proximity::{CollisionBody, Scratch, SolidBody, collide, penetration_depth};

use random::Random;

/// Overlapping poses for each row.
const POSES: usize = 1000;

/// A closed mesh in both forms.
struct Body {
    solid: SolidBody,
    whole: CollisionBody,
}

impl Body {
    fn new(mesh: TriangleMesh) -> Self {
        let shape = Shape::Mesh(Arc::new(mesh));
        let shapes = [(&Pose::identity(), &shape)];
        let whole = CollisionBody::with_solid_meshes(shapes).expect("a body with a shape");
        Self { solid: SolidBody::new(shapes), whole }
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

/// Sorted values at a share of their number.
#[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, clippy::cast_sign_loss)] // small numbers
fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

fn row(name: &str, bodies: &[Body]) {
    let (mut random, mut scratch) = (Random::new(5), Scratch::default());
    let (mut ratios, mut times, mut touching_after) = (Vec::new(), Vec::new(), 0);
    while ratios.len() < POSES {
        let [a, b] = [(); 2]
            .map(|()| &bodies[random.below(u32::try_from(bodies.len()).expect("few bodies")) as usize]);
        let pose = Pose::from_parts(random.vector(0.7).into(), random.rotation());
        if collide(&a.whole, &b.whole, &pose, &mut scratch).is_none() {
            continue;
        }
        if ratios.is_empty() {
            let _ = penetration_depth(&a.solid, &b.solid, &pose, 0.0, &mut scratch);
        }
        let start = Instant::now();
        let depth = penetration_depth(&a.solid, &b.solid, &pose, 0.0, &mut scratch);
        times.push(start.elapsed().as_secs_f64() * 1e3);
        let depth = depth.expect("the bodies overlap");
        ratios.push(depth.upper / depth.lower);
        let pose = MatrixPose::from(&pose);
        let moved = MatrixPose { translation: pose.translation + depth.direction * depth.upper, ..pose };
        touching_after += usize::from(collide(&a.whole, &b.whole, moved, &mut scratch).is_some());
    }
    ratios.sort_by(f64::total_cmp);
    times.sort_by(f64::total_cmp);
    println!(
        "{name:8} upper/lower: median {:.3}, p90 {:.3}; ms: median {:.3}, p90 {:.3}; touching after the translation: {touching_after} of {POSES}",
        quantile(&ratios, 0.5),
        quantile(&ratios, 0.9),
        quantile(&times, 0.5),
        quantile(&times, 0.9),
    );
}

fn main() {
    row("1k", &[torus(32, 16), knot(64, 8), bumpy_sphere(32, 17)].map(Body::new));
    row("10k", &[torus(100, 50), knot(250, 20), bumpy_sphere(100, 51)].map(Body::new));
    row("100k", &[torus(320, 160), knot(800, 64), bumpy_sphere(320, 160)].map(Body::new));
}
