//! Tests of distances and depths of convex bodies against two independent oracles: separating planes and V-Clip.

use std::sync::Arc;

use clearance::geometry::constants::CONTACT_DISTANCE;
use clearance::geometry::math::{Point, Pose, Rotation, Vector};
use clearance::geometry::{Primitive, Shape};
use clearance::proximity::{
    CollisionBody, Scratch, SolidBody, collide, distance, penetration_depth, signed_distance, within_margin,
};

use crate::convex_oracles::{Polytope, Proximity, nearest_features, widest_gap};
use crate::random::Random;

/// Largest error of a distance, relative to it.
const RELATIVE_ERROR: f64 = 1e-9;

/// Largest error (m) of a distance that is shorter than the bodies: GJK ends with bounds this near to each other.
const ABSOLUTE_ERROR: f64 = 2e-10;

/// The engine's copy of a convex body, and the oracle's: a polytope swept by a sphere.
struct Convex {
    shape: Shape,
    pose: Pose,
    core: Polytope,
    radius: f64,
}

impl Convex {
    fn mesh(polytope: &Polytope) -> Self {
        let shape = Shape::Mesh(Arc::new(polytope.mesh()));
        Self { shape, pose: Pose::identity(), core: polytope.clone(), radius: 0.0 }
    }

    fn cuboid(half_extents: [f64; 3], pose: Pose) -> Self {
        let shape = Shape::Primitive(Primitive::Box { half_extents });
        Self { shape, pose, core: Polytope::cuboid(half_extents).placed(&pose), radius: 0.0 }
    }

    /// A triangle alone is a surface, not a solid.
    fn triangle(corners: [Point; 3]) -> Self {
        let mesh = clearance::geometry::TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let core = Polytope::triangle(corners);
        Self { shape: Shape::Mesh(Arc::new(mesh)), pose: Pose::identity(), core, radius: 0.0 }
    }

    fn random(random: &mut Random) -> Self {
        let pose = random.pose(0.2);
        let (x, y, z) = (length(random), length(random), length(random));
        match random.below(5) {
            0 => Self::cuboid([x, y, z], pose),
            1 => {
                let (shape, core) =
                    (Primitive::Sphere { radius: x }, Polytope::point(pose * Point::origin()));
                Self { shape: Shape::Primitive(shape), pose, core, radius: x }
            }
            2 => {
                let shape = Shape::Primitive(Primitive::Capsule { radius: x, half_length: y });
                let ends = [-y, y].map(|z| pose * Point::new(0.0, 0.0, z));
                Self { shape, pose, core: Polytope::segment(ends), radius: x }
            }
            3 => Self::triangle([random.point(0.4), random.point(0.4), random.point(0.4)]),
            _ => Self::mesh(&random_polytope(random)),
        }
    }

    fn body(&self) -> CollisionBody {
        CollisionBody::with_solid_meshes([(&self.pose, &self.shape)]).unwrap()
    }

    fn solid(&self) -> SolidBody {
        SolidBody::new([(&self.pose, &self.shape)])
    }

    /// Whether its penetration depth is known: a triangle alone has no inside.
    fn is_solid(&self) -> bool {
        self.core.faces.len() != 2
    }
}

/// Rods and plates come as often as bodies that are as long as wide.
fn length(random: &mut Random) -> f64 {
    0.4 * 10.0_f64.powf(random.within(-1.5, 0.0))
}

/// The hull of points in an ellipsoid or on it.
fn random_polytope(random: &mut Random) -> Polytope {
    let (axes, count) = (Vector::new(length(random), length(random), length(random)), 4 + random.below(17));
    let is_round = random.below(2) == 0;
    loop {
        let point = |random: &mut Random| {
            let v = random.vector(1.0);
            Point::from(axes.component_mul(&if is_round { v.normalize() } else { v }))
        };
        let points: Vec<Point> = (0..count).map(|_| point(random)).collect();
        if let Some(hull) = Polytope::hull(&points) {
            return hull;
        }
    }
}

