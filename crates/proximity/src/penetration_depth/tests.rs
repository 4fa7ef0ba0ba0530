//! Tests of penetration depths: properties of bounds and witness points, and independent computations.

use std::sync::Arc;

use clearance_geometry::constants::CONTACT_DISTANCE;
use clearance_geometry::math::{Extremes, MatrixPose, Point, Pose, Vector};
use clearance_geometry::testing::Random;
use clearance_geometry::{Cube, Plane, PointCloud, Primitive, Shape, Triangle, TriangleMesh, Voxels};

use parry3d_f64::math::Pose as ParryPose;
use parry3d_f64::query::contact;
use parry3d_f64::shape::{Cuboid, Shape as Shape3};

use super::*;
use crate::CollisionBody;
use bodies::{Body, angle, bodies, cuboid_mesh, gear, mesh};

mod bodies;

fn moved(pose: &Pose, by: &Vector) -> MatrixPose {
    let pose = MatrixPose::from(pose);
    MatrixPose { translation: pose.translation + by, ..pose }
}

fn random_pose(random: &mut Random, extent: f64) -> Pose {
    Pose::from_parts(random.vector(extent).into(), random.rotation())
}

/// Overlapping pairs of bodies at random poses, and their depths.
fn for_overlapping(
    count: usize,
    seed: u64,
    mut check: impl FnMut(&Body, &Body, &Pose, PenetrationDepth, &mut Random),
) {
    let (bodies, mut random, mut scratch) = (bodies(), Random::new(seed), Scratch::default());
    let mut found = 0;
    while found < count {
        let [a, b] = [random.below(bodies.len()), random.below(bodies.len())].map(|i| &bodies[i]);
        let pose = random_pose(&mut random, 0.6);
        let depth = penetration_depth(&a.solid, &b.solid, &pose, 0.0, &mut scratch);
        assert_eq!(depth.is_some(), crate::collide(&a.whole, &b.whole, &pose, &mut scratch).is_some());
        let Some(depth) = depth else { continue };
        found += 1;
        check(a, b, &pose, depth, &mut random);
    }
}

#[test]
fn a_translation_by_the_upper_bound_separates_and_none_below_the_lower_one_does() {
    let mut scratch = Scratch::default();
    for_overlapping(400, 1, |a, b, pose, depth, random| {
        assert!(depth.lower <= depth.upper && depth.unknown.is_none(), "{depth:?}");
        let after = moved(pose, &(depth.direction * depth.upper));
        assert!(crate::collide(&a.whole, &b.whole, after, &mut scratch).is_none(), "{depth:?} {pose:?}");
        for i in 0..20 {
            let n = if i == 0 { depth.direction } else { random.direction().into_inner() };
            let after = moved(pose, &(n * (depth.lower * (1.0 - 1e-9) - CONTACT_DISTANCE)));
            assert!(crate::collide(&a.whole, &b.whole, after, &mut scratch).is_some(), "{depth:?} {pose:?}");
        }
    });
}

#[test]
fn bounds_of_both_orders_and_of_nearby_poses_agree() {
    let mut scratch = Scratch::default();
    for_overlapping(300, 2, |a, b, pose, depth, random| {
        let mut of = |a: &Body, b: &Body, pose: &Pose| {
            let found = penetration_depth(&a.solid, &b.solid, pose, 0.0, &mut scratch);
            found.map_or([0.0, 0.0], |depth| [depth.lower, depth.upper])
        };
        let [lower, upper] = of(b, a, &pose.inverse());
        assert!(lower <= depth.upper && depth.lower <= upper, "{depth:?} [{lower}, {upper}]");
        let step = random.vector(0.02);
        let [lower, upper] = of(a, b, &Pose::from(&moved(pose, &step)));
        let reach = step.norm() + 2.0 * CONTACT_DISTANCE;
        assert!(lower <= depth.upper + reach && depth.lower <= upper + reach, "{depth:?} [{lower}, {upper}]");
    });
}

