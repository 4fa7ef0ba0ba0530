//! Tests of queries on inputs that are hard for floating point: slivers, coplanar triangles, nearly touching solids.
//! The true results are known by construction.

use clearance::geometry::math::{Point, Pose, Vector};
use clearance::geometry::{Primitive, Shape, Triangle, nearest_on_segments};
use clearance::proximity::{CollisionBody, Scratch, collide, distance};

use crate::random::Random;

fn gap(s: &Triangle, t: &Triangle) -> f64 {
    let [p, q] = s.nearest_points(t);
    nalgebra::distance(&p, &q)
}

/// A triangle one `size` long and 1e-7 of that wide, and a point inside it.
fn sliver(random: &mut Random, size: f64) -> (Triangle, Point) {
    let along = random.vector(1.0).normalize() * size;
    let across = along.cross(&random.vector(1.0)).normalize() * (1e-7 * size);
    let a = random.point(size);
    let sliver = Triangle { a, b: a + along, c: a + along * random.within(0.2, 0.8) + across };
    let (u, v) = (random.within(0.1, 0.4), random.within(0.1, 0.4));
    (sliver, sliver.a + (sliver.b - sliver.a) * u + (sliver.c - sliver.a) * v)
}

#[test]
fn a_corner_on_the_face_of_a_sliver_touches() {
    let mut random = Random::new(30);
    for _ in 0..20_000 {
        let (s, touch) = sliver(&mut random, 1.0);
        let t = Triangle { a: touch, b: touch + random.vector(1.0), c: touch + random.vector(1.0) };
        assert!(gap(&s, &t) <= 1e-9, "{s:?} {t:?} {}", gap(&s, &t));
        assert!(s.contact_point(&t).is_some() && t.contact_point(&s).is_some(), "{s:?} {t:?}");
    }
}

#[test]
fn a_sliver_pierced_by_a_shallow_edge_touches() {
    let mut random = Random::new(31);
    for _ in 0..20_000 {
        let (s, through) = sliver(&mut random, 1.0);
        let normal = (s.b - s.a).cross(&(s.c - s.a)).normalize();
        let tilt = 10f64.powf(random.within(-9.0, 0.0));
        let direction = ((s.b - s.a) * random.within(-1.0, 1.0) + normal * tilt).normalize();
        let (p, q) = (through + direction * 0.7, through - direction * 0.4);
        let t = Triangle { a: p, b: q, c: p + normal * random.within(0.1, 1.0) };
        assert!(gap(&s, &t) <= 1e-9, "{s:?} {t:?} {}", gap(&s, &t));
        assert!(s.contact_point(&t).is_some(), "{s:?} {t:?}");
    }
}

#[test]
fn segments_that_cross_at_any_angle_meet() {
    let mut random = Random::new(32);
    for _ in 0..50_000 {
        let common = random.point(1.0);
        let d1 = random.vector(1.0).normalize();
        let angle = 10f64.powf(random.within(-12.0, 0.0));
        let d2 = (d1 + d1.cross(&random.vector(1.0)).normalize() * angle).normalize();
        let ends = |d: Vector, random: &mut Random| {
            [common - d * random.within(0.1, 1.0), common + d * random.within(0.1, 1.0)]
        };
        let (first, second) = (ends(d1, &mut random), ends(d2, &mut random));
        let [p, q] = nearest_on_segments(&first, &second);
        assert!(nalgebra::distance(&p, &q) < 1e-10, "{first:?} {second:?} {}", nalgebra::distance(&p, &q));
    }
}

#[test]
fn coplanar_triangles_apart_do_not_touch() {
    let mut random = Random::new(33);
    for _ in 0..20_000 {
        let apart = 10f64.powf(random.within(-6.0, 0.0));
        let pose = random.pose(1.0);
        let mut flat = |from: f64, to: f64| {
            let [a, b, c] =
                [0; 3].map(|_| pose * Point::new(random.within(from, to), random.within(-1.0, 1.0), 0.0));
            Triangle { a, b, c }
        };
        let (s, t) = (flat(-1.0, 0.0), flat(apart, 1.0 + apart));
        assert!(gap(&s, &t) >= apart - 1e-12, "{s:?} {t:?} {} {apart}", gap(&s, &t));
        assert!(s.contact_point(&t).is_none());
        let axis = nalgebra::center(&t.a, &t.b);
        let [p, q] = s.nearest_to_segment(&[t.a, axis]);
        assert!(nalgebra::distance(&p, &q) >= apart - 1e-12);
    }
}

#[test]
fn coplanar_triangles_that_overlap_touch_where_they_say() {
    let mut random = Random::new(34);
    for _ in 0..20_000 {
        let pose = random.pose(1.0);
        let common = Point::new(random.within(-0.1, 0.1), random.within(-0.1, 0.1), 0.0);
        let mut around = || {
            let start = random.within(0.0, std::f64::consts::TAU);
            let [a, b, c] = [0.0, 2.0, 4.0].map(|turn| {
                let angle: f64 = start + turn;
                pose * (common + Vector::new(angle.cos(), angle.sin(), 0.0) * random.within(0.2, 1.0))
            });
            Triangle { a, b, c }
        };
        let (s, t) = (around(), around());
        let point = s.contact_point(&t).unwrap_or_else(|| panic!("{s:?} {t:?}"));
        for triangle in [&s, &t] {
            assert!(nalgebra::distance(&point, &triangle.nearest_point(&point)) < 1e-9);
        }
    }
}

fn body(shape: &Shape) -> CollisionBody {
    CollisionBody::new([(&Pose::identity(), shape)]).unwrap()
}