/// The hull of points of a grid with an edge of 1/8 m: many are in common planes.
fn grid_polytope(random: &mut Random) -> Polytope {
    loop {
        let points: Vec<Point> = (0..4 + random.below(12)).map(|_| grid_point(random, 4)).collect();
        if let Some(hull) = Polytope::hull(&points) {
            return hull;
        }
    }
}

fn grid_point(random: &mut Random, most: u32) -> Point {
    Point::from(Vector::from_fn(|_, _| f64::from(random.below(most + 1)) / 8.0))
}

/// A pose that maps the grid to itself.
fn grid_pose(random: &mut Random, reach: u32) -> Pose {
    let quarter = |axis: usize, turns: u32| {
        Rotation::from_scaled_axis(Vector::ith(axis, f64::from(turns) * std::f64::consts::FRAC_PI_2))
    };
    let turn = quarter(2, random.below(4)) * quarter(0, random.below(4)) * quarter(2, random.below(4));
    let by = grid_point(random, 2 * reach).coords - Vector::repeat(f64::from(reach) / 8.0);
    Pose::from_parts(by.into(), turn)
}

/// Counts of compared pairs.
#[derive(Debug, Default)]
struct Seen {
    touching: u32,
    overlapping: u32,
    apart: u32,
    /// Largest error of a distance, relative to it.
    worst: f64,
}

/// The distance (m) by feature walk, compared with that of the widest gap; both decide the same.
fn truth(a: &Convex, b: &Convex, pose_ab: &Pose, random: &mut Random) -> f64 {
    let placed = b.core.placed(pose_ab);
    let of_cores = nearest_features(&a.core, &placed, random).distance();
    let gap = widest_gap(&a.core.vertices, &placed.vertices, random);
    let rounding = 1e-11 * a.core.reach().max(placed.reach());
    assert!(of_cores <= gap.sum_norm + rounding, "{of_cores} {gap:?}");
    assert!(of_cores >= gap.sum_norm / 3.0_f64.sqrt() - rounding, "{of_cores} {gap:?}");
    assert!(of_cores >= gap.between_planes - rounding, "{of_cores} {gap:?}");
    (of_cores - a.radius - b.radius).max(0.0)
}

/// Compares every query of the engine with the oracles.
fn compare(a: &Convex, b: &Convex, pose_ab: &Pose, random: &mut Random, seen: &mut Seen) {
    let truth = truth(a, b, pose_ab, random);
    let (body_a, body_b, scratch) = (a.body(), b.body(), &mut Scratch::default());
    let found = distance(&body_a, &body_b, pose_ab, f64::INFINITY, scratch).unwrap();
    let allowed = ABSOLUTE_ERROR.max(RELATIVE_ERROR * truth);
    let is_clear = truth > CONTACT_DISTANCE + allowed || truth < CONTACT_DISTANCE - allowed;
    assert!(is_clear, "{truth} is neither contact nor not: choose other inputs");
    let touches = truth < CONTACT_DISTANCE;
    if touches {
        assert_eq!(found.distance, 0.0, "{truth}");
        seen.touching += 1;
    } else {
        assert!((found.distance - truth).abs() <= allowed, "{} {truth}", found.distance);
        seen.worst = seen.worst.max((found.distance - truth).abs() / truth);
        seen.apart += 1;
    }
    assert_eq!(collide(&body_a, &body_b, pose_ab, scratch).is_some(), touches, "{truth}");
    for margin in [0.5 * truth, truth - 2.0 * allowed, truth + 2.0 * allowed] {
        let is_near = margin > truth || touches;
        let near = within_margin(&body_a, &body_b, pose_ab, margin.max(0.0), scratch);
        assert_eq!(near.is_some(), is_near, "margin {margin}, distance {truth}");
    }
    if let (Shape::Primitive(p), Shape::Primitive(q)) = (&a.shape, &b.shape) {
        let signed = signed_distance(p, q, &(a.pose.inverse() * pose_ab * b.pose));
        assert!((signed.distance.max(0.0) - truth).abs() <= allowed, "{signed:?} {truth}");
    }
    if a.is_solid() && b.is_solid() && touches {
        seen.overlapping += u32::from(compare_depth(a, b, pose_ab, random));
    }
}

