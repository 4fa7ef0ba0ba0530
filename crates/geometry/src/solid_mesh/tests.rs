//! Tests of solid meshes: damaged meshes enclose the same points as the original shapes, and the damage is reported.

#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation)] // small numbers

mod draft;
mod winding;

use crate::InsideTest;
use crate::math::{Point, Vector};
use crate::testing::Random;
use draft::{Draft, bicone, random_shell, winding};

const CENTRE: [f64; 3] = [0.01, 0.02, 0.03];

#[test]
fn a_cube_with_faces_in_both_windings_is_solid_and_that_is_reported() {
    let cube = Draft::cube(0.5);
    for double in
        [cube.clone().and(&cube.clone().inward()), cube.unwelded().and(&cube.clone().inward().unwelded())]
    {
        assert!(double.encloses(CENTRE) && !double.encloses([0.6, 0.0, 0.0]));
        assert_eq!(double.remarks(), "12 of 24 faces are there in both windings: each counts once");
    }
    // only some faces twice, and one three times
    let mut some = cube.clone();
    some.faces.extend([[0, 2, 3], [0, 3, 2], [4, 7, 5]]);
    assert!(some.encloses(CENTRE));
    assert!(some.remarks().starts_with("2 of 15 faces are there in both windings"), "{}", some.remarks());
}

#[test]
fn the_other_side_may_have_other_triangles() {
    let cube = Draft::cube(0.5);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut double = cube.clone();
    double.faces.extend(quads.iter().flat_map(|[a, b, c, d]| [[*a, *d, *b], [*b, *d, *c]]));
    assert!(double.encloses(CENTRE) && !double.encloses([0.6, 0.0, 0.0]));
    // or with different rounding
    let mut noisy = cube.clone().inward();
    noisy.vertices.iter_mut().for_each(|p| *p *= 1.0 - 1e-7);
    let noisy = cube.and(&noisy);
    assert!(noisy.encloses(CENTRE));
    assert_eq!(
        noisy.remarks(),
        "1 of 2 closed shells are wound the other way and are no cavities: they are solid, too"
    );
}

#[test]
fn flipped_faces_of_a_watertight_mesh_are_counted() {
    let mut ball = Draft::ball(0.5);
    for face in [3, 50, 51, 52, 120] {
        ball.faces[face].swap(0, 1);
    }
    assert!(ball.encloses(CENTRE));
    assert_eq!(ball.remarks(), "5 of 192 faces are wound the other way: they were turned over");
    // all of them: the intended solid is clear
    let inside_out = Draft::ball(0.5).inward();
    assert!(inside_out.encloses(CENTRE));
    assert_eq!(inside_out.remarks(), "");
}

#[test]
fn shells_that_overlap_are_solid_however_they_are_wound() {
    let other = Draft::cube(0.5).shifted([0.5, 0.1, 0.2]);
    for (other, said) in [(other.clone(), false), (other.inward(), true)] {
        let both = Draft::cube(0.5).and(&other);
        for p in [[-0.3, 0.0, 0.0], [0.3, 0.1, 0.1], [0.8, 0.1, 0.1]] {
            assert!(both.encloses(p), "{p:?}");
        }
        assert_eq!(both.remarks().contains("1 of 2 closed shells"), said, "{}", both.remarks());
    }
}

#[test]
fn shells_that_share_a_wall_an_edge_or_a_corner_are_solid_however_they_are_wound() {
    for offset in [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.5, 0.5, 0.0]] {
        let other = Draft::cube(0.5).shifted(offset);
        for other in [other.clone(), other.inward()] {
            let both = Draft::cube(0.5).and(&other);
            let inside = offset.map(|c| c + 0.01);
            assert!(both.encloses(CENTRE) && both.encloses(inside), "{offset:?}");
            assert!(
                !both.encloses([-0.6, 0.0, 0.0]) && !both.mesh().solid().remarks().is_open(),
                "{offset:?}"
            );
        }
    }
    // one wall for both rooms
    let mut rooms = Draft::cube(0.5).and(&Draft::cube(0.5).shifted([1.0, 0.0, 0.0]));
    rooms.faces.truncate(20);
    assert!(rooms.encloses(CENTRE));
    let wall = |f: &[u32; 3]| f.iter().all(|v| [1, 3, 5, 7].contains(v));
    assert_eq!(rooms.faces.iter().filter(|f| wall(f)).count(), 2);
    let mut rooms = Draft::cube(0.5).and(&Draft::cube(0.5).shifted([1.0, 0.0, 0.0]));
    rooms.faces.retain(|f| !f.iter().all(|v| [1, 3, 5, 7].contains(v)));
    assert!(rooms.encloses(CENTRE) && rooms.encloses([1.01, 0.02, 0.03]), "{}", rooms.remarks());
    assert_eq!(rooms.remarks(), "");
}

