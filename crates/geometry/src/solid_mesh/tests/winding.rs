//! Tests of winding numbers: the hierarchy against the sum of the solid angles of all triangles.

use super::super::closed_surface::ClosedSurface;
use super::super::far_field::{FarField, SolidAngle};
use super::super::inside_work::InsideWork;
use super::super::moments::Moments;
use super::super::winding_tree::half_solid_angle;
use super::draft::{Draft, bicone, random_shell};
use crate::math::{Point, Vector};
use crate::testing::Random;
use crate::{InsideGrid, InsideTest};

/// Signed solid angles of all faces, by brute force: their sum, and the sum of their absolute values.
fn solid_angle(draft: &Draft, p: &Point) -> [f64; 2] {
    let angles = draft.faces.iter().map(|face| 2.0 * half_solid_angle(&draft.vertices, face, p));
    angles.fold([0.0; 2], |[sum, magnitude], angle| [sum + angle, magnitude + angle.abs()])
}

/// Faces between random points of a box with these edges (m) around a centre.
fn random_faces(random: &mut Random, edges: Vector, centre: Vector) -> Draft {
    let count = 1 + random.below(30);
    let vertices = (0..3 * count).map(|_| Point::from(centre + random.vector(1.0).component_mul(&edges)));
    Draft {
        vertices: vertices.collect(),
        faces: (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    }
}

/// Also of slivers, flat sets and sets far from the origin. Open sets show any difference.
#[test]
fn a_far_field_is_within_its_bound_and_the_bound_is_tight() {
    let mut random = Random::new(1);
    let mut largest: f64 = 0.0;
    for round in 0..4000 {
        let edges = match random.below(4) {
            0 => Vector::new(1.0, 1e-7, 1e-9),
            1 => Vector::new(1.0, 1.0, 1e-9),
            2 => Vector::new(1e-3, 1e-3, 1e-3),
            _ => Vector::new(1.0, 0.5, 0.7),
        };
        let away = [0.0, 1.0, 1e6][random.below(3)];
        let centre = random.vector(away);
        let draft = random_faces(&mut random, edges, centre);
        let corners = draft.faces.iter().map(|face| face.map(|v| draft.vertices[v as usize]));
        let moments = Moments::joined(corners.clone().map(Moments::of_triangle)).unwrap();
        let from_centre = corners.flatten().map(|p| nalgebra::distance(&p, &moments.centre));
        let field = FarField::new(&moments, from_centre.fold(0.0, f64::max));
        for _ in 0..20 {
            let p = Point::from(
                centre + random.direction().into_inner() * edges.x * 20.0_f64.powf(random.within(1.0)),
            );
            let mut far = SolidAngle::default();
            if !field.add_to(&mut far, &p, 1.0) {
                continue;
            }
            let [expected, magnitude] = solid_angle(&draft, &p);
            let off = (far.value - expected).abs();
            // at a distance from the origin the points are rounded for both alike
            assert!(off <= far.error(draft.faces.len()), "round {round}: {off} {far:?}");
            assert!(magnitude <= 9.0 * far.magnitude, "round {round}: {magnitude} {far:?}");
            if far.truncation > 1e-6 {
                largest = largest.max(off / far.truncation);
            }
        }
    }
    assert!((0.1..=1.0).contains(&largest), "{largest}");
}

/// A point for which the decision may be hard: near a corner, an edge or a face, on it, or anywhere.
fn probe(draft: &Draft, random: &mut Random) -> Point {
    let face = draft.faces[random.below(draft.faces.len())].map(|v| draft.vertices[v as usize]);
    let extent = [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 0.1][random.below(7)];
    let off = random.vector(extent);
    match random.below(6) {
        0 => face[0] + off,
        1 => nalgebra::center(&face[0], &face[1]) + off,
        2 => Point::from((face[0].coords + face[1].coords + face[2].coords) / 3.0) + off,
        3 => Point::from(random.vector(1.5)),
        _ => {
            let other = draft.vertices[random.below(draft.vertices.len())];
            nalgebra::center(&face[0], &other) + off
        }
    }
}

/// Meshes that are hard for a hierarchy.
fn nasty_mesh(random: &mut Random) -> Draft {
    let shells: Vec<Draft> = (0..=random.below(3)).map(|_| random_shell(random)).collect();
    let draft = shells.iter().fold(Draft::default(), Draft::and);
    match random.below(8) {
        // shells there twice, in one winding or in both
        0 => draft.clone().and(&draft),
        1 => draft.clone().and(&draft.inward()),
        // all faces are slivers that meet in two points
        2 => bicone(3 + random.below(400) as u32, 0.5),
        3 => {
            let mut flat = draft;
            flat.vertices.iter_mut().for_each(|p| p.z *= 1e-9);
            flat
        }
        // crumpled: faces through each other
        4 => {
            let mut crumpled = draft;
            crumpled.vertices.iter_mut().for_each(|p| *p += random.vector(0.5));
            crumpled
        }
        5 => draft.unwelded(),
        6 => {
            let mut open = draft;
            open.faces.swap_remove(random.below(open.faces.len()));
            open
        }
        _ => draft,
    }
}

/// The decision is that of the sum over all triangles, on the surface as well, and where rounding decides.
#[test]
fn the_hierarchy_decides_as_all_triangles_do() {
    let mut random = Random::new(7);
    let (mut inside, mut on_surface) = (0, 0);
    for round in 0..600 {
        let draft = nasty_mesh(&mut random);
        let distant = Vector::repeat([0.0, 0.0, 0.0, 1e3, 1e7][random.below(5)]);
        let placed = draft.clone().shifted(distant.into());
        let surface = ClosedSurface::around(&placed.vertices, placed.faces.clone());
        for _ in 0..100 {
            let p = probe(&draft, &mut random) + distant;
            let sum = surface.sum_of_angles(&placed.vertices, &p, &mut InsideWork::default());
            let in_bounds = (0..3).all(|i| (surface.bounds()[0][i]..=surface.bounds()[1][i]).contains(&p[i]));
            let expected = in_bounds && sum.abs() > 0.5;
            let found = surface.winds_around(&placed.vertices, &p, &mut InsideWork::default());
            assert_eq!(found, expected, "round {round}: {p}: {sum}");
            inside += usize::from(expected);
            on_surface += usize::from((sum - sum.round()).abs() > 1e-3);
        }
    }
    assert!(inside > 10_000 && on_surface > 2000, "{inside} {on_surface}");
}

#[test]
fn winding_numbers_of_several_layers_are_whole() {
    let mut random = Random::new(8);
    for _ in 0..100 {
        let layers: Vec<Draft> = (0..=random.below(5)).map(|_| random_shell(&mut random)).collect();
        let draft = layers.iter().fold(Draft::default(), |all, layer| {
            all.and(&if random.below(3) == 0 { layer.clone().inward() } else { layer.clone() })
        });
        let surface = ClosedSurface::around(&draft.vertices, draft.faces.clone());
        for _ in 0..40 {
            let p = Point::from(random.vector(1.0));
            let expected = surface.sum_of_angles(&draft.vertices, &p, &mut InsideWork::default());
            if (expected - expected.round()).abs() < 1e-6 {
                let in_bounds = surface.winding_number(&draft.vertices, &p);
                assert_eq!(in_bounds, expected.round(), "{p}");
            }
        }
    }
}

/// A closed surface like a crumpled ball, of 98,304 triangles.
fn large_mesh() -> Draft {
    let mut ball = Draft::cube(1.0).divided(6).divided(0);
    let bumps = |p: &Vector| 1.0 + 0.2 * (9.0 * p.x).sin() * (7.0 * p.y).cos() * (8.0 * p.z).sin();
    for p in &mut ball.vertices {
        let out = p.coords.normalize();
        *p = Point::from(out * bumps(&out));
    }
    ball.clone().and(&ball.moved(&Random::new(2).pose(0.0)))
}

#[test]
fn a_large_mesh_costs_a_small_part_of_its_faces_and_is_decided_alike() {
    let draft = large_mesh();
    assert_eq!(draft.faces.len(), 98_304);
    let surface = ClosedSurface::around(&draft.vertices, draft.faces.clone());
    let mut random = Random::new(3);
    let (mut work, mut inside) = (InsideWork::default(), 0);
    for round in 0..60 {
        let p = if round % 2 == 0 { Point::from(random.vector(1.1)) } else { probe(&draft, &mut random) };
        let sum = surface.sum_of_angles(&draft.vertices, &p, &mut InsideWork::default());
        let clear_of_surface = (sum - sum.round()).abs() < 1e-6;
        let counted = if clear_of_surface { &mut work } else { &mut InsideWork::default() };
        let found = surface.winds_around(&draft.vertices, &p, counted);
        let [low, high] = surface.bounds();
        let in_bounds = (0..3).all(|i| (low[i]..=high[i]).contains(&p[i]));
        assert_eq!(found, in_bounds && sum.abs() > 0.5, "{p}: {sum}");
        inside += usize::from(found);
    }
    assert!(inside > 10 && work.visited < 60 * 2000, "{inside} {work:?}");
}

/// Cells of the octree agree with winding numbers, and the boxes around the inside leave out nothing of it.
#[test]
fn cells_inside_and_outside_are_what_they_say() {
    let mut random = Random::new(5);
    let (mut known, mut unknown, mut inside, mut left_out) = (0, 0, 0, 0);
    for round in 0..200 {
        let mesh = nasty_mesh(&mut random).mesh();
        let solid = mesh.solid();
        let grid = mesh.inside_grid();
        for _ in 0..60 {
            let p = Point::from(random.vector(0.8));
            let work = &mut InsideWork::default();
            let expected = solid.winds_around(mesh.vertices(), &p, work);
            let found = solid.known(mesh.vertices(), &p, work);
            assert!(found.is_none_or(|found| found == expected), "round {round}: {p}");
            assert_eq!(mesh.encloses(&p), expected);
            *(if found.is_some() { &mut known } else { &mut unknown }) += 1;
            let in_grid = grid.is_some_and(|grid| {
                let cell = (p - grid.bounds()[0]).component_mul(&grid.cells_per_metre());
                let error = random.vector(f64::from(InsideGrid::MARGIN));
                grid.may_contain((cell + error).map(|c| c as f32).into())
            });
            assert!(in_grid || !expected, "round {round}: {p}");
            left_out += usize::from(!in_grid);
            inside += usize::from(expected);
        }
    }
    assert!(known > unknown && unknown > 500 && inside > 1000, "{known} {unknown} {inside}");
    assert!(left_out > 3000, "{left_out}");
}

/// Most points near a large mesh need no winding number.
#[test]
fn winding_numbers_are_for_points_next_to_the_surface() {
    let mesh = large_mesh().mesh();
    mesh.prepare_solid();
    let mut test = InsideTest::new(&mesh);
    let mut random = Random::new(6);
    let inside = (0..2000).filter(|_| test.encloses(&Point::from(random.vector(1.3)))).count();
    let work = test.take_work();
    assert!(inside > 300 && work.winding_numbers < 600, "{inside} {work:?}");
}
