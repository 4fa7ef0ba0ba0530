//! Tests of contact points: positions, normals, depths, swapped bodies, and bounded work on huge meshes.

mod scenes;
mod shapes;

use std::sync::Arc;

use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose, Vector};
use clearance_geometry::testing::Random;
use clearance_geometry::{Cube, PointCloud, Primitive, Shape, Voxels};

use super::*;
use crate::{PenetrationDepth, penetration_depth};
use shapes::{Body, ball, box_meshes, cuboid, mesh, sphere_mesh, table_boxes, torus};

/// The deepest contact, as the collision checker computes it, and others; `None` if the bodies are apart.
fn contacts(
    a: &Body,
    b: &Body,
    pose: &Pose,
    margin: f64,
    most: usize,
    scratch: &mut Scratch,
) -> Option<(Deepest, Vec<ContactPoint>)> {
    let pose_ab = &MatrixPose::from(pose);
    let bodies = BodyPair { a: &a.hollow, b: &b.hollow, pose_ab };
    let apart = crate::distance(&a.hollow, &b.hollow, pose_ab, margin.greater(CONTACT_DISTANCE), scratch)?;
    let deepest = if apart.distance > 0.0 {
        let [p, q] = apart.witness_points;
        let normal = (q - p).try_normalize(CONTACT_DISTANCE);
        DeepestContact { witness_points: [p, q], normal, depth: margin - apart.distance }
    } else {
        let found = penetration_depth(&a.solid, &b.solid, pose_ab, margin, scratch)?;
        if found.upper.is_finite() {
            let PenetrationDepth { witness_points, direction, upper, .. } = found;
            DeepestContact { witness_points, normal: Some(direction), depth: upper }
        } else {
            DeepestContact { witness_points: apart.witness_points, normal: None, depth: 0.0 }
        }
    };
    let query = ContactQuery { bodies, solids: [&a.solid, &b.solid], margin, deepest };
    let ContactPoints { deepest: position, others } = contact_points(&query, most, scratch);
    Some((Deepest { position, contact: deepest }, others))
}

/// The deepest contact with its position.
#[derive(Clone, Copy, Debug)]
struct Deepest {
    position: Point,
    contact: DeepestContact,
}

fn bodies() -> Vec<Body> {
    let round = |primitive| Body::of(Shape::Primitive(primitive));
    let hammer = vec![
        (Pose::identity(), Shape::Primitive(Primitive::Capsule { radius: 0.08, half_length: 0.4 })),
        (Pose::translation(0.05, 0.0, 0.4), box_meshes(&[([0.0; 3], [0.3, 0.12, 0.1])])),
    ];
    let table: Vec<(Pose, Shape)> = table_boxes()
        .iter()
        .map(|([x, y, z], half)| (Pose::translation(*x, *y, *z), cuboid(*half)))
        .collect();
    vec![
        Body::of(torus(24, 12)),
        Body::of(box_meshes(&table_boxes())),
        Body::of(box_meshes(&[([0.0; 3], [0.2, 0.3, 0.4])])),
        Body::of(sphere_mesh(8, 0.4)),
        Body::new(hammer),
        Body::new(table),
        Body::of(cuboid([0.3, 0.2, 0.1])),
        round(Primitive::Cylinder { radius: 0.2, half_length: 0.3 }),
        round(Primitive::Cone { radius: 0.3, half_length: 0.3 }),
        round(Primitive::Capsule { radius: 0.1, half_length: 0.3 }),
    ]
}

/// Pairs of touching bodies at random poses, with their contacts.
fn for_touching_bodies(
    count: usize,
    (seed, margin): (u64, f64),
    mut check: impl FnMut(&Body, &Body, &Pose, &Deepest, &[ContactPoint]),
) {
    let (bodies, mut random, mut scratch) = (bodies(), Random::new(seed), Scratch::default());
    let mut left = count;
    while left > 0 {
        let [a, b] = [random.below(bodies.len()), random.below(bodies.len())].map(|i| &bodies[i]);
        let pose = Pose::from_parts(random.vector(0.7).into(), random.rotation());
        let Some((deepest, found)) = contacts(a, b, &pose, margin, 12, &mut scratch) else { continue };
        left -= 1;
        check(a, b, &pose, &deepest, &found);
    }
}

