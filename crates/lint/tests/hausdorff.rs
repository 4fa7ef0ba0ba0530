//! Tests of certified Hausdorff distances against exact cases and dense samples.

use std::sync::Arc;

use clearance_geometry::math::{Point, Pose, Vector};
use clearance_geometry::testing::Random;
use clearance_geometry::{Primitive, TriangleMesh};
use clearance_lint::{HausdorffBounds, HausdorffOptions, PlacedShape, hausdorff};

fn surface() -> HausdorffOptions {
    HausdorffOptions { target_is_solid: false, ..HausdorffOptions::default() }
}

fn bounds(from: &PlacedShape, to: &PlacedShape, options: &HausdorffOptions) -> HausdorffBounds {
    let found =
        hausdorff(std::slice::from_ref(from), std::slice::from_ref(to), options).expect("neither is empty");
    assert!(found.lower <= found.upper && !found.ended_early, "{found:?}");
    let gap = (found.lower * options.relative_gap).max(options.absolute_gap);
    assert!(found.upper - found.lower <= gap + 3e-4, "{found:?}");
    assert!(!found.is_within_gap || found.upper - found.lower <= 1.001 * gap, "{found:?}");
    found
}

fn assert_contains(found: &HausdorffBounds, exact: f64, what: &str) {
    assert!(found.lower <= exact && exact <= found.upper, "{what}: {exact} is not in {found:?}");
}