/// Compares the depth of two overlapping bodies: after a shorter translation no plane separates them, after the longer one there is a
/// plane. Whether they overlap deeply enough for that.
fn compare_depth(a: &Convex, b: &Convex, pose_ab: &Pose, random: &mut Random) -> bool {
    let depth = penetration_depth(&a.solid(), &b.solid(), pose_ab, 0.0, &mut Scratch::default()).unwrap();
    if depth.lower < 1e-6 {
        return false;
    }
    assert!(depth.upper - depth.lower <= 2e-6, "{depth:?}");
    let mut gap_after = |by: Vector| {
        let moved = pose_ab.rotation;
        let pose = Pose::from_parts((pose_ab.translation.vector + by).into(), moved);
        let placed = b.core.placed(&pose);
        match nearest_features(&a.core, &placed, random) {
            Proximity::Overlap(_) => 0.0,
            Proximity::Apart { distance, .. } => (distance - a.radius - b.radius).max(0.0),
        }
    };
    assert!(gap_after(depth.direction * depth.upper * (1.0 + 1e-9)) > 0.0, "{depth:?}");
    assert!(gap_after(depth.direction * depth.lower * (1.0 - 1e-6)) < 1e-12, "{depth:?}");
    for axis in directions(a, b, pose_ab) {
        assert!(gap_after(axis * depth.lower * (1.0 - 1e-6)) < 1e-12, "{axis:?} {depth:?}");
    }
    true
}

/// Directions in which a shorter way out may be: the normals of all faces, and some between them.
fn directions(a: &Convex, b: &Convex, pose_ab: &Pose) -> Vec<Vector> {
    let of_a = a.core.faces.iter().map(|face| face.normal);
    let of_b = b.core.faces.iter().map(|face| -(pose_ab.rotation * face.normal));
    of_a.chain(of_b).collect()
}

/// Poses whose distance is as often a fraction of a millimetre as of a metre.
fn random_pose(a: &Convex, b: &Convex, random: &mut Random) -> Pose {
    let pose = random.pose(0.3);
    let direction = random.vector(1.0).normalize();
    let [end_a, start_b] = [
        a.core.vertices.iter().map(|p| direction.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max) + a.radius,
        b.core
            .vertices
            .iter()
            .map(|p| direction.dot(&(pose.rotation * p.coords)))
            .fold(f64::INFINITY, f64::min)
            - b.radius,
    ];
    let gap = match random.below(4) {
        0 => return pose,
        1 => -random.within(0.0, 0.1),
        _ => 10.0_f64.powf(random.within(-6.0, 0.0)),
    };
    Pose::from_parts((direction * (end_a - start_b + gap)).into(), pose.rotation)
}

#[test]
fn random_convex_bodies_agree_with_both_oracles() {
    let (mut random, mut seen) = (Random::new(33), Seen::default());
    for _ in 0..1500 {
        let (a, b) = (Convex::random(&mut random), Convex::random(&mut random));
        let pose = random_pose(&a, &b, &mut random);
        compare(&a, &b, &pose, &mut random, &mut seen);
    }
    println!("{seen:?}");
    assert!(seen.touching > 100 && seen.overlapping > 50 && seen.apart > 500, "{seen:?}");
}

