//! Tests of queries on two bodies: hierarchies against brute force, bounds of bounding volumes, laws of distances.

use std::any::type_name;

use clearance::geometry::math::{Point, Pose, Vector};
use clearance::geometry::simd::{Level, baseline};
use clearance::geometry::{Primitive, Shape, Triangle, TriangleMesh, VolumeKind};
use clearance::proximity::bounding_volume::{
    Aabb, AnchoredReach, Axes, BoundingVolume, Capsule, Kdop18, Kios, Obb, Relative, Rss, Sphere,
};
use clearance::proximity::{BodyPair, CollisionBody, Effort, Piece, Scratch};
use clearance::proximity::{
    collide, distance, distance_bounds, elements_found_within_margin, margin_bounds, pieces_within_margin,
    signed_distance, within_margin,
};
use fearless_simd::dispatch;

use crate::random::Random;
use crate::reference::{self, ReferenceBody};

fn body(shape: &Shape) -> CollisionBody {
    CollisionBody::new([(&Pose::identity(), shape)]).unwrap()
}

fn least(a: &CollisionBody, b: &CollisionBody, pose_ab: &Pose) -> f64 {
    distance(a, b, pose_ab, f64::INFINITY, &mut Scratch::default()).unwrap().distance
}

/// Every pair of triangles, no tree.
fn brute_force(a: &TriangleMesh, b: &TriangleMesh, pose_ab: &Pose) -> f64 {
    let triangles =
        |m: &TriangleMesh| -> Vec<Triangle> { (0..m.triangles().len()).map(|i| m.triangle(i)).collect() };
    let theirs: Vec<_> = triangles(b).iter().map(|t| t.transformed(pose_ab)).collect();
    let mut least = f64::INFINITY;
    for s in triangles(a) {
        for t in &theirs {
            let [p, q] = s.nearest_points(t);
            least = least.min(nalgebra::distance(&p, &q));
        }
    }
    least
}

#[test]
fn trees_agree_with_brute_force() {
    let mut random = Random::new(10);
    let (mut hits, mut misses) = (0, 0);
    for round in 0..60 {
        let a = if round % 2 == 0 { random.blob(6, 0.4) } else { random.soup(60, 0.4, 0.1) };
        let b = if round % 3 == 0 { random.blob(5, 0.3) } else { random.soup(50, 0.3, 0.1) };
        let pose = random.pose(0.9);
        let truth = brute_force(&a, &b, &pose);
        let (a, b) = (body(&Shape::Mesh(a.into())), body(&Shape::Mesh(b.into())));
        let found = least(&a, &b, &pose);
        let truth = if truth <= 1e-9 { 0.0 } else { truth };
        assert!((found - truth).abs() < 1e-12, "{found} {truth}");
        let hit = collide(&a, &b, &pose, &mut Scratch::default()).is_some();
        assert_eq!(hit, truth == 0.0);
        for margin in [0.0, 0.01, 0.1, 0.3] {
            let near = within_margin(&a, &b, &pose, margin, &mut Scratch::default()).is_some();
            assert_eq!(near, truth <= margin, "margin {margin} distance {truth}");
            let limited = distance(&a, &b, &pose, margin, &mut Scratch::default());
            assert_eq!(limited.is_some(), truth <= margin);
        }
        if hit { hits += 1 } else { misses += 1 }
    }
    assert!(hits > 10 && misses > 10, "{hits} {misses}");
}

#[test]
fn laws_of_distance_for_every_kind_of_shape() {
    let mut random = Random::new(11);
    for _ in 0..600 {
        let (shape_a, shape_b) = (random.shape(), random.shape());
        let (a, b) = (body(&shape_a), body(&shape_b));
        let pose_ab = random.pose(0.8);
        let names = (shape_a.kind(), shape_b.kind());
        let mut scratch = Scratch::default();
        let found = distance(&a, &b, &pose_ab, f64::INFINITY, &mut scratch).unwrap();
        let d = found.distance;
        assert!(scratch.work.volume_tests > 0 && scratch.work.primitive_tests > 0);
        // symmetry, rigid invariance
        assert!((d - least(&b, &a, &pose_ab.inverse())).abs() < 1e-6, "{names:?}");
        let moved = random.pose(0.5);
        let turned = CollisionBody::new([(&moved, &shape_b)]).unwrap();
        let same = least(&a, &turned, &(pose_ab * moved.inverse()));
        assert!((d - same).abs() < 1e-6, "{names:?} {d} {same}");
        // collide iff distance 0
        let hit = collide(&a, &b, &pose_ab, &mut Scratch::default());
        assert_eq!(hit.is_some(), d == 0.0, "{names:?} {d}");
        // witness points: as far apart as the distance, and each on its body
        let [p, q] = found.witness_points;
        assert!((nalgebra::distance(&p, &q) - d).abs() < 1e-9, "{names:?}");
        let probe = body(&Shape::Primitive(Primitive::sphere(0.0).unwrap()));
        let at = |p: Point| Pose::translation(p.x, p.y, p.z);
        assert!(least(&a, &probe, &at(p)) < 1e-6, "{names:?}: witness is off the first body");
        let q_b = pose_ab.inverse_transform_point(&q);
        assert!(least(&b, &probe, &at(q_b)) < 1e-6, "{names:?}: witness is off the second body");
    }
}

