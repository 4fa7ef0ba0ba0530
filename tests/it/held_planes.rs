//! Tests of planes that a link holds and of planes that move, against distances in closed form.

use clearance::checker::{CollisionChecker, MotionOptions, MotionVerdict, Question, UndecidedReason};
use clearance::geometry::math::{Point, Pose, UnitVector, Vector};
use clearance::geometry::{Plane, Primitive, Shape};
use clearance::motion::{Certificate, MotionSegment, MovingObstacle};
use clearance::robot::{Configuration, LinkPoses, RobotModel};
use clearance::scene::{AttachedObject, Obstacle, ObstacleShape, World};
use clearance::scene::{BodyId, Settings};
use clearance::verifier::verify;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use crate::random::Random;
use crate::random_world;
use crate::streams::random_state;

fn dual_arm() -> Arc<RobotModel> {
    let path =
        |kind: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("urdf/dual_arm/dual_arm.{kind}"));
    Arc::new(RobotModel::load(&path("urdf"), Some(&path("srdf")), &[]).unwrap())
}

/// A link that some joints move, named `shield`, holds a plane half a metre away, and a ball on the other side of it.
fn shield(robot: &RobotModel, random: &mut Random, with_ball: bool) -> AttachedObject {
    let moved = robot.links().iter().rev().filter(|link| !link.collisions.is_empty());
    let link = moved.clone().nth(random.below(3) as usize).unwrap().name.clone();
    let normal = UnitVector::new_normalize(random.vector(1.0));
    let plane = Shape::Plane(Plane { normal, offset: random.within(0.3, 0.6) });
    let placed =
        |at: Vector, shape: Shape| ObstacleShape { pose_os: Pose::translation(at.x, at.y, at.z), shape };
    let ball = placed(normal.into_inner() * 0.8, Shape::Primitive(Primitive::sphere(0.05).unwrap()));
    let shapes = [placed(Vector::zeros(), plane)].into_iter().chain(with_ball.then_some(ball));
    AttachedObject {
        name: "shield".to_owned(),
        link,
        pose_lo: Pose::translation(0.02, -0.01, 0.03),
        shapes: shapes.collect(),
        subframes: Vec::new(),
        touch_links: robot.links().iter().filter(|_| random.below(3) == 0).map(|l| l.name.clone()).collect(),
    }
}

/// Least and greatest height over a plane, of each part that is in one piece.
fn heights(shape: &Shape, pose: &Pose, plane: &Plane) -> Vec<[f64; 2]> {
    let n = pose.rotation.inverse() * plane.normal.into_inner();
    let middle = plane.height(&Point::from(pose.translation.vector));
    let even = |half: f64| vec![[middle - half, middle + half]];
    let height = |p: [f32; 3]| middle + n.dot(&Vector::from(p.map(f64::from)));
    match shape {
        Shape::Primitive(Primitive::Box { half_extents }) => even(n.abs().dot(&Vector::from(*half_extents))),
        Shape::Primitive(Primitive::Sphere { radius }) => even(*radius),
        Shape::Primitive(Primitive::Capsule { radius, half_length }) => {
            even(radius + half_length * n.z.abs())
        }
        Shape::Primitive(Primitive::Cylinder { radius, half_length }) => {
            even(radius * n.xy().norm() + half_length * n.z.abs())
        }
        Shape::Primitive(Primitive::Cone { radius, half_length }) => {
            let (disc, tip) = (radius * n.xy().norm(), half_length * n.z);
            vec![[middle + tip.min(-tip - disc), middle + tip.max(disc - tip)]]
        }
        Shape::Mesh(mesh) => {
            let of_triangle = |i| {
                let [a, b, c] = mesh.triangle(i).corners().map(|p| middle + n.dot(&p.coords));
                [a.min(b).min(c), a.max(b).max(c)]
            };
            (0..mesh.triangles().len()).map(of_triangle).collect()
        }
        Shape::Points(cloud) => {
            let of_point = |p: &[f32; 3]| [height(*p) - cloud.radius(), height(*p) + cloud.radius()];
            cloud.points().iter().map(of_point).collect()
        }
        Shape::Voxels(voxels) => {
            let half = |half_edge: f32| f64::from(half_edge) * n.abs().sum();
            let cubes = voxels.cubes().iter();
            cubes
                .map(|c| [height(c.centre) - half(c.half_edge), height(c.centre) + half(c.half_edge)])
                .collect()
        }
        Shape::Plane(_) => panic!("planes meet somewhere"),
    }
}