#[test]
fn witness_points_lie_on_the_bodies_and_come_apart_last() {
    let mut scratch = Scratch::default();
    for_overlapping(200, 3, |a, b, pose, depth, _| {
        let point =
            CollisionBody::new([(&Pose::identity(), &Shape::Primitive(Primitive::Sphere { radius: 0.0 }))]);
        let point = point.unwrap();
        let [p, q] = depth.witness_points;
        let mut off = |body: &CollisionBody, p: Point| {
            crate::distance(
                body,
                &point,
                MatrixPose::from(&Pose::from(p.coords)),
                f64::INFINITY,
                &mut scratch,
            )
            .unwrap()
            .distance
        };
        assert!(off(&a.whole, p) <= 1e-6, "{depth:?}");
        assert!(off(&b.whole, pose.inverse_transform_point(&q)) <= 1e-6, "{depth:?}");
        let apart = q + depth.direction * depth.upper - p;
        assert!(apart.norm() <= 0.05 * depth.upper + 1e-6, "{depth:?} {apart:?}");
    });
}

/// Separating axes of two boxes: the faces' normals, and the cross products of their edges.
#[test]
fn boxes_have_the_depth_of_their_best_separating_axis() {
    let (mut random, mut scratch) = (Random::new(4), Scratch::default());
    for _ in 0..3_000 {
        let mut half = || [(); 3].map(|()| 0.05 + random.within(0.3).abs());
        let (of_a, of_b) = (half(), half());
        let pose = random_pose(&mut random, 0.4);
        let axes = pose.rotation.to_rotation_matrix();
        let normals: Vec<Vector> = (0..3)
            .map(|i| Vector::ith(i, 1.0))
            .chain((0..3).map(|i| axes.matrix().column(i).into_owned()))
            .collect();
        let edges =
            (0..3).flat_map(|i| (3..6).map(move |j| (i, j))).map(|(i, j)| normals[i].cross(&normals[j]));
        let overlap = |n: &Vector| {
            let a: f64 = (0..3).map(|i| of_a[i] * n[i].abs()).sum();
            let b: f64 = (0..3).map(|i| of_b[i] * n.dot(&normals[3 + i]).abs()).sum();
            a + b - n.dot(&pose.translation.vector).abs()
        };
        let truth =
            normals.iter().copied().chain(edges).filter_map(|n| n.try_normalize(1e-6)).map(|n| overlap(&n));
        let truth = truth.fold(f64::INFINITY, f64::lesser);
        for shapes in [
            [of_a, of_b].map(|half_extents| Shape::Primitive(Primitive::Box { half_extents })),
            [of_a, of_b].map(cuboid_mesh),
        ] {
            let [a, b] = shapes.map(Body::of);
            match penetration_depth(&a.solid, &b.solid, &pose, 0.0, &mut scratch) {
                None => assert!(truth <= CONTACT_DISTANCE, "{truth}"),
                Some(depth) => {
                    let error = 1e-6 * truth + 3.0 * CONTACT_DISTANCE;
                    assert!(
                        (depth.upper - truth).abs() <= error && (depth.lower - truth).abs() <= error,
                        "{depth:?} {truth}"
                    );
                }
            }
        }
    }
}