/// Support functions written here once more: a separating direction proves a distance from below, witness points from
/// above. Every pair of convex solids must close the gap.
#[test]
fn distances_of_primitives_are_proven_from_both_sides() {
    let mut random = Random::new(12);
    let mut worst: f64 = 0.0;
    for _ in 0..20_000 {
        let (a, b) = (random.primitive(), random.primitive());
        let pose_ab = random.pose(1.5);
        let found = signed_distance(&a, &b, &pose_ab);
        if found.distance <= 1e-6 {
            continue;
        }
        let [p, q] = found.witness_points;
        let gap_along = |n: &Vector| {
            let reach_b = support(&b, &-(pose_ab.rotation.inverse() * n));
            n.dot(&pose_ab.translation.vector) - support(&a, n) - reach_b
        };
        let mut n = (q - p).normalize();
        let mut proven = gap_along(&n);
        // the direction of the witness points is rougher than their distance: climb to the best one nearby
        // and again, as it may be stuck on a ridge
        for _ in 0..20 {
            let mut step = 1e-5;
            while found.distance - proven > 1e-9 && step > 1e-13 {
                let tried = (n + random.vector(step)).normalize();
                if gap_along(&tried) > proven {
                    (n, proven) = (tried, gap_along(&tried));
                } else {
                    step *= 0.9;
                }
            }
        }
        assert!(proven <= found.distance + 1e-12);
        worst = worst.max(found.distance - proven);
    }
    assert!(worst < 1e-8, "worst gap {worst}");
}

/// How far a primitive reaches from its origin along `n`.
fn support(primitive: &Primitive, n: &Vector) -> f64 {
    match *primitive {
        Primitive::Box { half_extents: [x, y, z] } => (n.x * x).abs() + (n.y * y).abs() + (n.z * z).abs(),
        Primitive::Sphere { radius } => radius,
        Primitive::Cylinder { radius, half_length } => n.x.hypot(n.y) * radius + n.z.abs() * half_length,
        Primitive::Cone { radius, half_length } => {
            (n.x.hypot(n.y) * radius - n.z * half_length).max(n.z * half_length)
        }
        Primitive::Capsule { radius, half_length } => radius + n.z.abs() * half_length,
    }
}

/// Moving out by the signed distance just separates; moving out by less does not.
#[test]
fn penetration_depth_separates() {
    let mut random = Random::new(13);
    let mut deep = 0;
    for _ in 0..4_000 {
        let (a, b) = (random.primitive(), random.primitive());
        let pose_ab = random.pose(0.3);
        let found = signed_distance(&a, &b, &pose_ab);
        let [p, q] = found.witness_points;
        let depth = -found.distance;
        if depth < 1e-4 || (p - q).norm() < 1e-6 {
            continue;
        }
        deep += 1;
        let out = (p - q).normalize() * (depth + 1e-4);
        let apart = Pose::from(nalgebra::Translation3::from(out)) * pose_ab;
        let after = signed_distance(&a, &b, &apart).distance;
        assert!(after > -1e-6, "{a:?} {b:?} depth {depth}: still {after}");
    }
    assert!(deep > 1_000, "{deep}");
}