/// A box with edges of these lengths, as a mesh of 12 triangles around `centre`.
fn box_mesh(size: [f64; 3], centre: [f64; 3]) -> PlacedShape {
    let corner =
        |i: usize, axis: usize| centre[axis] + size[axis] * if i >> axis & 1 == 0 { -0.5 } else { 0.5 };
    let vertices = (0..8).map(|i| Point::new(corner(i, 0), corner(i, 1), corner(i, 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    PlacedShape::mesh(Arc::new(TriangleMesh::new(vertices, faces).unwrap()))
}

/// A sphere around the origin as a mesh whose vertices lie on it.
fn sphere_mesh(radius: f64, rings: u32, shift: Vector) -> TriangleMesh {
    let count = 2 * rings;
    let mut vertices = vec![Point::new(0.0, 0.0, radius)];
    for ring in 1..rings {
        let polar = f64::from(ring) / f64::from(rings) * std::f64::consts::PI;
        for step in 0..count {
            let around = f64::from(step) / f64::from(count) * std::f64::consts::TAU;
            let direction = Vector::new(polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos());
            vertices.push(Point::from(direction * radius));
        }
    }
    vertices.push(Point::new(0.0, 0.0, -radius));
    let at = |ring: u32, step: u32| 1 + (ring - 1) * count + step % count;
    let last = u32::try_from(vertices.len()).unwrap() - 1;
    let mut faces = vec![];
    for step in 0..count {
        faces.push([0, at(1, step), at(1, step + 1)]);
        faces.push([last, at(rings - 1, step + 1), at(rings - 1, step)]);
        for ring in 1..rings - 1 {
            faces.push([at(ring, step), at(ring + 1, step), at(ring + 1, step + 1)]);
            faces.push([at(ring, step), at(ring + 1, step + 1), at(ring, step + 1)]);
        }
    }
    let vertices = vertices.into_iter().map(|p| p + shift).collect();
    TriangleMesh::new(vertices, faces).unwrap()
}

fn sphere(radius: f64, rings: u32, shift: Vector) -> PlacedShape {
    PlacedShape::mesh(Arc::new(sphere_mesh(radius, rings, shift)))
}

#[test]
fn boxes_have_exact_distances() {
    let (small, large) = (box_mesh([1.0; 3], [0.0; 3]), box_mesh([2.0; 3], [0.0; 3]));
    // from a corner of the large one to a corner of the small one
    assert_contains(&bounds(&large, &small, &HausdorffOptions::default()), 0.75_f64.sqrt(), "outward");
    // every point of the small surface is 0.5 m below the large one
    assert_contains(&bounds(&small, &large, &surface()), 0.5, "inward");
    let inside = bounds(&small, &large, &HausdorffOptions::default());
    assert_eq!((inside.lower, inside.upper < 1e-6), (0.0, true), "{inside:?}");
}

#[test]
fn primitives_are_as_their_meshes() {
    let half = Primitive::cuboid([2.0; 3]).unwrap();
    let (solid, mesh) = (PlacedShape::primitive(half, Pose::identity()), box_mesh([3.0, 2.0, 2.0], [0.0; 3]));
    assert_contains(&bounds(&mesh, &solid, &HausdorffOptions::default()), 0.5, "to a box");
    let ball = PlacedShape::primitive(Primitive::sphere(0.5).unwrap(), Pose::translation(0.0, 0.0, 1.0));
    assert_contains(&bounds(&ball, &solid, &HausdorffOptions::default()), 0.5, "of a ball");
    for (primitive, exact) in [
        (Primitive::cylinder(1.0, 4.0).unwrap(), 1.0),
        (Primitive::capsule(0.5, 2.0).unwrap(), 0.5),
        (Primitive::cone(0.5, 6.0).unwrap(), 2.0),
    ] {
        let from = PlacedShape::primitive(primitive, Pose::identity());
        assert_contains(&bounds(&from, &solid, &HausdorffOptions::default()), exact, "of a primitive");
    }
    for primitive in [
        Primitive::cylinder(1.0, 2.0),
        Primitive::sphere(1.0),
        Primitive::capsule(1.0, 0.5),
        Primitive::cone(2.0, 2.0),
    ] {
        let own = PlacedShape::primitive(primitive.unwrap(), Pose::identity());
        let found = bounds(&own, &own, &HausdorffOptions::default());
        assert!(found.lower == 0.0 && found.upper < 3e-4, "{found:?}");
    }
}

#[test]
fn a_translation_is_the_distance_of_its_copies() {
    for length in [1e-4, 0.01, 0.3] {
        let shift = Vector::new(0.0, 0.0, length);
        let (fixed, moved) = (sphere(0.5, 24, Vector::zeros()), sphere(0.5, 24, shift));
        for found in [bounds(&fixed, &moved, &surface()), bounds(&moved, &fixed, &surface())] {
            assert!(
                found.upper <= length * 1.0021 + 2e-6 && found.lower > 0.9 * length,
                "{length}: {found:?}"
            );
        }
    }
    // of concentric spheres: the largest distance is at a vertex of the outer one or within its sagitta
    let found = bounds(
        &sphere(0.6, 24, Vector::zeros()),
        &sphere(0.5, 24, Vector::zeros()),
        &HausdorffOptions::default(),
    );
    assert!(found.lower >= 0.1 - 1e-9 && found.upper < 0.1 + 0.005, "{found:?}");
}

/// A connected surface of random triangles.
fn random_mesh(random: &mut Random, faces: u32) -> TriangleMesh {
    let vertices = (0..faces + 2).map(|_| Point::from(random.vector(1.0))).collect();
    TriangleMesh::new(vertices, (0..faces).map(|i| [i, i + 1, i + 2]).collect()).unwrap()
}

#[test]
fn dense_samples_stay_below_the_upper_bound() {
    let mut random = Random::new(7);
    for _ in 0..30 {
        let [a, b] = [(); 2].map(|()| Arc::new(random_mesh(&mut random, 6)));
        let found = bounds(&PlacedShape::mesh(a.clone()), &PlacedShape::mesh(b.clone()), &surface());
        let distance = |p: &Point| {
            let of = |i| (b.triangle(i).nearest_point(p) - p).norm();
            (0..b.triangles().len()).map(of).fold(f64::INFINITY, f64::min)
        };
        let mut largest = 0.0_f64;
        for face in 0..a.triangles().len() {
            let t = a.triangle(face);
            for i in 0..=40 {
                for j in 0..=40 - i {
                    let p = t.a + (t.b - t.a) * (f64::from(i) / 40.0) + (t.c - t.a) * (f64::from(j) / 40.0);
                    largest = largest.max(distance(&p));
                }
            }
        }
        assert!(largest <= found.upper, "{largest} is above {found:?}");
        assert!((distance(&found.point) - found.lower).abs() < 1e-9, "{found:?}");
        // samples are at most 0.05 of the longest edge apart
        assert!(found.lower <= largest + 0.18, "{found:?}, samples {largest}");
    }
}

#[test]
fn flat_and_single_triangles_are_measured() {
    let line = TriangleMesh::new(vec![Point::origin(), Point::new(1.0, 0.0, 0.0)], vec![[0, 1, 1]]).unwrap();
    let line = PlacedShape::mesh(Arc::new(line));
    let ball = PlacedShape::primitive(Primitive::sphere(0.25).unwrap(), Pose::identity());
    assert_contains(&bounds(&line, &ball, &HausdorffOptions::default()), 0.75, "of a line");
    assert_contains(&bounds(&ball, &line, &HausdorffOptions::default()), 0.25, "to a line");
    assert_eq!(hausdorff(&[], std::slice::from_ref(&ball), &HausdorffOptions::default()), None);
    assert_eq!(hausdorff(std::slice::from_ref(&ball), &[], &HausdorffOptions::default()), None);
}

#[test]
fn the_gap_holds_with_the_error_of_curved_surfaces() {
    let block = PlacedShape::primitive(Primitive::cuboid([0.2; 3]).unwrap(), Pose::identity());
    let plate = box_mesh([0.3, 0.3, 0.01], [0.0; 3]);
    for primitive in [Primitive::sphere(0.15), Primitive::cylinder(0.15, 0.3), Primitive::capsule(0.15, 0.2)]
    {
        let round = PlacedShape::primitive(primitive.unwrap(), Pose::identity());
        let found = bounds(&round, &block, &HausdorffOptions::default());
        assert!(found.is_within_gap, "{found:?}");
        // a gap below the error of the surface is out of reach
        let narrow = HausdorffOptions { relative_gap: 1e-6, ..HausdorffOptions::default() };
        let found = bounds(&round, &block, &narrow);
        assert!(!found.is_within_gap, "{found:?}");
        // the plate is flat, and has no such error
        assert!(bounds(&plate, &round, &HausdorffOptions::default()).is_within_gap);
    }
}

#[test]
fn a_search_that_ends_early_keeps_valid_bounds() {
    let (fixed, moved) = (sphere(0.5, 24, Vector::zeros()), sphere(0.5, 24, Vector::new(0.02, 0.01, 0.0)));
    let few = HausdorffOptions { most_samples: 1, relative_gap: 1e-9, absolute_gap: 1e-12, ..surface() };
    let early = hausdorff(std::slice::from_ref(&moved), std::slice::from_ref(&fixed), &few).unwrap();
    let whole = bounds(&moved, &fixed, &surface());
    assert!(early.ended_early && !early.is_within_gap);
    assert!(early.lower <= whole.upper && whole.lower <= early.upper, "{early:?}, {whole:?}");
}

#[test]
fn inner_geometry_that_touches_a_solid_needs_few_samples() {
    // three faces of the small box lie in faces of the large one, the edges of the others touch them
    let (small, large) = (box_mesh([1.0; 3], [0.5; 3]), box_mesh([2.0; 3], [1.0; 3]));
    let found = bounds(&small, &large, &HausdorffOptions::default());
    assert!(found.lower == 0.0 && found.upper <= 1e-6 + 1e-12, "{found:?}");
    assert!(found.samples < 2_000, "{found:?}");
    // with the surface alone, the inner corner is 1 m away
    assert_contains(&bounds(&small, &large, &surface()), 1.0, "surface");
}

#[test]
fn a_deadline_that_has_passed_leaves_valid_bounds() {
    let (fixed, moved) = (sphere(0.5, 24, Vector::zeros()), sphere(0.5, 24, Vector::new(0.02, 0.01, 0.0)));
    let late = HausdorffOptions { deadline: Some(std::time::Instant::now()), ..surface() };
    let early = hausdorff(std::slice::from_ref(&moved), std::slice::from_ref(&fixed), &late).unwrap();
    let whole = bounds(&moved, &fixed, &surface());
    assert!(early.ended_early && !early.is_within_gap && early.samples < 100, "{early:?}");
    assert!(early.lower <= whole.upper && whole.lower <= early.upper, "{early:?}, {whole:?}");
}

/// The target: two spheres with 100k triangles each. Prints the time; the gap alone is asserted.
#[test]
fn a_hundred_thousand_triangles_reach_a_small_gap() {
    let rings = if cfg!(debug_assertions) { 60 } else { 160 };
    let from = sphere(0.5, rings, Vector::new(0.01, 0.003, 0.0));
    let to = sphere(0.5, rings + 1, Vector::zeros());
    let (coarse, offset) =
        (sphere(0.5, rings / 8, Vector::zeros()), sphere(0.505, rings + 1, Vector::zeros()));
    for (what, a, b) in [("moved", &from, &to), ("coarse", &from, &coarse), ("offset", &from, &offset)] {
        for (from, to) in [(a, b), (b, a)] {
            let start = std::time::Instant::now();
            let found = bounds(from, to, &surface());
            println!("{what}, {rings} rings: {found:?} in {:?}", start.elapsed());
        }
    }
}
