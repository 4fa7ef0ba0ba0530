//! Tests of witness pairs: against points of the bodies, and against one-sided directional derivatives.

use std::sync::Arc;

use clearance_geometry::math::{MatrixPose, Point, Pose, Rotation, UnitVector, Vector};
use clearance_geometry::testing::Random;
use clearance_geometry::{Plane, PointCloud, Primitive, Shape, TriangleMesh};

use super::{WitnessOptions, WitnessPair, WitnessPairs};
use crate::{BodyPair, CollisionBody, Scratch, SolidBody, depth_witnesses, distance, penetration_depth};

/// All pairs, not only the first.
const ALL: usize = 256;

/// Length (m) and angle (rad) of the steps of differences.
const STEP: f64 = 1e-6;

fn all() -> WitnessOptions {
    WitnessOptions { most: ALL, ..WitnessOptions::default() }
}

/// Two bodies, the second posed in the frame of the first.
struct Scene {
    shapes: [Shape; 2],
    pose_ab: Pose,
}

impl Scene {
    fn new(a: Shape, b: Shape, pose_ab: Pose) -> Self {
        Self { shapes: [a, b], pose_ab }
    }

    fn bodies(&self) -> [CollisionBody; 2] {
        self.shapes.each_ref().map(|shape| CollisionBody::new([(&Pose::identity(), shape)]).unwrap())
    }

    /// Distance (m), and all witness pairs.
    fn witnesses(&self) -> (f64, WitnessPairs) {
        let ([a, b], pose_ab) = (self.bodies(), &MatrixPose::from(&self.pose_ab));
        let (mut found, scratch) = (WitnessPairs::default(), &mut Scratch::default());
        let bodies = BodyPair { a: &a, b: &b, pose_ab };
        let nearest =
            crate::distance_with_witnesses(bodies, f64::INFINITY, &all(), &mut found, scratch).unwrap();
        assert_eq!(Some(nearest), distance(&a, &b, pose_ab, f64::INFINITY, scratch));
        let mut flag = WitnessPairs::default();
        let options = WitnessOptions::default();
        let again = crate::distance_with_witnesses(bodies, f64::INFINITY, &options, &mut flag, scratch);
        assert_eq!((again, flag.are_several()), (Some(nearest), found.are_several()));
        assert_eq!(flag.pairs().first(), found.pairs().first());
        (nearest.distance, found)
    }

    /// Depth (m), and all witness pairs; `None` where it is not known whether there are more.
    fn depth(&self) -> (f64, Option<WitnessPairs>) {
        let solids = self.shapes.each_ref().map(|shape| SolidBody::new([(&Pose::identity(), shape)]));
        let (pose_ab, scratch) = (&MatrixPose::from(&self.pose_ab), &mut Scratch::default());
        let [a, b] = &solids;
        let depth = penetration_depth(a, b, pose_ab, 0.0, scratch).expect("the bodies overlap");
        let mut found = WitnessPairs::default();
        let are_all = depth_witnesses([a, b], pose_ab, (&depth, 0.0), &all(), &mut found);
        (depth.lower, are_all.then_some(found))
    }

    /// The second body rotated by `angular`, about the origin of the first, and moved.
    fn moved(&self, linear: Vector, angular: Vector) -> Self {
        let turn = Pose::from_parts(linear.into(), Rotation::from_scaled_axis(angular));
        Self { shapes: self.shapes.clone(), pose_ab: turn * self.pose_ab }
    }
}

/// Rate of change (m per unit of motion) along the normal, for a twist of the second body.
fn rate(pair: &WitnessPair, linear: &Vector, angular: &Vector) -> f64 {
    pair.normal.dot(&(linear + angular.cross(&pair.points[1].coords)))
}

fn least(rates: impl Iterator<Item = f64>) -> f64 {
    rates.fold(f64::INFINITY, f64::min)
}