/// A bound of the distance of two volumes in frames that are placed at random about their anchors.
fn bound<B: BoundingVolume>(level: Level, s: &[Point], t: &[Point], pose_ab: &Pose, separate: bool) -> f64 {
    let vectors = |points: &[Point]| points.iter().map(|p| p.coords).collect::<Vec<_>>();
    let (s, t) = (vectors(s), vectors(t));
    let axes = |points: &[Vector]| Axes::from_columns(&B::axes(points));
    let (axes_a, axes_b) = (axes(&s), axes(&t));
    let fit =
        |axes: &Axes, points: &[Vector]| B::fit(&points.iter().map(|p| axes.along(p)).collect::<Vec<_>>());
    let (a, b) = (fit(&axes_a, &s), fit(&axes_b, &t));
    let reach = |points: &[Vector]| points.iter().map(|p| p.abs().sum()).fold(0.0, f64::max);
    let origin = Point::origin();
    let tree = |points: &[Vector]| AnchoredReach { anchor: &origin, reach: reach(points) };
    let trees = Relative::of_trees(&pose_ab.into(), tree(&s), tree(&t));
    let relative = trees.of_nodes(&axes_a, &axes_b);
    dispatch!(level, simd => {
        let seen = B::seen(simd, &a.splat(), &relative);
        let facing = B::facing(simd, &B::pack(&[b]), &relative);
        let bounds = if separate {
            B::bounds::<_, true>(simd, &facing, &seen, 3, &relative)
        } else {
            B::bounds::<_, false>(simd, &facing, &seen, 3, &relative)
        };
        let coarse: [f32; 8] = B::coarse_bounds(simd, &seen, &b, &relative).into();
        let bounds: [f32; 8] = bounds.into();
        f64::from(bounds[5].max(coarse[2]) - relative.slack)
    })
}

/// Volumes around random points: bounds never exceed the distance, and are the same at every level.
fn volume_bounds<B: BoundingVolume>(random: &mut Random) {
    let mut apart = 0;
    for round in 0..4_000 {
        let scale = 10f64.powi(round % 7 - 3);
        let (s, t) = (random.triangle(0.5 * scale), random.triangle(0.5 * scale));
        let pose_ab = random.pose(scale);
        let [p, q] = s.nearest_points(&t.transformed(&pose_ab));
        let d = nalgebra::distance(&p, &q);
        for separate in [true, false] {
            let of = |level| bound::<B>(level, &s.corners(), &t.corners(), &pose_ab, separate);
            let found = of(Level::new());
            assert!(found <= d, "{}: {found} {d}", type_name::<B>());
            assert_eq!(found.to_bits(), of(baseline()).to_bits(), "{}", type_name::<B>());
            apart += usize::from(found > 0.0);
        }
    }
    assert!(apart > 200, "{}: only {apart} bounds say anything", type_name::<B>());
}

/// A volume holds every point it was fitted to, so nothing bounds their distance from above zero.
fn holds<B: BoundingVolume>(random: &mut Random) {
    for _ in 0..300 {
        let spread = random.vector(1.0);
        let pose = random.pose(2.0);
        let count = 1 + random.below(30);
        let points: Vec<Point> =
            (0..count).map(|_| pose * Point::from(random.vector(1.0).component_mul(&spread))).collect();
        let turn = random.pose(0.0);
        for p in &points {
            let turned = turn.inverse() * p;
            for separate in [true, false] {
                assert!(
                    bound::<B>(Level::new(), &points, &[turned], &turn, separate) <= 0.0,
                    "{}",
                    type_name::<B>()
                );
            }
        }
    }
}

#[test]
fn volumes_hold_what_they_were_fitted_to() {
    holds::<Obb>(&mut Random::new(20));
    holds::<Rss>(&mut Random::new(21));
    holds::<Sphere>(&mut Random::new(22));
    holds::<Capsule>(&mut Random::new(26));
    holds::<Aabb>(&mut Random::new(27));
    holds::<Kdop18>(&mut Random::new(30));
    holds::<Kios>(&mut Random::new(31));
}

#[test]
fn volume_bounds_never_exceed_the_distance() {
    volume_bounds::<Obb>(&mut Random::new(23));
    volume_bounds::<Rss>(&mut Random::new(24));
    volume_bounds::<Sphere>(&mut Random::new(25));
    volume_bounds::<Capsule>(&mut Random::new(28));
    volume_bounds::<Aabb>(&mut Random::new(29));
    volume_bounds::<Kdop18>(&mut Random::new(32));
    volume_bounds::<Kios>(&mut Random::new(33));
}