#[test]
fn positions_are_in_both_bodies_and_normals_have_length_one() {
    let mut number = 0;
    for_touching_bodies(400, (1, 0.0), |a, b, pose, deepest, found| {
        let own = pose.inverse_transform_point(&deepest.position);
        assert!(a.holds(&deepest.position, 1e-7) && b.holds(&own, 1e-7), "{a} {b} {deepest:?} {pose:?}");
        for contact in found {
            let own = pose.inverse_transform_point(&contact.position);
            assert!(a.holds(&contact.position, 1e-8), "{a} {b} {contact:?} {deepest:?} {pose:?}");
            assert!(b.holds(&own, 1e-8), "{a} {b} {contact:?} {deepest:?} {pose:?}");
            assert!((contact.normal.norm() - 1.0).abs() < 1e-9);
            assert!(contact.depth.is_none_or(|depth| (0.0..3.0).contains(&depth)), "{contact:?}");
        }
        number += found.len();
    });
    assert!(number > 1200, "{number}");
}

#[test]
fn positions_are_within_the_margin() {
    let margin = 0.03;
    for_touching_bodies(400, (2, margin), |a, b, pose, deepest, found| {
        for contact in found {
            let own = pose.inverse_transform_point(&contact.position);
            assert!(a.holds(&contact.position, margin), "{a} {b} {contact:?} {deepest:?} {pose:?}");
            assert!(b.holds(&own, margin), "{a} {b} {contact:?} {deepest:?} {pose:?}");
            assert!(contact.depth.is_none_or(|depth| depth >= 0.0));
        }
    });
}

/// Sampled along the normal, the first body ends above the position and the second below it, as far apart as the depth.
#[test]
fn depths_are_the_overlap_on_the_line_along_the_normal() {
    let mut measured = 0;
    let step = 1e-3;
    for_touching_bodies(400, (3, 0.0), |a, b, pose, _, found| {
        // depths are those of two shapes
        for ContactPoint { position, normal, depth } in
            found.iter().filter(|_| a.shapes.len() + b.shapes.len() == 2)
        {
            // on a wall along the normal, rounding decides what is inside: one of the lines beside it is
            let across = normal.cross(&Vector::ith(normal.iamin(), 1.0)).normalize();
            let beside = (0..8_u8)
                .map(|i| f64::from(i) * std::f64::consts::FRAC_PI_4)
                .map(|turn| (across * turn.cos() + normal.cross(&across) * turn.sin()) * 1e-6);
            let overlaps: Vec<f64> = beside
                .filter_map(|aside| {
                    let at = |t: f64| position + aside + normal * t;
                    let in_a = |t: f64| a.holds(&at(t), 0.0);
                    let in_b = |t: f64| b.holds(&pose.inverse_transform_point(&at(t)), 0.0);
                    let is_inside = [-step, 0.0, step].iter().all(|t| in_a(*t) && in_b(*t));
                    let length = |holds: &dyn Fn(f64) -> bool, along: f64| {
                        (1..4000).map(|i| f64::from(i) * step * along).find(|t| !holds(*t)).unwrap()
                    };
                    is_inside.then(|| length(&in_a, 1.0) - length(&in_b, -1.0))
                })
                .collect();
            let is_near = |overlap: &f64| (depth.unwrap() - overlap).abs() <= 2.0 * step;
            assert!(
                overlaps.is_empty() || overlaps.iter().any(is_near),
                "{a} {b} {depth:?} {overlaps:?} {position:?} {normal:?} {pose:?}"
            );
            measured += usize::from(!overlaps.is_empty());
        }
    });
    assert!(measured > 200, "{measured}");
}

