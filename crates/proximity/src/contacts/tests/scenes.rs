//! Tests of contacts in simple scenes: corners of boxes, feet of tables, patches.

use clearance_geometry::Plane;

use super::*;

/// Floors with their top at height 0.
fn floors() -> Vec<(&'static str, Body)> {
    // a mesh with a dent far away is not convex
    let slab = ([0.0, 0.0, -0.5], [2.0, 2.0, 0.5]);
    let dented = box_meshes(&[slab, ([0.0, 0.0, -3.0], [0.1; 3])]);
    let place = Pose::translation(0.0, 0.0, -0.5);
    vec![
        ("box", Body::new(vec![(place, cuboid([2.0, 2.0, 0.5]))])),
        ("convex mesh", Body::of(box_meshes(&[slab]))),
        ("mesh", Body::of(dented)),
        ("plane", Body::of(Shape::Plane(Plane { normal: Vector::z_axis(), offset: 0.0 }))),
        ("fine mesh", Body::of(fine_floor(40))),
    ]
}

/// A floor of many triangles.
fn fine_floor(count: u32) -> Shape {
    let width = f64::from(count);
    let mut vertices: Vec<Point> = (0..=count)
        .flat_map(|i| (0..=count).map(move |j| (f64::from(i), f64::from(j))))
        .map(|(x, y)| Point::new(2.0 * x / width - 1.0, 2.0 * y / width - 1.0, 0.0))
        .collect();
    let below = u32::try_from(vertices.len()).unwrap();
    vertices.push(Point::new(0.0, 0.0, -1.0));
    let number = |i: u32, j: u32| i * (count + 1) + j;
    let mut faces: Vec<[u32; 3]> = (0..count)
        .flat_map(|i| (0..count).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    for i in 0..count {
        faces.push([number(i + 1, 0), number(i, 0), below]);
        faces.push([number(i, count), number(i + 1, count), below]);
        faces.push([number(0, i), number(0, i + 1), below]);
        faces.push([number(count, i + 1), number(count, i), below]);
    }
    mesh(vertices, faces)
}

fn has_contact_at(found: &[ContactPoint], x: f64, y: f64, reach: f64) -> bool {
    found.iter().any(|contact| (contact.position - Point::new(x, y, contact.position.z)).norm() <= reach)
}

/// A box flat on a box touches it at its four corners.
#[test]
fn a_box_flat_on_a_floor_has_its_four_corners() {
    let mut scratch = Scratch::default();
    let boxes = [
        ("box", cuboid([0.2, 0.1, 0.05])),
        ("convex mesh", box_meshes(&[([0.0; 3], [0.2, 0.1, 0.05])])),
        ("mesh", box_meshes(&[([0.0; 3], [0.2, 0.1, 0.05]), ([0.0, 0.0, 1.0], [0.1; 3])])),
    ];
    for (of_floor, floor) in floors() {
        for (of_box, shape) in &boxes {
            let depth = 0.001;
            let turn = Pose::from_parts(
                Vector::new(0.313, 0.217, 0.05 - depth).into(),
                clearance_geometry::math::Rotation::from_axis_angle(&Vector::z_axis(), 0.3),
            );
            let body = Body::of(shape.clone());
            let (deepest, found) = contacts(&floor, &body, &turn, 0.0, 5, &mut scratch).unwrap();
            let name = format!("{of_box} on {of_floor}: {deepest:?} {found:?}");
            for corner in [[0.2, 0.1], [-0.2, 0.1], [0.2, -0.1], [-0.2, -0.1]] {
                let at = turn * Point::new(corner[0], corner[1], 0.0);
                let is_first = (deepest.position - Point::new(at.x, at.y, deepest.position.z)).norm() < 1e-6;
                assert!(is_first || has_contact_at(&found, at.x, at.y, 1e-6), "{name}");
            }
            for contact in &found {
                assert!((contact.normal - Vector::z()).norm() < 1e-6, "{name}");
                assert!((contact.depth.unwrap() - depth).abs() < 1e-6, "{name}");
            }
        }
    }
}

/// Four contacts of a table are on its four feet, whatever it and the floor are made of; the fifth is on one of them again.
#[test]
fn a_table_stands_on_its_four_feet() {
    let mut scratch = Scratch::default();
    let of_boxes: Vec<(Pose, Shape)> = table_boxes()
        .iter()
        .map(|([x, y, z], half)| (Pose::translation(*x, *y, *z), cuboid(*half)))
        .collect();
    let round: Vec<(Pose, Shape)> = table_boxes()
        .iter()
        .map(|([x, y, z], half)| {
            let leg = Primitive::Cylinder { radius: half[0], half_length: half[2] };
            (Pose::translation(*x, *y, *z), Shape::Primitive(leg))
        })
        .collect();
    let tables = [
        ("boxes", Body::new(of_boxes)),
        ("mesh", Body::of(box_meshes(&table_boxes()))),
        ("cylinders", Body::new(round)),
    ];
    for (of_floor, floor) in floors() {
        for (of_table, table) in &tables {
            for (margin, height) in [(0.0, 0.3999), (0.005, 0.402), (0.005, 0.3999)] {
                let pose = Pose::translation(0.1, 0.1, height);
                let (deepest, found) = contacts(&floor, table, &pose, margin, 3, &mut scratch).unwrap();
                let name = format!("{of_table} on {of_floor} at {height}: {deepest:?} {found:?}");
                let all: Vec<Point> =
                    found.iter().map(|contact| contact.position).chain([deepest.position]).collect();
                for leg in &table_boxes()[1..] {
                    let [x, y, _] = leg.0;
                    let is_foot = |p: &&Point| (p.x - 0.1 - x).abs() < 0.04 && (p.y - 0.1 - y).abs() < 0.04;
                    assert_eq!(all.iter().filter(is_foot).count(), 1, "{name}");
                }
                for contact in &found {
                    assert!((contact.normal - Vector::z()).norm() < 1e-6, "{name}");
                    assert!((contact.depth.unwrap() - (margin + 0.4 - height)).abs() < 1e-6, "{name}");
                }
            }
        }
    }
}

/// A foot that is a ring has one patch, and all normals point up; a rod through a plate comes out at both sides.
#[test]
fn rings_and_rods_have_normals_across_the_surface() {
    let mut scratch = Scratch::default();
    // a pipe that stands upright
    let pipe = shapes::closed_grid(24, 4, |u, v| {
        let corner = [1.0, 2.5, 4.0].iter().filter(|between| v > **between).count();
        let (radius, z) = [(0.2, 0.3), (0.1, 0.3), (0.1, -0.3), (0.2, -0.3)][corner];
        Point::new(radius * u.cos(), radius * u.sin(), z)
    });
    let dented = Body::of(box_meshes(&[([0.0, 0.0, -0.5], [2.0, 2.0, 0.5]), ([0.0, 0.0, -3.0], [0.1; 3])]));
    let (deepest, found) =
        contacts(&dented, &Body::of(pipe), &Pose::translation(0.03, 0.02, 0.299), 0.0, 12, &mut scratch)
            .unwrap();
    for contact in &found {
        assert!(contact.normal.z > 0.9999, "{contact:?} {deepest:?}");
        assert!((contact.depth.unwrap() - 0.001).abs() < 1e-6, "{contact:?}");
    }
    let plate = Body::of(box_meshes(&[([0.0; 3], [0.5, 0.5, 0.01]), ([0.0, 0.0, -3.0], [0.1; 3])]));
    let rod = Body::of(box_meshes(&[([0.0; 3], [0.02, 0.02, 0.5]), ([0.0, 0.0, 3.0], [0.1; 3])]));
    let (_, found) =
        contacts(&plate, &rod, &Pose::translation(0.1, 0.0, 0.1), 0.0, 12, &mut scratch).unwrap();
    let count = |sign: f64| found.iter().filter(|contact| contact.normal.z * sign > 0.999).count();
    assert!(count(1.0) >= 1 && count(-1.0) >= 1, "{found:?}");
    for contact in &found {
        let expected = if contact.normal.z > 0.0 { 0.41 } else { 0.61 };
        assert!((contact.depth.unwrap() - expected).abs() < 1e-6, "{contact:?}");
    }
}

/// Two round bumps in a dented floor are two patches; each is found, at its deepest point.
#[test]
fn every_patch_of_round_meshes_is_found_at_its_deepest_point() {
    let mut scratch = Scratch::default();
    let [first, second] = [-0.4, 0.4].map(|x| (Pose::translation(x, 0.0, 0.0), sphere_mesh(16, 0.1)));
    let dumbbell = Body::new(vec![first, second]);
    let dented = Body::of(box_meshes(&[([0.0, 0.0, -0.5], [2.0, 2.0, 0.5]), ([0.0, 0.0, -3.0], [0.1; 3])]));
    // the second ball is half as deep as the first
    let tilt =
        clearance_geometry::math::Rotation::from_axis_angle(&Vector::y_axis(), -(0.004_f64 / 0.8).asin());
    let pose = Pose::from_parts(Vector::new(0.0, 0.0, 0.1 - 0.006).into(), tilt);
    let (deepest, found) = contacts(&dented, &dumbbell, &pose, 0.0, 1, &mut scratch).unwrap();
    assert!(deepest.position.x < -0.35, "{deepest:?}");
    assert!(found[0].position.x > 0.35 && (found[0].normal - Vector::z()).norm() < 1e-6, "{found:?}");
    assert!((found[0].depth.unwrap() - 0.004).abs() < 1e-3, "{found:?}");
}

/// A ball in a groove touches both sides, each with its own normal.
#[test]
fn a_ball_in_a_groove_has_a_contact_on_each_side() {
    let mut scratch = Scratch::default();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let wall = |side: f64| {
        let turn = clearance_geometry::math::Rotation::from_axis_angle(
            &Vector::y_axis(),
            side * std::f64::consts::FRAC_PI_4,
        );
        let n = Vector::new(side * half, 0.0, half);
        (Pose::from_parts((n * -0.1).into(), turn), n)
    };
    for is_mesh in [false, true] {
        let slab = if is_mesh { box_meshes(&[([0.0; 3], [1.0, 1.0, 0.1])]) } else { cuboid([1.0, 1.0, 0.1]) };
        let groove = Body::new(vec![(wall(1.0).0, slab.clone()), (wall(-1.0).0, slab)]);
        let pose = Pose::translation(0.0, 0.3, (0.2 - 1e-4) / half);
        let (_, found) = contacts(&groove, &Body::of(ball(0.2)), &pose, 0.0, 4, &mut scratch).unwrap();
        for side in [1.0, -1.0] {
            let (_, n) = wall(side);
            let is_there = found.iter().any(|contact| {
                (contact.normal - n).norm() < 1e-6 && (contact.depth.unwrap() - 1e-4).abs() < 1e-7
            });
            assert!(is_there, "{is_mesh} {side}: {found:?}");
        }
    }
}