/// One traversal for all volumes: each gives the answers of the reference engine, at every level, to the bit the same.
fn engine_agrees(kind: VolumeKind, seed: u64) {
    let mut random = Random::new(seed);
    for round in 0..60 {
        let (shape_a, shape_b) = if round % 2 == 0 {
            (Shape::Mesh(random.blob(14, 0.4).into()), Shape::Mesh(random.soup(300, 0.4, 0.1).into()))
        } else {
            (random.shape(), random.shape())
        };
        let pose_ab = random.pose(0.9);
        let id = Pose::identity();
        let (slow_a, slow_b) = (ReferenceBody::new([(&id, &shape_a)]), ReferenceBody::new([(&id, &shape_b)]));
        let body = |shape| CollisionBody::new([(&id, shape)]).unwrap().with_volumes_of(kind, &[kind]);
        let (a, b) = (body(&shape_a), body(&shape_b));
        let truth = reference::distance(&slow_a, &slow_b, &pose_ab, f64::INFINITY).unwrap().distance;
        assert_eq!(reference::collide(&slow_a, &slow_b, &pose_ab).is_some(), truth == 0.0);
        let mut fast = Scratch::default();
        let mut portable = Scratch::portable();
        let found = distance(&a, &b, &pose_ab, f64::INFINITY, &mut fast);
        assert_eq!(found, distance(&a, &b, &pose_ab, f64::INFINITY, &mut portable));
        // what is proven larger than the limit is so for any limit, and what is not has the same answer
        let again = distance(&a, &b, &pose_ab, truth * 1.01 + 1e-9, &mut fast);
        assert_eq!(found, again, "{kind:?}: the limit changed the answer");
        let found = found.unwrap().distance;
        assert!((found - truth).abs() < 1e-9, "{kind:?}: {found} {truth}");
        assert_eq!(collide(&a, &b, &pose_ab, &mut fast).is_some(), truth == 0.0, "{kind:?}");
        assert_eq!(collide(&a, &b, &pose_ab, &mut portable).is_some(), truth == 0.0, "{kind:?}");
        assert!(distance(&a, &b, &pose_ab, truth * 0.99 - 1e-9, &mut fast).is_none_or(|s| s.distance == 0.0));
    }
}

#[test]
fn every_volume_agrees_with_the_reference_engine() {
    engine_agrees(VolumeKind::Obb, 40);
    engine_agrees(VolumeKind::Rss, 41);
    engine_agrees(VolumeKind::Pss, 42);
    engine_agrees(VolumeKind::Lss, 43);
    engine_agrees(VolumeKind::Aabb, 44);
    engine_agrees(VolumeKind::Kdop18, 47);
    engine_agrees(VolumeKind::Kios, 48);
}

/// Bodies of every kind of volume, and of two different kinds, give every result of boxes to the bit, in contact too.
#[test]
fn results_do_not_depend_on_the_kind_of_volume() {
    let mut random = Random::new(46);
    let (mut touching, mut apart, mut other_work) = (0, 0, 0);
    for round in 0..80 {
        let (shape_a, shape_b) = if round % 2 == 0 {
            (Shape::Mesh(random.blob(14, 0.4).into()), Shape::Mesh(random.soup(200, 0.4, 0.1).into()))
        } else {
            (random.shape(), random.shape())
        };
        let more = Shape::Primitive(random.primitive());
        let (id, aside, pose_ab) = (Pose::identity(), random.pose(0.5), random.pose(0.9));
        let list = |shape| [(&id, shape), (&aside, &more)];
        let (a, b) = if round % 3 == 0 {
            (
                CollisionBody::with_solid_meshes(list(&shape_a)),
                CollisionBody::with_solid_meshes(list(&shape_b)),
            )
        } else {
            (CollisionBody::new(list(&shape_a)), CollisionBody::new(list(&shape_b)))
        };
        let (a, b) = (a.unwrap(), b.unwrap());
        let pieces: Vec<Piece> = b.pieces(8).into_iter().step_by(2).map(|(piece, _)| piece).collect();
        let results = |a: &CollisionBody, b: &CollisionBody, scratch: &mut Scratch| {
            let bodies = BodyPair { a, b, pose_ab: &(&pose_ab).into() };
            let exact = distance(a, b, &pose_ab, f64::INFINITY, scratch);
            let far = 1.3 * exact.map_or(0.0, |found| found.distance) + 0.01;
            (
                exact,
                collide(a, b, &pose_ab, scratch),
                within_margin(a, b, &pose_ab, far, scratch),
                pieces_within_margin(bodies, &pieces, far, scratch),
                elements_found_within_margin(bodies, far, scratch),
                distance_bounds(bodies, far, &Effort::default(), scratch),
                margin_bounds(bodies, far, None, scratch),
            )
        };
        let mut with_boxes = Scratch::default();
        let expected = results(&a, &b, &mut with_boxes);
        touching += usize::from(expected.1.is_some());
        apart += usize::from(expected.1.is_none());
        for kind in VolumeKind::ALL {
            let mut scratch = Scratch::default();
            let (of_a, of_b) = (a.clone().with_volumes_of(kind, &[]), b.clone().with_volumes_of(kind, &[]));
            assert_eq!(results(&of_a, &of_b, &mut scratch), expected, "{kind}");
            assert_eq!(results(&of_a, &of_b, &mut Scratch::portable()), expected, "{kind}, portable");
            other_work += usize::from(kind != VolumeKind::Obb && scratch.work != with_boxes.work);
            assert!(kind != VolumeKind::Obb || scratch.work == with_boxes.work);
            // a body of another kind, which has volumes of this one, and one which has not
            let mixed = a.clone().with_volumes_of(VolumeKind::Rss, &[kind]);
            assert_eq!(results(&mixed, &of_b, &mut Scratch::default()), expected, "rss and {kind}");
            assert_eq!(results(&a, &of_b, &mut Scratch::default()), expected, "boxes and {kind}");
        }
    }
    assert!(touching > 15 && apart > 15, "{touching} {apart}");
    assert!(other_work > 300, "only {other_work} searches used other volumes");
}