/// Derivative of a distance along a motion.
fn of_distance(pairs: &[WitnessPair], linear: &Vector, angular: &Vector) -> f64 {
    least(pairs.iter().map(|pair| rate(pair, linear, angular)))
}

/// Derivative of minus a depth along a motion: for each normal the least over its points; of these the largest, for the bodies separate
/// in the direction that is best.
fn of_depth(pairs: &[WitnessPair], linear: &Vector, angular: &Vector) -> f64 {
    let along = |normal: &Vector| {
        let alike = pairs.iter().filter(|pair| (pair.normal - normal).norm() < 1e-6);
        least(alike.map(|pair| rate(pair, linear, angular)))
    };
    pairs.iter().map(|pair| along(&pair.normal)).fold(f64::NEG_INFINITY, f64::max)
}

/// Largest difference between a derivative by witness pairs and the one-sided directional derivative of `value`, in random directions.
fn largest_error(
    scene: &Scene,
    derivative: impl Fn(&Vector, &Vector) -> f64,
    random: &mut Random,
    value: impl Fn(&Scene) -> f64,
) -> f64 {
    let start = value(scene);
    let errors = (0..12).map(|_| {
        let (linear, angular) = (random.vector(0.3), random.vector(1.0));
        let danskin = derivative(&linear, &angular);
        let [near, far] = [STEP, 2.0 * STEP]
            .map(|step| (value(&scene.moved(linear * step, angular * step)) - start) / step);
        // without the second derivative
        (danskin - (2.0 * near - far)).abs()
    });
    errors.fold(0.0, f64::max)
}

fn cuboid(half: [f64; 3]) -> Shape {
    Shape::Primitive(Primitive::Box { half_extents: half })
}

fn capsule(radius: f64, half_length: f64) -> Shape {
    Shape::Primitive(Primitive::Capsule { radius, half_length })
}

fn cylinder(radius: f64, half_length: f64) -> Shape {
    Shape::Primitive(Primitive::Cylinder { radius, half_length })
}

fn sphere(radius: f64) -> Shape {
    Shape::Primitive(Primitive::Sphere { radius })
}

/// The surface of a box in triangles, each face cut into parts.
fn box_mesh(half: [f64; 3], parts: u32) -> Shape {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
        let first = u32::try_from(vertices.len()).unwrap();
        let at = |i: u32| 2.0 * f64::from(i) / f64::from(parts) - 1.0;
        for (i, j) in (0..=parts).flat_map(|i| (0..=parts).map(move |j| (i, j))) {
            let mut p = Point::origin();
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, at(i), at(j) * side);
            vertices.push(Point::from(p.coords.component_mul(&Vector::from(half))));
        }
        for (i, j) in (0..parts).flat_map(|i| (0..parts).map(move |j| (i, j))) {
            let number = |i: u32, j: u32| first + i * (parts + 1) + j;
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    Shape::Mesh(Arc::new(TriangleMesh::new(vertices, faces).unwrap()))
}

fn about(axis: Vector, angle: f64) -> Pose {
    Pose::rotation(axis * angle)
}