/// Contacts of swapped bodies are at the same places, with opposite normals.
#[test]
fn swapped_bodies_have_the_same_contacts() {
    let mut scratch = Scratch::default();
    let (mut same, mut all) = (0, 0);
    for_touching_bodies(300, (4, 0.0), |a, b, pose, deepest, _| {
        let pose_ab = &MatrixPose::from(pose);
        let query = ContactQuery {
            bodies: BodyPair { a: &a.hollow, b: &b.hollow, pose_ab },
            solids: [&a.solid, &b.solid],
            margin: 0.0,
            deepest: deepest.contact,
        };
        let pose_ba = &pose_ab.inverse();
        let [p, q] = deepest.contact.witness_points;
        let seen_from_b = DeepestContact {
            witness_points: [pose_ba * q, pose_ba * p],
            normal: deepest.contact.normal.map(|n| -(pose_ba.rotation * n)),
            ..deepest.contact
        };
        let swapped = ContactQuery {
            bodies: BodyPair { a: &b.hollow, b: &a.hollow, pose_ab: pose_ba },
            solids: [&b.solid, &a.solid],
            margin: 0.0,
            deepest: seen_from_b,
        };
        let most = 100_000;
        let ours = contact_points(&query, most, &mut scratch).others;
        let theirs = contact_points(&swapped, most, &mut scratch).others;
        let theirs: Vec<ContactPoint> = (theirs.into_iter())
            .map(|contact| ContactPoint {
                position: pose_ab * contact.position,
                normal: -(pose_ab.rotation * contact.normal),
                ..contact
            })
            .collect();
        let is_same = |contact: &ContactPoint, other: &ContactPoint| {
            let depths = contact.depth.zip(other.depth).map_or(0.0, |(a, b)| (a - b).abs());
            (contact.position - other.position).norm() < 1e-5
                && (contact.normal - other.normal).norm() < 0.2
                && depths < 0.1
        };
        let is_known = |contact: &&ContactPoint| theirs.iter().any(|other| is_same(contact, other));
        all += ours.len() + theirs.len();
        same += 2 * ours.iter().filter(is_known).count();
    });
    assert!(all > 5_000 && same * 100 >= all * 97, "{same} of {all}");
}

/// Results depend on nothing but the input; a shorter list is the beginning of a longer one.
#[test]
fn results_do_not_depend_on_earlier_queries_or_instructions() {
    for_touching_bodies(100, (5, 0.0), |a, b, pose, _, found| {
        for mut scratch in [Scratch::default(), Scratch::portable()] {
            let (_, again) = contacts(a, b, pose, 0.0, 12, &mut scratch).unwrap();
            assert_eq!(found, again);
            let (_, fewer) = contacts(a, b, pose, 0.0, 3, &mut scratch).unwrap();
            assert_eq!(fewer, found[..found.len().min(3)]);
            assert_eq!(contacts(a, b, pose, 0.0, 0, &mut scratch).unwrap().1, []);
        }
    });
}

#[test]
fn huge_meshes_take_bounded_work_and_have_spread_contacts() {
    let mut scratch = Scratch::default();
    let [a, b] = [Body::of(torus(200, 100)), Body::of(sphere_mesh(100, 0.5))];
    let pose = Pose::translation(0.3, 0.1, 0.05);
    let (deepest, _) = contacts(&a, &b, &pose, 0.0, 0, &mut scratch).unwrap();
    let pose_ab = &MatrixPose::from(&pose);
    let bodies = BodyPair { a: &a.hollow, b: &b.hollow, pose_ab };
    let solids = [&a.solid, &b.solid];
    scratch.work = crate::Work::default();
    let query = ContactQuery { bodies, solids, margin: 0.0, deepest: deepest.contact };
    let found = contact_points(&query, 8, &mut scratch).others;
    assert_eq!(found.len(), 8);
    assert!(scratch.work.cost() < 3_000_000, "{:?}", scratch.work);
    let nearest = (1..8).flat_map(|i| (0..i).map(move |j| (i, j)));
    let nearest = nearest.map(|(i, j)| (found[i].position - found[j].position).norm());
    let nearest = nearest.fold(f64::INFINITY, f64::lesser);
    assert!(nearest > 0.1, "{nearest}");
}