/// Less effort: the bounds hold, and a passed deadline still gives bounds that hold.
#[test]
fn bounds_of_a_distance_hold() {
    let mut random = Random::new(45);
    let mut interrupted = 0;
    for _ in 0..200 {
        let a = body(&Shape::Mesh(random.blob(14, 0.4).into()));
        let b = body(&Shape::Mesh(random.soup(300, 0.4, 0.1).into()));
        let pose_ab = random.pose(1.2);
        let truth = least(&a, &b, &pose_ab);
        let mut scratch = Scratch::default();
        let rough = Effort { relative_tolerance: 0.25, absolute_tolerance: 0.01, ..Effort::default() };
        let bodies = BodyPair { a: &a, b: &b, pose_ab: &(&pose_ab).into() };
        let found = distance_bounds(bodies, f64::INFINITY, &rough, &mut scratch);
        let upper = found.upper.unwrap().distance;
        assert!(!found.interrupted && found.lower <= truth && truth <= upper);
        assert!(upper - found.lower <= (0.25 * upper).max(0.01) + 1e-12);
        let late = Effort { deadline: Some(std::time::Instant::now()), ..rough };
        let found = distance_bounds(bodies, f64::INFINITY, &late, &mut scratch);
        interrupted += usize::from(found.interrupted);
        assert!(found.lower <= truth && found.upper.is_none_or(|u| truth <= u.distance));
    }
    assert_eq!(interrupted, 200);
}

#[test]
fn a_body_inside_a_closed_mesh_touches_only_if_meshes_are_solid() {
    let mut random = Random::new(14);
    let shell = Shape::Mesh(random.blob(8, 1.0).into());
    let inside = Shape::Primitive(Primitive::sphere(0.1).unwrap());
    let place = |x: f64| Pose::translation(x, 0.0, 0.0);
    let surface = body(&shell);
    let id = Pose::identity();
    let solid = CollisionBody::with_solid_meshes([(&id, &shell)]).unwrap();
    let ball = CollisionBody::with_solid_meshes([(&id, &inside)]).unwrap();
    let hit = |a: &CollisionBody, x: f64| collide(a, &ball, &place(x), &mut Scratch::default()).is_some();
    assert!(!hit(&surface, 0.1) && hit(&solid, 0.1));
    assert!(!hit(&surface, 3.0) && !hit(&solid, 3.0));
    assert_eq!(least(&solid, &ball, &place(0.1)), 0.0);
    assert!(least(&surface, &ball, &place(0.1)) > 0.3);
}

#[test]
fn a_cone_without_a_radius_is_a_segment() {
    let needle = body(&Shape::Primitive(Primitive::cone(0.0, 2.0).unwrap()));
    let ball = body(&Shape::Primitive(Primitive::sphere(0.1).unwrap()));
    let at = |x: f64, z: f64| Pose::from_parts(Vector::new(x, 0.0, z).into(), nalgebra::one());
    for (pose, truth) in [(at(0.0, 1.5), 0.4), (at(0.0, -1.5), 0.4), (at(0.5, 0.3), 0.4), (at(0.0, 0.3), 0.0)]
    {
        assert!((least(&needle, &ball, &pose) - truth).abs() < 1e-9, "{pose:?}");
        assert_eq!(collide(&needle, &ball, &pose, &mut Scratch::default()).is_some(), truth == 0.0);
    }
}