/// Poses of the second body, of which each pair of bodies has several witness pairs.
fn ambiguous() -> Vec<(&'static str, Scene)> {
    let at = Pose::translation;
    let half = [0.1, 0.2, 0.3];
    let quarter = std::f64::consts::FRAC_PI_2;
    let plane = |offset| Shape::Plane(Plane { normal: Vector::z_axis(), offset });
    vec![
        ("faces of boxes", Scene::new(cuboid(half), cuboid(half), at(0.25, 0.1, 0.2))),
        (
            "turned faces of boxes",
            Scene::new(cuboid(half), cuboid(half), at(0.25, 0.0, 0.1) * about(Vector::x(), 0.4)),
        ),
        ("crossed faces", Scene::new(cuboid([0.1, 0.5, 0.1]), cuboid([0.1, 0.1, 0.5]), at(0.3, 0.02, 0.03))),
        ("edges of boxes", Scene::new(cuboid(half), cuboid(half), at(0.3, 0.5, 0.1))),
        (
            "edge above a face",
            Scene::new(cuboid(half), cuboid(half), at(0.4, 0.0, 0.1) * about(Vector::z(), quarter / 2.0)),
        ),
        ("meshes", Scene::new(box_mesh(half, 1), box_mesh(half, 1), at(0.25, 0.1, 0.2))),
        ("fine meshes", Scene::new(box_mesh(half, 7), box_mesh(half, 5), at(0.25, 0.13, 0.21))),
        (
            "mesh and box",
            Scene::new(box_mesh(half, 3), cuboid(half), at(0.25, 0.13, 0.21) * about(Vector::x(), 0.2)),
        ),
        ("parallel capsules", Scene::new(capsule(0.1, 0.3), capsule(0.05, 0.2), at(0.3, 0.1, 0.2))),
        ("capsule along a box", Scene::new(cuboid(half), capsule(0.05, 0.2), at(0.2, 0.1, 0.3))),
        ("capsule along a mesh", Scene::new(box_mesh(half, 2), capsule(0.05, 0.2), at(0.2, 0.1, 0.3))),
        ("parallel cylinders", Scene::new(cylinder(0.1, 0.3), cylinder(0.05, 0.2), at(0.3, 0.1, 0.2))),
        ("ends of cylinders", Scene::new(cylinder(0.1, 0.3), cylinder(0.05, 0.2), at(0.08, 0.0, 0.6))),
        ("plane below a box", Scene::new(plane(-0.5), cuboid(half), Pose::identity())),
        ("plane below a mesh", Scene::new(box_mesh(half, 2), plane(-0.5), Pose::identity())),
        ("plane below a cylinder", Scene::new(plane(-0.5), cylinder(0.1, 0.2), about(Vector::x(), quarter))),
        (
            "ball between two points",
            Scene::new(points(&[[0.2, 0.0, 0.0], [-0.2, 0.0, 0.0]]), sphere(0.1), Pose::identity()),
        ),
        ("ball in a box of faces", Scene::new(box_mesh([0.3; 3], 1), sphere(0.1), Pose::identity())),
        ("ball in a corner", Scene::new(box_mesh([0.3; 3], 4), sphere(0.1), at(0.1, 0.1, 0.0))),
    ]
}

fn points(centres: &[[f32; 3]]) -> Shape {
    Shape::Points(Arc::new(PointCloud::new(centres.to_vec(), 0.02).unwrap()))
}

/// Where nearest points are not unique, the least rate of all pairs is the directional derivative.
#[test]
fn several_pairs_give_directional_derivatives() {
    let mut random = Random::new(3);
    for (name, scene) in ambiguous() {
        let (distance, found) = scene.witnesses();
        assert!(found.are_several() && found.is_complete() && distance > 0.0, "{name}: {found:?}");
        let error = largest_error(
            &scene,
            |v, w| of_distance(found.pairs(), v, w),
            &mut random,
            |scene| scene.witnesses().0,
        );
        // a circle is represented by points
        let allowed = if name.contains("ends of") { 2e-3 } else { 2e-5 };
        assert!(error < allowed, "{name}: {error} {:?}", found.pairs());
    }
}

fn shape(random: &mut Random) -> Shape {
    let size = |random: &mut Random| 0.05 + random.within(0.2).abs();
    let (x, y, z) = (size(random), size(random), size(random));
    match random.below(7) {
        0 => sphere(x),
        1 => capsule(x, y),
        2 => cylinder(x, y),
        3 => Shape::Primitive(Primitive::Cone { radius: x, half_length: y }),
        4 => cuboid([x, y, z]),
        5 => box_mesh([x, y, z], 2),
        _ => points(&[[0.1, 0.0, 0.0], [0.0, 0.1, 0.05]]),
    }
}