#[test]
fn primitives_have_tight_bounds_and_agree_with_another_implementation() {
    let (mut random, mut scratch) = (Random::new(5), Scratch::default());
    let primitive = |random: &mut Random| {
        let [x, y, z] = [(); 3].map(|()| 0.05 + random.within(0.3).abs());
        match random.below(5) {
            0 => Primitive::Sphere { radius: x },
            1 => Primitive::Capsule { radius: x, half_length: y },
            2 => Primitive::Cylinder { radius: x, half_length: y },
            3 => Primitive::Cone { radius: x, half_length: y },
            _ => Primitive::Box { half_extents: [x, y, z] },
        }
    };
    let parry = |primitive: &Primitive| -> Option<Box<dyn Shape3>> {
        Some(match *primitive {
            Primitive::Sphere { radius } => Box::new(parry3d_f64::shape::Ball::new(radius)),
            Primitive::Box { half_extents: [x, y, z] } => {
                Box::new(Cuboid::new(parry3d_f64::math::Vector::new(x, y, z)))
            }
            _ => return None,
        })
    };
    for _ in 0..5_000 {
        let [a, b] = [primitive(&mut random), primitive(&mut random)];
        let pose = random_pose(&mut random, 0.3);
        let solid = [a, b].map(|primitive| Body::of(Shape::Primitive(primitive)));
        let Some(depth) = penetration_depth(&solid[0].solid, &solid[1].solid, &pose, 0.0, &mut scratch)
        else {
            continue;
        };
        assert!(
            depth.upper - depth.lower <= 1e-6 * depth.upper + 3.0 * CONTACT_DISTANCE,
            "{a:?} {b:?} {pose:?} {depth:?}"
        );
        // the points that come apart last lie along the direction
        let [p, q] = depth.witness_points;
        let apart = q + depth.direction * depth.upper - p;
        assert!(apart.norm() <= 1e-3 * depth.upper + 1e-6, "{a:?} {b:?} {pose:?} {depth:?}");
        let signed = crate::signed_distance(&a, &b, &pose).distance;
        assert!(
            (signed + depth.upper).abs() <= 2e-6 * depth.upper + 1e-8,
            "{a:?} {b:?} {pose:?} {depth:?} {signed}"
        );
        if let (Some(first), Some(second)) = (parry(&a), parry(&b)) {
            let other = contact(&ParryPose::identity(), &*first, &ParryPose::from(pose), &*second, 0.0);
            let other = other.expect("a supported pair").expect("the solids touch").dist;
            assert!(
                (other + depth.upper).abs() <= 1e-4 * depth.upper + 1e-6,
                "{a:?} {b:?} {depth:?} {other}"
            );
        }
    }
}

