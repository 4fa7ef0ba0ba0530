//! Tests of mesh simplification on random surfaces: topology, and distances against dense samples.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

use clearance_geometry::Primitive;
use clearance_geometry::math::Vector;

use super::*;
use crate::primitive_mesh::inscribed_mesh;

/// Vertices on a grid of `[rows, columns]`, which may be closed to rings.
fn grid(
    [rows, columns]: [u32; 2],
    is_ring: [bool; 2],
    vertex: impl Fn(f64, f64) -> Point,
) -> Arc<TriangleMesh> {
    let at = |i: u32, j: u32| (i % rows) * columns + j % columns;
    let part = |i: u32, n: u32, ring: bool| f64::from(i) / f64::from(if ring { n } else { n - 1 });
    let place = |i, j| vertex(part(i, rows, is_ring[0]), part(j, columns, is_ring[1]));
    let vertices =
        (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))).map(|(i, j)| place(i, j)).collect();
    let [last_row, last_column] = [rows - u32::from(!is_ring[0]), columns - u32::from(!is_ring[1])];
    let cells = (0..last_row).flat_map(|i| (0..last_column).map(move |j| (i, j)));
    let faces = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    Arc::new(TriangleMesh::new(vertices, faces.collect()).unwrap())
}

/// A torus with bumps: closed, of genus one.
fn torus() -> Arc<TriangleMesh> {
    grid([24, 40], [true, true], |u, v| {
        let (u, v) = (TAU * u, TAU * v);
        let radius = 0.03 + 0.004 * (3.0 * v).sin() * (2.0 * u).cos();
        let out = 0.1 + radius * u.cos();
        Point::new(out * v.cos(), out * v.sin(), -radius * u.sin())
    })
}

/// A sphere with bumps.
fn bumpy() -> Arc<TriangleMesh> {
    let (mesh, _) = inscribed_mesh(&Primitive::sphere(0.1).unwrap()).unwrap();
    let bump = |p: &Point| p * (1.0 + 0.05 * (50.0 * p.x).sin() * (40.0 * p.y + 1.0).cos());
    Arc::new(
        TriangleMesh::new(mesh.vertices().iter().map(bump).collect(), mesh.triangles().to_vec()).unwrap(),
    )
}

/// A curved sheet with a boundary.
fn sheet() -> Arc<TriangleMesh> {
    grid([20, 25], [false, false], |u, v| {
        Point::new(0.2 * u, 0.3 * v, 0.05 * (4.0 * u).sin() * (3.0 * v).cos())
    })
}

/// A tube with two boundaries.
fn tube() -> Arc<TriangleMesh> {
    grid([12, 30], [false, true], |u, v| {
        let radius = 0.05 + 0.01 * (5.0 * u).sin();
        Point::new(radius * (TAU * v).cos(), radius * (TAU * v).sin(), 0.2 * u)
    })
}

/// A cube of 6 · 2 n² triangles, with an edge of `size`.
fn cube(n: u32, size: f64, low: Vector) -> TriangleMesh {
    let (mut vertices, mut faces) = (vec![], vec![]);
    for side in 0..6_u8 {
        let first = u32::try_from(vertices.len()).unwrap();
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            let [a, b] = [i, j].map(|k| f64::from(k) / f64::from(n));
            let c = f64::from(side / 3);
            let [a, b] = if side < 3 { [a, b] } else { [b, a] };
            let mut p = [c; 3];
            (p[(usize::from(side) + 1) % 3], p[(usize::from(side) + 2) % 3]) = (b, a);
            vertices.push(Point::from(low + Vector::from(p) * size));
        }
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let [a, b] = [first + i * (n + 1) + j, first + (i + 1) * (n + 1) + j];
            faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    TriangleMesh::new(vertices, faces).unwrap()
}