/// How far a shape reaches from its origin along `n`, and a point of it.
fn reach_and_point(shape: &Shape, n: &Vector, random: &mut Random) -> (f64, Point) {
    match shape {
        Shape::Mesh(mesh) => {
            let along = mesh.vertices().iter().map(|v| v.coords.dot(n));
            let t = mesh.triangle(0);
            let (u, v) = (random.within(0.0, 0.5), random.within(0.0, 0.5));
            (along.fold(f64::NEG_INFINITY, f64::max), t.a + (t.b - t.a) * u + (t.c - t.a) * v)
        }
        Shape::Primitive(primitive) => {
            let share = random.vector(0.57);
            match *primitive {
                Primitive::Box { half_extents } => {
                    let half = Vector::from(half_extents);
                    (half.dot(&n.abs()), Point::from(half.component_mul(&share)))
                }
                Primitive::Sphere { radius } => (radius, Point::from(share * radius)),
                Primitive::Cylinder { radius, half_length } => {
                    let inside = Vector::new(radius, radius, half_length).component_mul(&share);
                    (n.x.hypot(n.y) * radius + n.z.abs() * half_length, Point::from(inside))
                }
                Primitive::Cone { radius, half_length } => {
                    let rim = n.x.hypot(n.y) * radius - n.z * half_length;
                    // at half the height the cone is half as wide
                    let inside = Vector::new(0.5 * radius, 0.5 * radius, 0.0).component_mul(&share);
                    (rim.max(n.z * half_length), Point::from(inside))
                }
                Primitive::Capsule { radius, half_length } => {
                    (radius + n.z.abs() * half_length, Point::from(share * radius))
                }
            }
        }
        _ => unreachable!("no convex solid"),
    }
}

fn convex(random: &mut Random, scale: f64) -> Shape {
    let mut length = || scale * random.within(0.1, 1.0);
    let (x, y, z) = (length(), length(), length());
    let primitive = match random.below(6) {
        0 => Primitive::cuboid([x, y, z]),
        1 => Primitive::sphere(x),
        2 => Primitive::cylinder(x, y),
        3 => Primitive::capsule(x, y),
        4 => Primitive::cone(x, y),
        _ => {
            let t = random.triangle(scale);
            let mesh = clearance::geometry::TriangleMesh::new(t.corners().to_vec(), vec![[0, 1, 2]]);
            return Shape::Mesh(mesh.unwrap().into());
        }
    };
    Shape::Primitive(primitive.unwrap())
}

/// A slab of known width between two convex solids: they are apart, and no answer may say otherwise.
#[test]
fn barely_separate_solids_are_apart_at_every_scale() {
    let mut random = Random::new(35);
    for _ in 0..30_000 {
        let scale = 10f64.powf(random.within(-3.0, 1.0));
        let (x, y) = (convex(&mut random, scale), convex(&mut random, scale));
        let width = scale * 10f64.powf(random.within(-6.0, -2.0)) + 1e-8;
        let n = random.vector(1.0).normalize();
        let rotation = random.rotation();
        let n_b = rotation.inverse() * -n;
        let along = reach_and_point(&x, &n, &mut random).0 + reach_and_point(&y, &n_b, &mut random).0 + width;
        let aside = n.cross(&random.vector(1.0)) * scale * 0.3;
        let pose_ab = Pose::from_parts((n * along + aside).into(), rotation);
        let (a, b) = (body(&x), body(&y));
        let mut scratch = Scratch::default();
        assert!(collide(&a, &b, &pose_ab, &mut scratch).is_none(), "{x:?} {y:?} {pose_ab:?} {width}");
        let found = distance(&a, &b, &pose_ab, f64::INFINITY, &mut scratch).unwrap().distance;
        assert!(found >= width * (1.0 - 1e-6) - 1e-9, "{x:?} {y:?} {pose_ab:?} {found} {width}");
    }
}

/// A point common to both by construction: they touch, whatever the scale.
#[test]
fn solids_with_a_common_point_touch_at_every_scale() {
    let mut random = Random::new(36);
    for _ in 0..30_000 {
        let scale = 10f64.powf(random.within(-3.0, 1.0));
        let (x, y) = (convex(&mut random, scale), convex(&mut random, scale));
        let (in_x, in_y) = (
            reach_and_point(&x, &Vector::z(), &mut random).1,
            reach_and_point(&y, &Vector::z(), &mut random).1,
        );
        let rotation = random.rotation();
        let pose_ab = Pose::from_parts((in_x - rotation * in_y).into(), rotation);
        let (a, b) = (body(&x), body(&y));
        let mut scratch = Scratch::default();
        let found = distance(&a, &b, &pose_ab, 0.0, &mut scratch);
        assert!(found.is_some_and(|f| f.distance == 0.0), "{x:?} {y:?} {pose_ab:?} {found:?}");
        assert!(collide(&a, &b, &pose_ab, &mut scratch).is_some(), "{x:?} {y:?} {pose_ab:?}");
    }
}

#[test]
fn denormal_turns_do_not_disturb() {
    let cylinder = body(&Shape::Primitive(Primitive::cylinder(0.7, 0.25).unwrap()));
    let cuboid = body(&Shape::Primitive(Primitive::cuboid([1.6, 0.3, 0.46]).unwrap()));
    for tiny in [0.0, 1e-300, 1e-310, 5e-324] {
        let turn = nalgebra::Quaternion::new(1.0, tiny, 0.0, 0.0);
        let rotation = clearance::geometry::math::Rotation::new_unchecked(turn);
        let pose = Pose::from_parts(Vector::new(-0.27, -0.31, 2.2).into(), rotation);
        let found = distance(&cuboid, &cylinder, &pose, f64::INFINITY, &mut Scratch::default()).unwrap();
        assert!((found.distance - (2.2 - 0.23 - 0.125)).abs() < 1e-9, "{tiny}: {}", found.distance);
    }
}