/// Parallel faces, edges in common planes, vertices on faces: exact contact is frequent.
#[test]
fn convex_bodies_on_a_grid_agree_with_both_oracles() {
    let (mut random, mut seen) = (Random::new(34), Seen::default());
    let mut exact_contacts = 0;
    for round in 0..1500 {
        let grid_box = |random: &mut Random| {
            let half_extents = (Vector::repeat(1.0 / 8.0) + grid_point(random, 3).coords).into();
            Convex::cuboid(half_extents, grid_pose(random, 2))
        };
        let a =
            if round % 2 == 0 { Convex::mesh(&grid_polytope(&mut random)) } else { grid_box(&mut random) };
        let b =
            if round % 3 == 0 { grid_box(&mut random) } else { Convex::mesh(&grid_polytope(&mut random)) };
        let pose = grid_pose(&mut random, 6);
        let [touching, overlapping] = [seen.touching, seen.overlapping];
        compare(&a, &b, &pose, &mut random, &mut seen);
        exact_contacts += u32::from(seen.touching > touching && seen.overlapping == overlapping);
    }
    println!("{seen:?}, {exact_contacts} exact contacts");
    assert!(exact_contacts > 50 && seen.overlapping > 100 && seen.apart > 100, "{seen:?} {exact_contacts}");
}

/// A polytope is cut in two. The parts touch in all of their common face, and are apart by as much as one is moved away.
#[test]
fn pieces_of_a_convex_body_touch_until_they_are_moved_apart() {
    let (mut random, mut seen) = (Random::new(35), Seen::default());
    for _ in 0..300 {
        let whole = random_polytope(&mut random);
        let normal = random.vector(1.0).normalize();
        let [Some(above), Some(below)] = whole.cut(&Point::from(random.vector(0.01)), &normal) else {
            continue;
        };
        let (above, below) = (Convex::mesh(&above), Convex::mesh(&below));
        compare(&above, &below, &Pose::identity(), &mut random, &mut seen);
        let gap = 10.0_f64.powf(random.within(-5.0, 0.0));
        let moved = Pose::from_parts((normal * -gap).into(), Rotation::identity());
        let known = truth(&above, &below, &moved, &mut random);
        assert!((known - gap).abs() < 1e-12, "{known} {gap}");
        compare(&above, &below, &moved, &mut random, &mut seen);
    }
    println!("{seen:?}");
    assert!(seen.touching > 100 && seen.apart > 100, "{seen:?}");
}

/// Cylinders and cones lie between a prism or pyramid inside and one around them.
#[test]
fn cylinders_and_cones_are_between_inner_and_outer_polytopes() {
    let (mut random, mut between) = (Random::new(36), 0);
    for round in 0..200 {
        let (radius, half_length) = (length(&mut random), length(&mut random));
        let is_cone = round % 2 == 0;
        let primitive = if is_cone {
            Primitive::Cone { radius, half_length }
        } else {
            Primitive::Cylinder { radius, half_length }
        };
        let round_body = Convex {
            shape: Shape::Primitive(primitive),
            pose: Pose::identity(),
            core: round_hull(radius, half_length, is_cone),
            radius: 0.0,
        };
        let outer =
            round_hull(radius / (std::f64::consts::PI / f64::from(SIDES)).cos(), half_length, is_cone);
        let other = Convex::random(&mut random);
        let pose = random_pose(&round_body, &other, &mut random);
        let far = truth(&round_body, &other, &pose, &mut random);
        let near = truth(&Convex::mesh(&outer), &other, &pose, &mut random);
        let found =
            distance(&round_body.body(), &other.body(), &pose, f64::INFINITY, &mut Scratch::default())
                .unwrap();
        assert!(near - 1e-9 <= found.distance && found.distance <= far + 1e-9, "{near} {found:?} {far}");
        between += u32::from(near > 0.0);
    }
    assert!(between > 50, "{between}");
}

/// Number of sides of a polygon around a circle or in it.
const SIDES: u32 = 24;

fn round_hull(radius: f64, half_length: f64, is_cone: bool) -> Polytope {
    let at = |i: u32, z: f64| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(SIDES);
        Point::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    let mut points: Vec<Point> = (0..SIDES).map(|i| at(i, -half_length)).collect();
    if is_cone {
        points.push(Point::new(0.0, 0.0, half_length));
    } else {
        points.extend((0..SIDES).map(|i| at(i, half_length)));
    }
    Polytope::hull(&points).expect("it has a volume")
}