/// In general position there is one pair: its points lie on the bodies, and its rate is the derivative in both directions.
#[test]
fn one_pair_gives_the_derivative() {
    let mut random = Random::new(5);
    let (mut smooth, mut worst) = (0, 0.0_f64);
    for _ in 0..3000 {
        let turn = Rotation::from_scaled_axis(random.vector(3.0));
        let pose = Pose::from_parts(random.vector(0.8).into(), turn);
        let scene = Scene::new(shape(&mut random), shape(&mut random), pose);
        let [a, b] = scene.bodies();
        let (distance, found) = scene.witnesses();
        if distance < 0.05 || found.are_several() {
            continue;
        }
        let [WitnessPair { points: [p, q], normal }] = found.pairs() else { panic!("{found:?}") };
        assert!(((q - p) - normal * distance).norm() < 1e-9, "{found:?}");
        let point = CollisionBody::new([(&Pose::identity(), &sphere(0.0))]).unwrap();
        let off = |body: &CollisionBody, p: Point| {
            let pose = Pose::translation(p.x, p.y, p.z);
            crate::distance(body, &point, &pose, f64::INFINITY, &mut Scratch::default()).unwrap().distance
        };
        assert!(off(&a, *p) < 1e-9 && off(&b, scene.pose_ab.inverse_transform_point(q)) < 1e-9);
        let (linear, angular) = (random.vector(0.3), random.vector(1.0));
        let at = |step: f64| scene.moved(linear * step, angular * step).witnesses().0;
        // noise of curved distances, 1e-10 m, allows no shorter steps
        let [fine, coarse] = [1e-3, 2e-3].map(|h| (at(h) - at(-h)) / (2.0 * h));
        let rate = rate(&found.pairs()[0], &linear, &angular);
        // where another feature is nearest within the steps, differences do not converge
        if (fine - coarse).abs() < 1e-5 {
            smooth += 1;
            worst = worst.max((rate - (4.0 * fine - coarse) / 3.0).abs());
        }
    }
    println!("{smooth} smooth pairs, worst error {worst:e}");
    assert!(smooth > 1000 && worst < 2e-6, "{smooth} {worst:e}");
}

/// Overlapping convex solids with several directions or points of the same depth.
fn ambiguous_overlaps() -> Vec<(&'static str, Scene)> {
    let at = Pose::translation;
    let half = [0.1, 0.2, 0.3];
    let quarter = std::f64::consts::FRAC_PI_2;
    let plane = Shape::Plane(Plane { normal: Vector::z_axis(), offset: 0.1 });
    vec![
        ("boxes face to face", Scene::new(cuboid(half), cuboid(half), at(0.15, 0.1, 0.2))),
        ("meshes face to face", Scene::new(box_mesh(half, 1), box_mesh(half, 2), at(0.15, 0.1, 0.2))),
        (
            "two directions",
            Scene::new(cuboid([0.1; 3]), cuboid([0.1; 3]), at(0.15, 0.15, 0.02) * about(Vector::z(), 0.0)),
        ),
        (
            "edge in a face",
            Scene::new(cuboid(half), cuboid(half), at(0.3, 0.0, 0.1) * about(Vector::z(), quarter / 2.0)),
        ),
        ("ball in the middle of a box", Scene::new(cuboid([0.2, 0.3, 0.4]), sphere(0.05), at(0.0, 0.1, 0.0))),
        ("ball below two faces", Scene::new(cuboid([0.2, 0.3, 0.4]), sphere(0.05), at(0.1, 0.2, 0.0))),
        ("crossing capsules", Scene::new(capsule(0.1, 0.3), capsule(0.05, 0.2), about(Vector::x(), 1.0))),
        ("capsule in a box", Scene::new(cuboid(half), capsule(0.05, 0.1), at(0.05, 0.0, 0.0))),
        ("plane in a box", Scene::new(plane, cuboid(half), Pose::identity())),
    ]
}