fn joined(meshes: &[TriangleMesh]) -> Arc<TriangleMesh> {
    let (mut vertices, mut faces): (Vec<Point>, Vec<[u32; 3]>) = (vec![], vec![]);
    for mesh in meshes {
        let first = u32::try_from(vertices.len()).unwrap();
        vertices.extend(mesh.vertices());
        faces.extend(mesh.triangles().iter().map(|face| face.map(|v| v + first)));
    }
    Arc::new(TriangleMesh::new(vertices, faces).unwrap())
}

/// Cubes that touch at a corner and at an edge, faces that occur twice, faces without area, and loose triangles.
fn tangle() -> Arc<TriangleMesh> {
    let cubes = [
        cube(2, 0.1, Vector::zeros()),
        cube(3, 0.1, Vector::new(0.1, 0.1, 0.1)),
        cube(2, 0.1, Vector::new(0.1, -0.1, 0.0)),
        cube(2, 0.1, Vector::new(0.5, 0.0, 0.0)),
        cube(2, 0.1, Vector::new(0.5, 0.0, 0.0)),
    ];
    let mut random = fastrand::Rng::with_seed(3);
    let mut point = || Point::new(random.f64(), random.f64(), random.f64()) * 0.2;
    let loose: Vec<Point> = (0..12).map(|_| point()).collect();
    let faces =
        vec![[0, 1, 2], [2, 1, 0], [0, 0, 1], [2, 2, 2], [0, 1, 3], [0, 1, 6], [7, 8, 9], [9, 10, 11]];
    joined(&[&cubes[..], &[TriangleMesh::new(loose, faces).unwrap()]].concat())
}

fn simplified(mesh: &Arc<TriangleMesh>, size: MeshSize) -> Simplified {
    let (mut meshes, is_whole) = simplify(std::slice::from_ref(mesh), size, &SearchLimit::default()).unwrap();
    assert!(is_whole && meshes.len() == 1);
    meshes.remove(0)
}

/// Euler characteristic, and number of boundary edges; panics at an edge with more than two faces, or with two in one direction.
fn topology(mesh: &TriangleMesh) -> [i64; 2] {
    let mut edges: HashMap<[u32; 2], [u32; 2]> = HashMap::new();
    for [a, b, c] in mesh.triangles() {
        assert!(a != b && b != c && c != a);
        for [p, q] in [[a, b], [b, c], [c, a]] {
            edges.entry([*p.min(q), *p.max(q)]).or_default()[usize::from(p > q)] += 1;
        }
    }
    assert!(edges.values().all(|sides| sides.iter().all(|count| *count <= 1)), "an edge has too many faces");
    let vertices: HashSet<u32> = mesh.triangles().iter().flatten().copied().collect();
    let boundary = edges.values().filter(|sides| sides[0] + sides[1] == 1).count();
    let count = |n: usize| i64::try_from(n).unwrap();
    [count(vertices.len()) - count(edges.len()) + count(mesh.triangles().len()), count(boundary)]
}