fn distance(shapes: &[(Pose, &Shape)], plane: &Plane) -> f64 {
    let parts = shapes.iter().flat_map(|(pose, shape)| heights(shape, pose, plane));
    parts.map(|[low, high]| low.max(-high).max(0.0)).fold(f64::INFINITY, f64::min)
}

/// What is as far from the plane of the shield, or of a wall that was displaced, as the second number says.
fn from_the_plane(checker: &CollisionChecker, q: &Configuration, displaced: &Pose) -> HashMap<String, f64> {
    let (robot, world) = (checker.robot(), checker.world());
    let mut poses = LinkPoses::new(robot);
    robot.forward_kinematics(q, &mut poses);
    let (plane, at) = if let Some(shield) = world.attached().first() {
        let link = robot.link_by_name(&shield.link).unwrap();
        (&shield.shapes[0], poses.pose(link) * shield.pose_lo)
    } else {
        let wall = world.obstacle_by_name("wall").unwrap();
        (&wall.shapes[0], displaced * wall.pose_ro)
    };
    let Shape::Plane(held) = &plane.shape else { unreachable!() };
    let plane = held.transformed(&(at * plane.pose_os));
    let mut found = HashMap::new();
    for id in robot.link_ids() {
        let link = robot.link(id);
        let shapes: Vec<_> = link.collisions.iter().map(|c| (poses.pose(id) * c.pose_ls, &c.shape)).collect();
        found.insert(link.name.clone(), distance(&shapes, &plane));
    }
    for obstacle in world.obstacles().filter(|obstacle| obstacle.name != "wall") {
        found.insert(obstacle.name.clone(), distance(&obstacle.placed_shapes().collect::<Vec<_>>(), &plane));
    }
    found
}

/// The checker's distances from the shield.
fn reported(checker: &CollisionChecker, q: &Configuration) -> HashMap<String, f64> {
    let question = Question::PairDistances { limit: f64::INFINITY };
    let report = checker.check(q, question, &mut checker.workspace());
    let held = |body: BodyId| matches!(body, BodyId::Attached(_));
    let other = |a: BodyId, b: BodyId| if held(a) { b } else { a };
    let pairs = report.pair_distances.iter().filter(|p| held(p.a) || held(p.b));
    pairs.map(|p| (checker.body_name(other(p.a, p.b)).to_owned(), p.distance)).collect()
}

/// Some shapes around a robot that holds a plane; no plane stands there, which would cross that.
fn checkers() -> Vec<CollisionChecker> {
    let robot = dual_arm();
    let mut random = Random::new(5);
    (0..6)
        .map(|i| {
            let mut world = if i % 3 == 0 { World::default() } else { random_world::world(&mut random, 1.5) };
            for name in ["floor", "several"] {
                drop(world.remove(name));
            }
            world.attach(shield(&robot, &mut random, false)).unwrap();
            CollisionChecker::new(robot.clone(), &world, Settings::default()).unwrap()
        })
        .collect()
}

#[test]
fn what_a_held_plane_is_from_all_others_is_known() {
    let mut random = Random::new(6);
    let (mut free, mut looks) = (0, 0);
    for checker in checkers() {
        let states: Vec<_> = (0..200).map(|_| random_state(&checker, &mut random)).collect();
        for q in &states {
            let (expected, told) = (from_the_plane(&checker, q, &Pose::identity()), reported(&checker, q));
            assert!(!told.is_empty());
            for (name, distance) in told {
                assert!((distance - expected[&name]).abs() < 1e-9, "{name}: {distance}, {}", expected[&name]);
            }
            let report = checker.check(q, Question::Pairs, &mut checker.workspace());
            assert_eq!(checker.is_free(q, &mut checker.workspace()), report.is_free());
            looks += 1;
            free += usize::from(report.is_free());
        }
        let mut workspace = checker.workspace();
        let one_by_one: Vec<_> = states.iter().map(|q| checker.is_free(q, &mut workspace)).collect();
        assert_eq!(checker.are_free(&states), one_by_one);
    }
    assert!(free > 50 && free < looks - 50, "{free} of {looks} are free");
}