#[test]
fn only_a_shell_wholly_inside_and_wound_inward_is_a_cavity() {
    let hollow = Draft::ball(1.0).and(&Draft::ball(0.5).inward());
    assert!(!hollow.encloses(CENTRE) && hollow.encloses([0.7, 0.0, 0.0]));
    assert_eq!(hollow.remarks(), "1 of 2 closed shells are cavities: what is in there touches nothing");
    let inside_out = hollow.clone().inward();
    assert!(!inside_out.encloses(CENTRE) && inside_out.encloses([0.7, 0.0, 0.0]));
    let filled = hollow.clone().and(&Draft::ball(0.2));
    assert!(filled.encloses(CENTRE) && !filled.encloses([0.3, 0.0, 0.0]));

    let nested = Draft::ball(1.0).and(&Draft::ball(0.5));
    assert!(nested.encloses(CENTRE) && nested.remarks().is_empty());
    let twice = hollow.clone().and(&Draft::ball(0.5).inward());
    let across = Draft::ball(1.0).and(&Draft::ball(0.5).shifted([0.7, 0.0, 0.0]).inward());
    let touching = Draft::cube(1.0).and(&Draft::cuboid([-1.0, -0.5, -0.5], [0.5; 3]).inward());
    let mut flipped = hollow.clone();
    flipped.faces[7].swap(0, 1);
    for draft in [twice, across.clone().shifted([-0.7, 0.0, 0.0]), touching, flipped, across] {
        let p = if draft.encloses(CENTRE) { CENTRE } else { [0.7, 0.0, 0.0] };
        assert!(draft.encloses(p) && !draft.remarks().is_empty(), "{}", draft.remarks());
        assert!(!draft.remarks().contains("are cavities"), "{}", draft.remarks());
    }
}

/// The search for contact is limited by a number of steps, not by time.
#[test]
fn shells_of_slivers_too_close_to_compare_are_solid_and_that_is_reported() {
    let few = bicone(12, 1.0).and(&bicone(12, 0.5).inward());
    assert!(!few.encloses(CENTRE) && few.encloses([0.0, 0.0, 0.7]) && few.remarks().contains("are cavities"));
    let many = bicone(2000, 1.0).and(&bicone(2000, 0.999).inward());
    assert!(many.encloses(CENTRE));
    assert_eq!(
        many.remarks(),
        "1 of 2 closed shells are wound the other way and are no cavities: they are solid, too"
    );
    // but meshes without slivers are compared, also where the wall is thinner than the edges are long
    let fine = |radius: f64| {
        let mut ball = Draft::cube(1.0).divided(4);
        ball.vertices.iter_mut().for_each(|p| *p = Point::from(p.coords.normalize() * radius));
        ball
    };
    let hollow = fine(1.0).and(&fine(0.97).moved(&Random::new(3).pose(0.0)).inward());
    assert!(!hollow.encloses(CENTRE) && hollow.remarks().contains("are cavities"), "{}", hollow.remarks());
}

/// Points tested in sequence, in any order, give the same results as each by itself; clusters cost almost nothing.
#[test]
fn points_that_share_an_answer_have_that_answer() {
    let mut random = Random::new(11);
    let mut inside = 0;
    for round in 0..200 {
        let shells: Vec<Draft> = (0..=random.below(3)).map(|_| random_shell(&mut random)).collect();
        let mut draft = shells.iter().fold(Draft::default(), Draft::and);
        spoil(&mut draft, &mut random);
        let mesh = draft.mesh();
        let mut test = InsideTest::new(&mesh);
        let mut at = Vector::zeros();
        for _ in 0..100 {
            at = if random.below(10) == 0 { random.vector(1.0) } else { at + random.vector(0.05) };
            let p = Point::from(at);
            assert_eq!(test.encloses(&p), mesh.encloses(&p), "round {round}: {p}");
            inside += usize::from(mesh.encloses(&p));
        }
    }
    assert!(inside > 1000, "{inside}");
    let fine = Draft::cube(0.5).divided(5).mesh();
    let mut test = InsideTest::new(&fine);
    assert!((0..1000).all(|_| test.encloses(&Point::from(random.vector(0.4)))));
    assert!(test.take_work().visited < 50_000);
}