/// The shortest separating translation along many directions, by bisection with tests of every pair of triangles and of corners inside.
#[test]
fn bounds_enclose_the_depth_found_by_brute_force() {
    let (shapes, mut random, mut scratch) = ([angle(), gear()], Random::new(6), Scratch::default());
    for _ in 0..12 {
        let [a, b] = [random.below(2), random.below(2)].map(|i| shapes[i].clone());
        let pose = random_pose(&mut random, 0.45);
        let [first, second] = [a.clone(), b.clone()].map(Body::of);
        let Some(depth) = penetration_depth(&first.solid, &second.solid, &pose, 0.0, &mut scratch) else {
            continue;
        };
        let (Shape::Mesh(a), Shape::Mesh(b)) = (a, b) else { unreachable!() };
        let mut brute = depth.upper;
        for n in solid_body::spread_directions(40) {
            let (mut low, mut high) = (0.0, brute);
            if overlap_by_brute_force(&a, &b, &Pose::from(&moved(&pose, &n.scale(high)))) {
                continue;
            }
            for _ in 0..12 {
                let middle = 0.5 * (low + high);
                if overlap_by_brute_force(&a, &b, &Pose::from(&moved(&pose, &n.scale(middle)))) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            brute = high;
        }
        assert!(depth.lower <= brute + CONTACT_DISTANCE, "{depth:?} {brute}");
        assert!(depth.upper <= 3.0 * brute, "{depth:?} {brute}");
    }
}

fn overlap_by_brute_force(a: &TriangleMesh, b: &TriangleMesh, pose_ab: &Pose) -> bool {
    let of_b: Vec<Triangle> = (0..b.triangles().len()).map(|i| b.triangle(i).transformed(pose_ab)).collect();
    let crosses =
        (0..a.triangles().len()).any(|i| of_b.iter().any(|t| a.triangle(i).contact_point(t).is_some()));
    crosses
        || b.vertices().iter().any(|p| a.encloses(&(pose_ab * p)))
        || a.vertices().iter().any(|p| b.encloses(&pose_ab.inverse_transform_point(p)))
}

#[test]
fn a_plane_in_a_body_is_as_deep_as_the_nearer_side() {
    let (mut random, mut scratch) = (Random::new(7), Scratch::default());
    for body in bodies() {
        for _ in 0..50 {
            let plane = Plane { normal: random.direction(), offset: random.within(0.6) };
            let flat = Body::of(Shape::Plane(plane));
            let pose = random_pose(&mut random, 0.3);
            let heights: Vec<f64> = body
                .shapes
                .iter()
                .flat_map(|(at, shape)| points_of(shape).into_iter().map(move |(p, r)| (at * p, r)))
                .flat_map(|(p, r)| [plane.height(&(pose * p)) - r, plane.height(&(pose * p)) + r])
                .collect();
            let (low, high) = (
                heights.iter().copied().fold(f64::INFINITY, f64::lesser),
                heights.iter().copied().fold(f64::NEG_INFINITY, f64::greater),
            );
            let found = penetration_depth(&flat.solid, &body.solid, &pose, 0.0, &mut scratch);
            let Some(depth) = found else {
                assert!(low > 0.0 || high < 0.0);
                continue;
            };
            if body
                .shapes
                .iter()
                .all(|(_, shape)| !matches!(shape, Shape::Primitive(Primitive::Cylinder { .. })))
            {
                let truth = high.lesser(-low);
                assert!(
                    (depth.lower - truth).abs() <= 1e-9 && (depth.upper - truth).abs() <= 1e-6 * truth + 1e-8,
                    "{depth:?} {truth}"
                );
            }
            let after = moved(&pose, &(depth.direction * depth.upper));
            assert!(crate::collide(&flat.whole, &body.whole, after, &mut scratch).is_none());
        }
    }
    let planes = [Vector::x_axis(), Vector::y_axis()]
        .map(|normal| Body::of(Shape::Plane(Plane { normal, offset: 0.0 })));
    let depth =
        penetration_depth(&planes[0].solid, &planes[1].solid, &Pose::identity(), 0.0, &mut scratch).unwrap();
    assert_eq!((depth.upper, depth.unknown), (f64::INFINITY, Some(UnknownDepth::Inseparable)));
}

/// The Minkowski difference has a large flat face beside faces that are almost flat: rounding ends the search in slivers.
#[test]
fn a_cylinder_that_lies_on_a_large_flat_mesh_is_as_deep_as_its_lowest_point() {
    let (mut random, mut scratch) = (Random::new(77), Scratch::default());
    let (radius, half_length) = (0.05, 0.15);
    let cylinder = Body::of(Shape::Primitive(Primitive::Cylinder { radius, half_length }));
    for size in [1.0, 20.0, 100.0] {
        let slack = 1e-8 * (1.0 + size);
        let half = Vector::new(0.5 * size, 0.5 * size, 0.15);
        let floor = Body::of(cuboid_mesh(half.into()));
        for _ in 0..300 {
            let tilt = 10_f64.powf(-2.5 + random.within(1.5));
            let rotation = nalgebra::UnitQuaternion::from_axis_angle(&Vector::z_axis(), random.within(3.0))
                * nalgebra::UnitQuaternion::from_axis_angle(
                    &Vector::y_axis(),
                    0.5 * std::f64::consts::PI + tilt,
                );
            let axis: Vector = rotation * Vector::z();
            let lowest = half_length * axis.z.abs() + radius * (1.0 - axis.z * axis.z).sqrt();
            let depth = 10_f64.powf(-5.0 + random.within(2.0));
            let aside = [(); 2].map(|()| random.within(0.1 * size));
            let pose =
                Pose::from_parts(Vector::new(aside[0], aside[1], half.z + lowest - depth).into(), rotation);
            let found = penetration_depth(&floor.solid, &cylinder.solid, &pose, 0.0, &mut scratch).unwrap();
            assert!(
                (found.upper - depth).abs() <= 1e-6 * depth + slack && found.direction.z > 0.99,
                "{size} {depth} {tilt}: {found:?}"
            );
            assert!(found.lower <= depth + slack, "{size} {depth} {tilt}: {found:?}");
        }
    }
}

#[test]
fn the_deepest_voxel_need_not_have_the_deepest_centre() {
    let mut scratch = Scratch::default();
    let ball = Body::of(Shape::Primitive(Primitive::Sphere { radius: 0.2 }));
    let centres = [[0.22_f32, 0.0, 0.0], [0.23 / 3.0_f32.sqrt(); 3]];
    let depth_of = |centres: &[[f32; 3]], scratch: &mut Scratch| {
        let cubes = centres.iter().map(|&centre| Cube { centre, half_edge: 0.05 }).collect();
        let voxels = Body::of(Shape::Voxels(Arc::new(Voxels::new(cubes).unwrap())));
        penetration_depth(&ball.solid, &voxels.solid, &Pose::identity(), 0.0, scratch).unwrap()
    };
    let [first, second] = centres.map(|centre| depth_of(&[centre], &mut scratch));
    assert!((first.upper - 0.03).abs() < 1e-6 && second.upper > 0.055, "{first:?} {second:?}");
    assert_eq!(depth_of(&centres, &mut scratch), second);
}

/// Points whose balls have the convex hull of the shape.
fn points_of(shape: &Shape) -> Vec<(Point, f64)> {
    match shape {
        Shape::Mesh(mesh) => mesh.vertices().iter().map(|p| (*p, 0.0)).collect(),
        Shape::Primitive(Primitive::Capsule { radius, half_length }) => {
            [-1.0, 1.0].map(|side| (Point::new(0.0, 0.0, side * half_length), *radius)).into()
        }
        _ => Vec::new(),
    }
}

#[test]
fn points_and_voxels_count_one_by_one() {
    let (mut random, mut scratch) = (Random::new(8), Scratch::default());
    #[allow(clippy::cast_possible_truncation)] // any numbers
    let centres: Vec<[f32; 3]> = (0..400).map(|_| random.vector(0.7).map(|x| x as f32).into()).collect();
    let cloud = Body::of(Shape::Points(Arc::new(PointCloud::new(centres.clone(), 0.02).unwrap())));
    let cubes = centres.iter().map(|c| Cube { centre: *c, half_edge: 0.02 }).collect();
    let voxels = Body::of(Shape::Voxels(Arc::new(Voxels::new(cubes).unwrap())));
    for body in bodies() {
        let pose = random_pose(&mut random, 0.2);
        let single = |centre: &[f32; 3]| {
            let at = Pose::from(Vector::from(centre.map(f64::from)));
            Body::new(vec![(at, Shape::Primitive(Primitive::Sphere { radius: 0.02 }))])
        };
        let mut of = |other: &Body| penetration_depth(&body.solid, &other.solid, &pose, 0.0, &mut scratch);
        let deepest =
            centres.iter().filter_map(|c| of(&single(c))).map(|depth| depth.lower).fold(0.0, f64::greater);
        let found = of(&cloud).unwrap();
        assert!(found.upper >= deepest - 1e-9 && found.lower <= deepest + 1e-9, "{found:?} {deepest}");
        let of_voxels = of(&voxels).unwrap();
        assert!(of_voxels.upper >= 0.8 * deepest, "{of_voxels:?} {deepest}");
        let swapped =
            penetration_depth(&cloud.solid, &body.solid, &pose.inverse(), 0.0, &mut scratch).unwrap();
        assert!(swapped.lower <= found.upper && found.lower <= swapped.upper, "{swapped:?} {found:?}");
    }
}

#[test]
fn an_open_mesh_has_no_inside_and_the_result_says_so() {
    let Shape::Mesh(closed) = cuboid_mesh([0.2; 3]) else { unreachable!() };
    let open = mesh(closed.vertices().to_vec(), closed.triangles()[2..].to_vec());
    let ball = Body::of(Shape::Primitive(Primitive::Sphere { radius: 0.1 }));
    let mut scratch = Scratch::default();
    let pose = Pose::translation(0.25, 0.0, 0.0);
    let depth = penetration_depth(&Body::of(open).solid, &ball.solid, &pose, 0.0, &mut scratch).unwrap();
    assert_eq!(depth.unknown, Some(UnknownDepth::OpenMesh));
    assert!((depth.upper - 0.05).abs() <= 1e-6 && depth.lower <= depth.upper, "{depth:?}");
    let inside = Pose::identity();
    let closed = Body::of(cuboid_mesh([0.2; 3]));
    let depth = penetration_depth(&closed.solid, &ball.solid, &inside, 0.0, &mut scratch).unwrap();
    assert!((depth.upper - 0.3).abs() <= 1e-6 && (depth.lower - 0.3).abs() <= 1e-6, "{depth:?}");
}

#[test]
fn a_margin_makes_bodies_larger() {
    let (mut random, mut scratch) = (Random::new(9), Scratch::default());
    let bodies = bodies();
    let mut found = 0;
    while found < 150 {
        let [a, b] = [random.below(bodies.len()), random.below(bodies.len())].map(|i| &bodies[i]);
        let pose = random_pose(&mut random, 0.8);
        let margin = 0.05;
        let Some(padded) = penetration_depth(&a.solid, &b.solid, &pose, margin, &mut scratch) else {
            continue;
        };
        found += 1;
        let after = moved(&pose, &(padded.direction * padded.upper));
        let distance =
            crate::distance(&a.whole, &b.whole, after, f64::INFINITY, &mut scratch).unwrap().distance;
        assert!(distance > margin, "{padded:?} {distance}");
        if let Some(depth) = penetration_depth(&a.solid, &b.solid, &pose, 0.0, &mut scratch) {
            let [lower, upper] = [depth.lower, depth.upper].map(|bound| bound + margin);
            assert!(padded.lower <= upper + 1e-8 && padded.upper >= lower - 1e-8, "{padded:?} {depth:?}");
        } else {
            let found = crate::distance(&a.whole, &b.whole, &pose, f64::INFINITY, &mut scratch);
            let apart = found.unwrap().distance;
            assert!((padded.lower - (margin - apart)).abs() <= 1e-8, "{padded:?} {apart}");
        }
    }
}

/// Aligned round solids have Minkowski differences with many points in one plane or line.
#[test]
fn aligned_round_solids_have_tight_bounds() {
    let (mut random, mut scratch) = (Random::new(77), Scratch::default());
    let mut wide = 0;
    for _ in 0..20_000 {
        let [a, b] = [(); 2].map(|()| {
            let [x, y, z] = [(); 3].map(|()| 0.05 + random.within(0.45).abs());
            match random.below(4) {
                0 => Primitive::Capsule { radius: x, half_length: y },
                1 => Primitive::Cylinder { radius: x, half_length: y },
                2 => Primitive::Cone { radius: x, half_length: y },
                _ => Primitive::Box { half_extents: [x, y, z] },
            }
        });
        let pose = random_pose(&mut random, 0.4);
        let solids =
            [a, b].map(|primitive| SolidBody::new([(&Pose::identity(), &Shape::Primitive(primitive))]));
        let Some(depth) = penetration_depth(&solids[0], &solids[1], &pose, 0.0, &mut scratch) else {
            continue;
        };
        // where solids hardly overlap, the distance of curved ones is less accurate than their depth
        assert!(depth.upper - depth.lower <= 1e-6 * depth.upper + 1e-7, "{a:?} {b:?} {pose:?} {depth:?}");
        wide += usize::from(depth.upper - depth.lower > 1e-6 * depth.upper + 3.0 * CONTACT_DISTANCE);
    }
    assert!(wide <= 2, "{wide}");
}

#[test]
fn two_clouds_that_touch_have_no_depth_and_the_result_says_so() {
    let mut scratch = Scratch::default();
    let cloud =
        |x: f32| Body::of(Shape::Points(Arc::new(PointCloud::new(vec![[x, 0.0, 0.0]], 0.1).unwrap())));
    let (a, b) = (cloud(0.0), cloud(0.15));
    let depth = penetration_depth(&a.solid, &b.solid, &Pose::identity(), 0.0, &mut scratch).unwrap();
    assert_eq!((depth.upper, depth.unknown), (f64::INFINITY, Some(UnknownDepth::BothAreSets)));
    let apart = Pose::translation(0.1, 0.0, 0.0);
    assert_eq!(penetration_depth(&a.solid, &b.solid, &apart, 0.0, &mut scratch), None);
}

/// Two balls, and one mesh of two boxes, with a gap from -0.4 to 0.4 m along x: the plane may leave into it, if it has room there.
#[test]
fn a_plane_may_leave_a_body_into_a_gap() {
    let mut scratch = Scratch::default();
    let ends = [-0.5, 0.5].map(|x| Pose::translation(x, 0.0, 0.0));
    let balls = ends.map(|at| (at, Shape::Primitive(Primitive::Sphere { radius: 0.1 })));
    let Shape::Mesh(cube) = cuboid_mesh([0.1; 3]) else { unreachable!() };
    let vertices = ends.iter().flat_map(|at| cube.vertices().iter().map(move |p| at * p)).collect();
    let second = cube.triangles().iter().map(|face| face.map(|v| v + 8));
    let two_cubes = mesh(vertices, cube.triangles().iter().copied().chain(second).collect());
    let bodies = [Body::new(balls.to_vec()), Body::of(two_cubes)];
    for body in &bodies {
        for (offset, margin, depth) in [
            (0.42, 0.0, 0.02),
            (0.48, 0.0, 0.08),
            (0.55, 0.0, 0.05),
            (-0.42, 0.0, 0.02),
            (0.395, 0.01, 0.005),
            // padded by 0.4 m, there is no gap
            (0.42, 0.4, 0.58),
        ] {
            let plane = Body::of(Shape::Plane(Plane { normal: Vector::x_axis(), offset }));
            let found = penetration_depth(&plane.solid, &body.solid, &Pose::identity(), margin, &mut scratch);
            let found = found.unwrap();
            assert!(
                (found.lower - depth).abs() < 1e-8 && (found.upper - depth).abs() < 1e-8,
                "{offset}: {found:?}"
            );
        }
    }
}

/// A link with a plane has at least the depth of the plane.
#[test]
fn a_plane_among_other_shapes_counts() {
    let mut scratch = Scratch::default();
    let ball = |radius| Shape::Primitive(Primitive::Sphere { radius });
    let floor = Shape::Plane(Plane { normal: Vector::z_axis(), offset: 0.0 });
    let with_floor =
        Body::new(vec![(Pose::identity(), floor), (Pose::translation(5.0, 0.0, 0.0), ball(0.1))]);
    let depth = penetration_depth(
        &with_floor.solid,
        &Body::of(ball(0.5)).solid,
        &Pose::translation(0.0, 0.0, 0.3),
        0.0,
        &mut scratch,
    );
    let depth = depth.unwrap();
    assert!((depth.lower - 0.2).abs() <= 1e-6 && (depth.upper - 0.2).abs() <= 1e-6, "{depth:?}");
}