/// Distance of a point from a triangle: from the plane if the foot is inside, else from the edges.
fn distance(p: &Point, [a, b, c]: [Point; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let is_inside = |p: &Point, q: &Point| normal.cross(&(q - p));
    let is_over = normal.norm() > 0.0
        && [[a, b], [b, c], [c, a]].iter().all(|[from, to]| is_inside(from, to).dot(&(p - from)) >= 0.0);
    let mut least = if is_over { normal.dot(&(p - a)).abs() / normal.norm() } else { f64::INFINITY };
    for [from, to] in [[a, b], [b, c], [c, a]] {
        let edge: Vector = to - from;
        let part = if edge.norm() > 0.0 { edge.dot(&(p - from)) / edge.norm_squared() } else { 0.0 };
        least = least.min((from + edge * part.clamp(0.0, 1.0) - p).norm());
    }
    least
}

fn distance_from(mesh: &TriangleMesh, p: &Point) -> f64 {
    let corners = |face: &[u32; 3]| face.map(|v| mesh.vertices()[v as usize]);
    mesh.triangles().iter().map(|face| distance(p, corners(face))).fold(f64::INFINITY, f64::min)
}

/// Largest distance of samples of the first surface from the second.
fn sampled(from: &TriangleMesh, to: &TriangleMesh, random: &mut fastrand::Rng) -> f64 {
    let samples = 3000 / from.triangles().len() + 1;
    let mut largest = 0.0_f64;
    for face in from.triangles() {
        let [a, b, c] = face.map(|v| from.vertices()[v as usize]);
        for i in 0..samples {
            let [mut s, mut t] = [random.f64(), random.f64()];
            if i == 0 {
                [s, t] = [0.0, 0.0];
            } else if s + t > 1.0 {
                [s, t] = [1.0 - s, 1.0 - t];
            }
            largest = largest.max(distance_from(to, &(a + (b - a) * s + (c - a) * t)));
        }
    }
    largest
}

fn assert_bounds_hold(original: &TriangleMesh, simplified: &Simplified, what: &str) {
    let Simplified { mesh, distance } = simplified;
    let mut random = fastrand::Rng::with_seed(1);
    let found = sampled(original, mesh, &mut random).max(sampled(mesh, original, &mut random));
    assert!(found <= distance.upper, "{what}: {found} is more than {distance:?}");
    let at_point = distance_from(original, &distance.point).max(distance_from(mesh, &distance.point));
    assert!(at_point >= distance.lower - 1e-9, "{what}: {at_point} is less than {distance:?}");
}

#[test]
fn topology_is_kept_and_the_count_is_reached() {
    for (name, mesh, least) in [
        ("torus", torus(), 14),
        ("bumpy", bumpy(), 4),
        ("sheet", sheet(), 1),
        ("tube", tube(), 6),
        ("two", joined(&[cube(2, 0.1, Vector::zeros()), cube(2, 0.1, Vector::new(0.3, 0.0, 0.0))]), 8),
    ] {
        let [euler, boundary] = topology(&joined_vertices(&mesh));
        for count in [300, 40, 4] {
            let Simplified { mesh: found, .. } = simplified(&mesh, MeshSize::Triangles(count));
            let now = topology(&joined_vertices(&found));
            assert_eq!(now[0], euler, "{name} {count}");
            assert_eq!(now[1] > 0, boundary > 0, "{name} {count}");
            assert!(
                found.triangles().len() <= count.max(4 * least),
                "{name} {count}: {}",
                found.triangles().len()
            );
            assert!(found.triangles().len() >= least, "{name} {count}");
        }
    }
}

/// The mesh with vertices at equal positions joined.
fn joined_vertices(mesh: &TriangleMesh) -> TriangleMesh {
    let clearance_geometry::WeldedMesh { positions, faces } = clearance_geometry::WeldedMesh::new(mesh);
    TriangleMesh::new(positions, faces).unwrap()
}

#[test]
fn distances_hold_for_dense_samples() {
    for (name, mesh) in [("torus", torus()), ("sheet", sheet()), ("tube", tube()), ("tangle", tangle())] {
        for count in [200, 4] {
            let found = simplified(&mesh, MeshSize::Triangles(count));
            assert_bounds_hold(&mesh, &found, name);
        }
        let found = simplified(&mesh, MeshSize::Distance(0.004));
        assert_bounds_hold(&mesh, &found, name);
        assert!(
            found.distance.upper <= 0.004 && found.mesh.triangles().len() < mesh.triangles().len(),
            "{name}"
        );
    }
}

#[test]
fn plane_faces_lose_their_inner_vertices_without_error() {
    // powers of two are exact in single precision
    let fine = Arc::new(cube(4, 0.25, Vector::new(-0.5, 0.125, 1.0)));
    let found = simplified(&fine, MeshSize::Triangles(12));
    assert_eq!(found.mesh.triangles().len(), 12);
    assert!(found.distance.upper <= 2e-4, "{:?}", found.distance);
    assert_bounds_hold(&fine, &found, "cube");
    assert!((found.mesh.signed_volume() - fine.signed_volume()).abs() < 1e-9, "no face is turned over");
    let few = simplified(&fine, MeshSize::Distance(1e-3)).mesh.triangles().len();
    assert!(few <= 12, "{few}");
    let sheet = grid([9, 7], [false, false], |u, v| Point::new(0.25 * u, 0.5 * v, 0.0));
    let found = simplified(&sheet, MeshSize::Triangles(4));
    assert!(found.mesh.triangles().len() <= 4 && found.distance.upper <= 2e-4, "{:?}", found.distance);
}

#[test]
fn small_meshes_are_unchanged() {
    let cube = Arc::new(cube(1, 0.25, Vector::zeros()));
    let found = simplified(&cube, MeshSize::Triangles(12));
    assert!(*found.mesh == *cube && found.distance.upper == 0.0);
    // what no single-precision number is, is rounded, and the bound contains the rounding
    let third = Arc::new(TriangleMesh::clone(&cube).scaled(Vector::repeat(1.0 / 3.0)).unwrap());
    let found = simplified(&third, MeshSize::Triangles(12));
    assert!(found.distance.upper > 0.0 && found.distance.upper < 1e-8);
    assert_bounds_hold(&third, &found, "rounded");
}

#[test]
fn meshes_of_a_link_share_the_triangles_by_need() {
    let meshes = [torus(), Arc::new(cube(10, 0.1, Vector::zeros()))];
    let (found, _) = simplify(&meshes, MeshSize::Triangles(412), &SearchLimit::default()).unwrap();
    let [torus, cube] = [0, 1].map(|i| found[i].mesh.triangles().len());
    assert!(torus + cube <= 412 && cube <= 40, "{torus} and {cube}");
}

#[test]
fn a_smaller_distance_takes_more_triangles() {
    let counts = [0.01, 0.003, 0.001].map(|distance| {
        let found = simplified(&torus(), MeshSize::Distance(distance));
        assert!(found.distance.upper <= distance);
        found.mesh.triangles().len()
    });
    assert!(counts.is_sorted() && counts[0] < counts[2], "{counts:?}");
}

#[test]
fn distances_hold_wherever_the_time_ends() {
    let mesh = tube();
    for calls in [0, 1, 2, 3, 5, 9, 17, 40] {
        for size in [MeshSize::Triangles(50), MeshSize::Distance(0.002)] {
            let (found, is_whole) =
                simplify(std::slice::from_ref(&mesh), size, &SearchLimit::after(calls)).unwrap();
            assert_bounds_hold(&mesh, &found[0], &format!("{size:?} after {calls}"));
            assert!(!is_whole || calls > 2, "{size:?} after {calls}");
            assert_eq!(topology(&joined_vertices(&found[0].mesh))[0], 0);
        }
    }
}

/// Two cones of so many faces on one rim.
fn double_cone(faces: u32) -> Arc<TriangleMesh> {
    let rim = (0..faces).map(|i| {
        let angle = f64::from(i) / f64::from(faces) * TAU;
        Point::new(0.1 * angle.cos(), 0.1 * angle.sin(), 0.0)
    });
    let vertices = [0.05, -0.05].map(|z| Point::new(0.0, 0.0, z)).into_iter().chain(rim).collect();
    let triangles = (0..faces).flat_map(|i| {
        let [a, b] = [2 + i, 2 + (i + 1) % faces];
        [[0, a, b], [1, b, a]]
    });
    Arc::new(TriangleMesh::new(vertices, triangles.collect()).unwrap())
}

/// The apexes have more faces than a test of an edge reads, until the rim has fewer vertices.
#[test]
fn vertices_of_very_many_faces_are_simplified_around() {
    let mesh = double_cone(2000);
    let found = simplified(&mesh, MeshSize::Triangles(100));
    assert!(found.mesh.triangles().len() <= 100, "{}", found.mesh.triangles().len());
    assert_eq!(topology(&joined_vertices(&found.mesh)), [2, 0]);
    assert!(found.distance.upper < 0.002, "{:?}", found.distance);
    let (cut, is_whole) =
        simplify(std::slice::from_ref(&mesh), MeshSize::Triangles(100), &SearchLimit::after(8)).unwrap();
    assert!(!is_whole && cut[0].mesh.triangles().len() > 3000);
}