#[test]
fn several_directions_give_directional_derivatives_of_depths() {
    let mut random = Random::new(7);
    for (name, scene) in ambiguous_overlaps() {
        let (depth, found) = scene.depth();
        let found = found.expect(name);
        assert!(found.are_several() && found.is_complete() && depth > 0.0, "{name}: {found:?}");
        let error = largest_error(
            &scene,
            |v, w| of_depth(found.pairs(), v, w),
            &mut random,
            |scene| -scene.depth().0,
        );
        assert!(error < 5e-5, "{name}: {error} {:?}", found.pairs());
    }
}

/// Convex polyhedra in general position: the derivative of the exact depth.
#[test]
fn one_direction_gives_the_derivative_of_the_depth() {
    let mut random = Random::new(9);
    let (mut smooth, mut worst) = (0, 0.0_f64);
    for _ in 0..600 {
        let mut half = || [(); 3].map(|()| 0.05 + random.within(0.2).abs());
        let (a, b) = (half(), half());
        let pose =
            Pose::from_parts(random.vector(0.2).into(), Rotation::from_scaled_axis(random.vector(3.0)));
        let b = if random.below(2) == 0 { cuboid(b) } else { box_mesh(b, 1) };
        let scene = Scene::new(cuboid(a), b, pose);
        let [first, second] = scene.bodies();
        if crate::collide(&first, &second, &scene.pose_ab, &mut Scratch::default()).is_none() {
            continue;
        }
        let (_, found) = scene.depth();
        let found = found.expect("convex solids");
        if found.are_several() {
            continue;
        }
        let (linear, angular) = (random.vector(0.3), random.vector(1.0));
        let at = |step: f64| -scene.moved(linear * step, angular * step).depth().0;
        let [fine, coarse] = [1e-4, 2e-4].map(|h| (at(h) - at(-h)) / (2.0 * h));
        if (fine - coarse).abs() < 1e-6 {
            smooth += 1;
            let rate = rate(&found.pairs()[0], &linear, &angular);
            worst = worst.max((rate - (4.0 * fine - coarse) / 3.0).abs());
        }
    }
    println!("{smooth} smooth depths, worst error {worst:e}");
    assert!(smooth > 150 && worst < 1e-6, "{smooth} {worst:e}");
}

/// Between planes that are parallel, all points are nearest.
#[test]
fn parallel_planes_have_more_pairs_than_are_listed() {
    let plane = |offset| {
        Shape::Plane(Plane { normal: UnitVector::new_normalize(Vector::new(1.0, 2.0, 3.0)), offset })
    };
    let (_, found) = Scene::new(plane(0.1), plane(0.3), Pose::identity()).witnesses();
    assert!(found.are_several() && !found.is_complete());
    assert!((found.pairs()[0].normal - Vector::new(1.0, 2.0, 3.0).normalize()).norm() < 1e-12);
}

/// More points than are wanted: those that are extreme remain.
#[test]
fn a_short_list_keeps_extreme_points() {
    let half = [0.1, 0.2, 0.3];
    let scene = Scene::new(box_mesh(half, 9), box_mesh(half, 7), Pose::translation(0.25, 0.13, 0.21));
    let ([a, b], pose_ab) = (scene.bodies(), &MatrixPose::from(&scene.pose_ab));
    let options = WitnessOptions { most: 40, ..WitnessOptions::default() };
    let mut found = WitnessPairs::default();
    let bodies = BodyPair { a: &a, b: &b, pose_ab };
    let nearest =
        crate::distance_with_witnesses(bodies, f64::INFINITY, &options, &mut found, &mut Scratch::default());
    assert!(nearest.is_some() && found.is_complete() && found.pairs().len() <= 40, "{found:?}");
    let mut random = Random::new(11);
    assert!(
        largest_error(
            &scene,
            |v, w| of_distance(found.pairs(), v, w),
            &mut random,
            |scene| scene.witnesses().0
        ) < 2e-5
    );
}
