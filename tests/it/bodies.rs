//! Bodies against bodies: the hierarchies against brute force over all elements, and the laws of the questions.

use clearance::bounding_volume::{BoundingVolume, Obb, Rss, Sphere};
use clearance::geometry::{Primitive, Shape, Triangle, TriangleMesh};
use clearance::math::{Point, Pose, Vector};
use clearance::query::{CollisionBody, Work, collide, distance, signed_distance, within_margin};

use crate::random::Random;

fn body(shape: &Shape) -> CollisionBody {
    CollisionBody::new([(&Pose::identity(), shape)]).unwrap()
}

fn least(a: &CollisionBody, b: &CollisionBody, pose_ab: &Pose) -> f64 {
    distance(a, b, pose_ab, f64::INFINITY, &mut Work::default()).unwrap().distance
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
        let hit = collide(&a, &b, &pose, &mut Work::default()).is_some();
        assert_eq!(hit, truth == 0.0);
        for margin in [0.0, 0.01, 0.1, 0.3] {
            let near = within_margin(&a, &b, &pose, margin, &mut Work::default()).is_some();
            assert_eq!(near, truth <= margin, "margin {margin} distance {truth}");
            let limited = distance(&a, &b, &pose, margin, &mut Work::default());
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
        let mut work = Work::default();
        let found = distance(&a, &b, &pose_ab, f64::INFINITY, &mut work).unwrap();
        let d = found.distance;
        assert!(work.volume_tests > 0 && work.primitive_tests > 0);
        // symmetry, rigid invariance
        assert!((d - least(&b, &a, &pose_ab.inverse())).abs() < 1e-6, "{names:?}");
        let moved = random.pose(0.5);
        let turned = CollisionBody::new([(&moved, &shape_b)]).unwrap();
        let same = least(&a, &turned, &(pose_ab * moved.inverse()));
        assert!((d - same).abs() < 1e-6, "{names:?} {d} {same}");
        // collide iff distance 0
        let hit = collide(&a, &b, &pose_ab, &mut Work::default());
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
        let mut step = 1e-5;
        while found.distance - proven > 1e-9 && step > 1e-13 {
            let tried = (n + random.vector(step)).normalize();
            if gap_along(&tried) > proven {
                (n, proven) = (tried, gap_along(&tried));
            } else {
                step *= 0.9;
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

fn holds<B: BoundingVolume>(random: &mut Random) {
    for _ in 0..300 {
        let spread = random.vector(1.0);
        let pose = random.pose(2.0);
        let count = 1 + random.below(30);
        let points: Vec<Point> =
            (0..count).map(|_| pose * Point::from(random.vector(1.0).component_mul(&spread))).collect();
        let volume = B::fit(&points);
        for p in &points {
            let at = Pose::translation(p.x, p.y, p.z);
            let dot = B::around(&Primitive::sphere(0.0).unwrap(), &at);
            assert_eq!(volume.lower_bound(&dot, &Pose::identity()), 0.0, "{}", B::NAME);
            assert!(volume.may_touch(&dot, &Pose::identity()), "{}", B::NAME);
        }
    }
}

fn bounds<B: BoundingVolume>(random: &mut Random) {
    for _ in 0..2_000 {
        let (s, t) = (random.triangle(0.5), random.triangle(0.5));
        let pose_ab = random.pose(1.0);
        let [p, q] = s.nearest_points(&t.transformed(&pose_ab));
        let d = nalgebra::distance(&p, &q);
        let (a, b) = (B::fit(&s.corners()), B::fit(&t.corners()));
        assert!(a.lower_bound(&b, &pose_ab) <= d + 1e-12, "{}", B::NAME);
        assert!(d > 1e-9 || a.may_touch(&b, &pose_ab), "{}", B::NAME);
        let (x, y) = (random.primitive(), random.primitive());
        let d = signed_distance(&x, &y, &pose_ab).distance.max(0.0);
        let (a, b) = (B::around(&x, &Pose::identity()), B::around(&y, &Pose::identity()));
        assert!(a.lower_bound(&b, &pose_ab) <= d + 1e-9, "{} {x:?} {y:?}", B::NAME);
    }
}

#[test]
fn volumes_hold_what_they_were_fitted_to() {
    holds::<Obb>(&mut Random::new(20));
    holds::<Rss>(&mut Random::new(21));
    holds::<Sphere>(&mut Random::new(22));
}

#[test]
fn volume_bounds_never_exceed_the_distance() {
    bounds::<Obb>(&mut Random::new(23));
    bounds::<Rss>(&mut Random::new(24));
    bounds::<Sphere>(&mut Random::new(25));
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
    let hit = |a: &CollisionBody, x: f64| collide(a, &ball, &place(x), &mut Work::default()).is_some();
    assert!(!hit(&surface, 0.1) && hit(&solid, 0.1));
    assert!(!hit(&surface, 3.0) && !hit(&solid, 3.0));
    assert_eq!(least(&solid, &ball, &place(0.1)), 0.0);
    assert!(least(&surface, &ball, &place(0.1)) > 0.3);
}