#[test]
fn what_is_open_is_a_surface_and_that_is_reported() {
    let mut lid_off = Draft::cube(0.5);
    lid_off.faces.pop();
    assert!(!lid_off.encloses(CENTRE));
    assert!(lid_off.remarks().starts_with("not closed"), "{}", lid_off.remarks());
    let double = lid_off.clone().and(&lid_off.clone().inward());
    assert!(double.remarks().starts_with("not closed"), "{}", double.remarks());

    let beside = Draft::ball(0.3).and(&lid_off.shifted([2.0, 0.0, 0.0]));
    assert!(beside.encloses(CENTRE));
    assert!(beside.remarks().starts_with("not closed: 11 of 203 faces"), "{}", beside.remarks());
    // a fin on an edge
    let mut fin = Draft::cube(0.5);
    fin.vertices.push(Point::new(1.0, 1.0, 1.0));
    fin.faces.push([3, 7, 8]);
    assert!(fin.encloses(CENTRE));
    assert!(fin.remarks().starts_with("not closed: 1 of 13 faces"), "{}", fin.remarks());

    // an edge against two halves of it
    let mut junction = Draft::cube(0.5);
    junction.vertices.push(Point::new(-0.5, 0.0, -0.5));
    let split = junction.faces.iter().position(|f| f.contains(&0) && f.contains(&2)).unwrap();
    let [a, b, c] = junction.faces[split];
    let apex = [a, b, c].into_iter().find(|v| ![0, 2].contains(v)).unwrap();
    junction.faces[split] = [0, 8, apex];
    junction.faces.push([8, 2, apex]);
    assert!(junction.remarks().starts_with("not closed"), "{}", junction.remarks());
    let mut gap = Draft::cube(0.5).unwelded();
    gap.vertices[0].x += 1e-7;
    assert!(gap.remarks().starts_with("not closed"), "{}", gap.remarks());
}

#[test]
fn a_mesh_that_is_too_tangled_is_reported() {
    // random points joined by all faces between some of them
    let mut random = Random::new(5);
    let vertices = (0..40).map(|_| Point::from(random.vector(1.0))).collect();
    let mut tangle = Draft { vertices, faces: Vec::new() };
    for a in 0..40 {
        for b in 0..a {
            tangle.faces.extend((0..b).map(|c| [a, b, c]));
        }
    }
    let words = "too tangled to find what it encloses (too many faces meet at its edges)";
    assert!(tangle.remarks().starts_with(&format!("{words}, so it stays a surface")), "{}", tangle.remarks());
    let beside = tangle.and(&Draft::cube(0.5).shifted([5.0, 0.0, 0.0]));
    assert!(beside.encloses([5.01, 0.02, 0.03]));
    assert!(beside.remarks().starts_with(&format!("{words}: 9880 of 9892 faces")), "{}", beside.remarks());
}

/// After any modification, a union of closed shells encloses at least the original shells, unless a part is reported as open.
#[test]
fn spoiled_meshes_enclose_what_their_shells_do() {
    let mut random = Random::new(2026);
    let (mut inside, mut open) = (0, 0);
    for round in 0..400 {
        let shells: Vec<Draft> = (0..=random.below(3)).map(|_| random_shell(&mut random)).collect();
        let mut spoiled = shells.iter().fold(Draft::default(), |all, shell| {
            all.and(&if random.below(3) == 0 { shell.clone().inward() } else { shell.clone() })
        });
        let closed = spoil(&mut spoiled, &mut random);
        let mesh = spoiled.mesh();
        let remarks = mesh.solid().remarks();
        assert!(!closed || !remarks.is_open(), "round {round}: {remarks}");
        open += usize::from(remarks.is_open());
        for _ in 0..40 {
            let p = Point::from(random.vector(1.2));
            let around: Vec<f64> = shells.iter().map(|shell| winding(shell, &p)).collect();
            if around.iter().any(|w| (w - w.round()).abs() > 1e-6) {
                continue;
            }
            let is_inside = around.iter().any(|w| w.abs() > 0.5);
            let (found, cavity) = (mesh.encloses(&p), remarks.to_string().contains("cavities: what"));
            // by the present winding of the faces: one of several interpretations
            let as_wound = winding(&spoiled, &p).abs() > 0.5 && closed && remarks.is_empty();
            assert!(found || !as_wound, "round {round}: {p}");
            assert!(
                found == is_inside || remarks.is_open() || cavity && !found,
                "round {round}: {p}: {remarks}"
            );
            assert!(!found || is_inside, "round {round}: {p} is outside of all");
            inside += usize::from(found);
        }
    }
    assert!(inside > 700 && (50..350).contains(&open), "{inside} {open}");
}

/// Modifies a mesh; returns true if it is as closed as before.
fn spoil(draft: &mut Draft, random: &mut Random) -> bool {
    let mut closed = true;
    for _ in 0..random.below(4) {
        let face = random.below(draft.faces.len());
        match random.below(8) {
            0 => draft.faces.push(draft.faces[face]),
            1 => {
                for _ in 0..=random.below(9) {
                    let face = random.below(draft.faces.len());
                    draft.faces[face].swap(0, 1);
                }
            }
            2 => *draft = draft.clone().and(&draft.clone().inward()),
            3 => *draft = draft.unwelded(),
            4 => {
                let [a, b, c] = draft.faces[face];
                draft.faces.push([b, a, c]);
            }
            5 => draft.faces.push([draft.faces[face][0]; 3]),
            6 => {
                draft.faces.swap_remove(face);
                closed = false;
            }
            _ => {
                let [a, b, _] = draft.faces[face];
                draft.vertices.push(Point::from(random.vector(1.0)));
                draft.faces.push([a, b, draft.vertices.len() as u32 - 1]);
                closed = false;
            }
        }
    }
    closed
}