#[test]
fn streams_with_a_held_plane_agree_with_single_states() {
    let mut random = Random::new(7);
    for checker in checkers() {
        let states = crate::streams::walk(&checker, &mut random, 4, 40);
        for question in [
            Question::Free,
            Question::Distance { limit: 0.1 },
            Question::Distance { limit: f64::INFINITY },
            Question::PairDistances { limit: 0.3 },
        ] {
            let (mut single, mut stream) = (checker.workspace(), checker.streaming_workspace());
            for q in &states {
                let (cold, mut warm) =
                    (checker.check(q, question, &mut single), checker.check(q, question, &mut stream));
                warm.work = cold.work;
                assert_eq!(cold, warm, "{question:?}");
            }
        }
    }
}

/// A motion against many of its states, and its certificate; tells whether it is free.
fn judge(checker: &CollisionChecker, segment: &MotionSegment) -> bool {
    let mut workspace = checker.workspace();
    let report = checker.check_motion_with(segment, &MotionOptions::default(), &mut workspace);
    let displaced = |t: f64| segment.obstacles().first().map_or(Pose::identity(), |m| m.displacement(t));
    let nearest = |t: f64| {
        let (q, all) = (segment.at(t), from_the_plane(checker, &segment.at(t), &displaced(t)));
        let asked = reported(checker, &q);
        let counts = |name: &String| checker.world().attached().is_empty() || asked.contains_key(name);
        all.iter().filter(|(name, _)| counts(name)).map(|(_, d)| *d).fold(f64::INFINITY, f64::min)
    };
    let free_until = match report.verdict {
        MotionVerdict::Free => 1.0,
        MotionVerdict::Contact { t: [lo, hi], .. } => {
            assert!(hi - lo < 0.05, "{report:?}");
            lo
        }
        MotionVerdict::Undecided { t: [lo, _], reason, .. } => {
            assert_eq!(reason, UndecidedReason::Tolerance, "{report:?}");
            lo
        }
    };
    for i in 0..=60 {
        let t = f64::from(i) / 60.0;
        assert!(
            t >= free_until && free_until < 1.0 || nearest(t) > 0.0,
            "{report:?}, but it collides at {t}"
        );
    }
    if report.is_free() {
        let (robot, world) = (checker.robot(), checker.world());
        let certified = checker.certify_motion(segment, &MotionOptions::default(), &mut workspace);
        let certificate: Certificate = certified.1.expect("it is free");
        verify(robot, world, checker.settings(), None, &certificate).unwrap();
    }
    report.is_free()
}

#[test]
fn motions_with_a_held_plane_are_decided() {
    let mut random = Random::new(8);
    let (mut free, mut motions) = (0, 0);
    for checker in checkers() {
        for _ in 0..40 {
            let from = random_state(&checker, &mut random);
            let to: Vec<f64> = from.positions().iter().map(|q| q + random.within(-0.2, 0.2)).collect();
            let to = checker.robot().configuration(&to).unwrap();
            motions += 1;
            free += usize::from(judge(&checker, &MotionSegment::straight(checker.robot(), &from, &to)));
        }
    }
    assert!(free > 20 && free < motions - 20, "{free} of {motions} are free");
}