#[test]
fn a_soup_of_triangles_that_all_touch_takes_bounded_work() {
    let (mut random, mut scratch) = (Random::new(9), Scratch::default());
    let mut soup = || {
        let vertices = (0..9_000).map(|_| Point::from(random.vector(0.5))).collect();
        Body::of(mesh(vertices, (0..3_000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()))
    };
    let (a, b) = (soup(), soup());
    let deepest = DeepestContact { witness_points: [Point::origin(); 2], normal: None, depth: 0.0 };
    let pose_ab = &MatrixPose::identity();
    let bodies = BodyPair { a: &a.hollow, b: &b.hollow, pose_ab };
    let query = ContactQuery { bodies, solids: [&a.solid, &b.solid], margin: 0.0, deepest };
    let found = contact_points(&query, 20, &mut scratch).others;
    assert_eq!(found.len(), 20);
    assert!(found.iter().all(|contact| contact.depth.is_none()), "open surfaces have no depth");
    assert!(scratch.work.cost() < 6_000_000, "{:?}", scratch.work);
}

#[test]
fn points_and_voxels_that_touch_are_contacts() {
    let mut scratch = Scratch::default();
    let centres: Vec<[f32; 3]> = (0..25_u8)
        .map(|i| {
            [f32::from(i % 5) * 0.1 - 0.2, f32::from(i / 5) * 0.1 - 0.2, if i % 2 == 0 { 0.105 } else { 0.2 }]
        })
        .collect();
    let cloud = Shape::Points(Arc::new(PointCloud::new(centres.clone(), 0.01).unwrap()));
    let cubes = centres.iter().map(|c| Cube { centre: *c, half_edge: 0.01 }).collect();
    let voxels = Shape::Voxels(Arc::new(Voxels::new(cubes).unwrap()));
    let bodies = [
        cuboid([0.5, 0.5, 0.1]),
        box_meshes(&[([0.0; 3], [0.5, 0.5, 0.1])]),
        box_meshes(&[([0.0; 3], [0.5, 0.5, 0.1]), ([0.0, 0.0, -0.4], [0.1; 3])]),
    ];
    for set in [Body::of(cloud), Body::of(voxels)] {
        for body in bodies.each_ref().map(|shape| Body::of(shape.clone())) {
            let (deepest, found) = contacts(&body, &set, &Pose::identity(), 0.0, 100, &mut scratch).unwrap();
            assert_eq!(found.len(), 12, "{deepest:?} {found:?}");
            for contact in &found {
                assert!(body.holds(&contact.position, 1e-8) && set.holds(&contact.position, 1e-8));
                assert!((contact.normal - Vector::z()).norm() < 1e-6, "{contact:?}");
                assert!((contact.depth.unwrap() - 0.005).abs() < 1e-6, "{contact:?}");
            }
            let (_, swapped) = contacts(&set, &body, &Pose::identity(), 0.0, 100, &mut scratch).unwrap();
            assert!(swapped.len() == 12 && swapped.iter().all(|contact| contact.normal.z < -0.999));
            let (_, few) = contacts(&body, &set, &Pose::identity(), 0.0, 3, &mut scratch).unwrap();
            assert_eq!(few.len(), 3);
        }
    }
}

#[test]
fn a_point_inside_a_closed_mesh_is_a_contact() {
    let mut scratch = Scratch::default();
    let solid = Body::of(box_meshes(&[([0.0; 3], [0.5; 3]), ([2.0, 0.0, 0.0], [0.5; 3])]));
    let points = vec![[0.0, 0.0, 0.49], [0.3, 0.1, 0.45], [1.0, 0.0, 0.0], [2.4, 0.0, 0.0]];
    let cloud = Body::of(Shape::Points(Arc::new(PointCloud::new(points, 0.02).unwrap())));
    let (deepest, found) = contacts(&solid, &cloud, &Pose::identity(), 0.0, 10, &mut scratch).unwrap();
    assert!((deepest.contact.depth - 0.12).abs() < 1e-6, "{deepest:?}");
    let mut depths: Vec<f64> = found.iter().map(|contact| contact.depth.unwrap()).collect();
    depths.sort_by(f64::total_cmp);
    assert_eq!(depths.len(), 2, "{found:?}");
    assert!((depths[0] - 0.03).abs() < 1e-6 && (depths[1] - 0.07).abs() < 1e-6, "{found:?}");
}

#[test]
fn an_open_mesh_has_contacts_without_depth_on_the_side_of_the_deepest() {
    let mut scratch = Scratch::default();
    let sheet = |half: f64| {
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        let corners = corners.map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
        Body::of(mesh(corners, vec![[0, 2, 1], [0, 3, 2]]))
    };
    let (floor, cube) = (sheet(1.0), Body::of(box_meshes(&[([0.0; 3], [0.1; 3])])));
    for (shift, side) in [(0.099, 1.0), (-0.099, -1.0)] {
        let pose = Pose::translation(0.2, 0.1, shift);
        let (_, found) = contacts(&floor, &cube, &pose, 0.0, 20, &mut scratch).unwrap();
        assert!(found.len() >= 4, "{found:?}");
        for contact in &found {
            assert!(contact.depth.is_none() && contact.normal.z * side > 0.999, "{contact:?}");
        }
        let solid = Body::of(ball(0.1));
        let (_, found) = contacts(&floor, &solid, &pose, 0.0, 20, &mut scratch).unwrap();
        assert!(found.iter().all(|contact| contact.depth.is_none() && contact.normal.z * side > 0.999));
    }
}