#[test]
fn motions_before_a_plane_that_moves_are_decided() {
    let robot = dual_arm();
    let mut random = Random::new(9);
    let (mut free, motions) = (0, 120);
    for _ in 0..motions {
        let normal = UnitVector::new_normalize(random.vector(1.0));
        let plane = Shape::Plane(Plane { normal, offset: random.within(0.8, 1.6) });
        let mut world = World::default();
        world.add(Obstacle::of_shape("wall", Pose::identity(), plane)).unwrap();
        let settings = Settings { check_self: false, ..Settings::default() };
        let checker = CollisionChecker::new(robot.clone(), &world, settings).unwrap();
        let from = random_state(&checker, &mut random);
        let to: Vec<f64> = from.positions().iter().map(|q| q + random.within(-0.3, 0.3)).collect();
        let to = robot.configuration(&to).unwrap();
        let turns = MovingObstacle {
            name: "wall".to_owned(),
            centre: random.vector(0.5).into(),
            linear: random.vector(0.2).into(),
            angular: random.vector(0.3).into(),
            start: None,
        };
        let segment =
            MotionSegment::straight(&robot, &from, &to).with_obstacles(&world, vec![turns]).unwrap();
        free += usize::from(judge(&checker, &segment));
    }
    assert!(free > 20 && free < motions - 20, "{free} of {motions} are free");
}

/// A ball that the plane's object has beside it counts as ever, and of two planes that move nothing is claimed.
#[test]
fn a_held_plane_hides_nothing_else() {
    let robot = dual_arm();
    let mut random = Random::new(10);
    let held = shield(&robot, &mut random, true);
    let only_ball = AttachedObject { shapes: held.shapes[1..].to_vec().into(), ..held.clone() };
    let checker_of = |object: AttachedObject| {
        let mut world = random_world::world(&mut Random::new(11), 1.2);
        world.attach(object).unwrap();
        CollisionChecker::new(robot.clone(), &world, Settings::default()).unwrap()
    };
    let (both, ball) = (checker_of(held), checker_of(only_ball));
    for _ in 0..200 {
        let q = random_state(&both, &mut random);
        let (with_plane, without) = (reported(&both, &q), reported(&ball, &q));
        for (name, distance) in without {
            assert!(with_plane[&name] <= distance, "{name}");
        }
        // two planes that are not parallel meet
        assert_eq!(with_plane["floor"], 0.0);
    }
    let (from, to) = (random_state(&both, &mut random), random_state(&both, &mut random));
    let report = both.check_motion(&from, &to, &mut both.workspace());
    assert!(!report.is_free(), "{report:?}");
}

/// What a plane sweeps over is everything, which is told of nothing else; and it makes motions of others no dearer than it has to.
#[test]
fn a_held_plane_costs_little() {
    let mut random = Random::new(12);
    for checker in checkers() {
        let swept = |world: World| {
            let checker =
                CollisionChecker::new(checker.robot().clone(), &world, Settings::default()).unwrap();
            let from = random_state(&checker, &mut Random::new(13));
            let to: Vec<f64> = from.positions().iter().map(|q| q + 0.01).collect();
            let to = checker.robot().configuration(&to).unwrap();
            let segment = MotionSegment::straight(checker.robot(), &from, &to);
            let mut workspace = checker.workspace();
            let report = checker.check_motion_with(&segment, &MotionOptions::default(), &mut workspace);
            (checker.swept_volumes(&segment, 2, &mut workspace), report)
        };
        let mut bare = checker.world().clone();
        bare.drop_attached("shield").unwrap();
        let ((with, report), (without, other)) = (swept(checker.world().clone()), swept(bare));
        let numbers = with.iter().flat_map(|v| [v.a.x, v.b.x, v.radius]);
        assert!(numbers.clone().all(f64::is_finite) && numbers.count() > 0);
        assert_eq!(with.len(), without.len());
        assert!(
            report.evaluations < other.evaluations + 100,
            "{} evaluations instead of {}",
            report.evaluations,
            other.evaluations
        );
        // where obstacles come in pieces, the plane is asked about each obstacle once
        let q = random_state(&checker, &mut random);
        let least = Question::Distance { limit: f64::INFINITY };
        let work = checker.check(&q, least, &mut checker.workspace()).work;
        assert!(work.volume_tests < 100_000, "{work:?}");
    }
}
