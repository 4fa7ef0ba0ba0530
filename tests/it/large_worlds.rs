//! Tests of worlds with many objects or points, against separate queries for every pair and closed formulas.

use clearance::checker::{CollisionChecker, Question, Workspace};
use clearance::geometry::math::{Point, Pose, Vector};
use clearance::geometry::{PointCloud, Shape};
use clearance::proximity::{self, CollisionBody, Scratch};
use clearance::robot::{Configuration, LinkPoses, RobotModel};
use clearance::scene::{BodyId, Settings};
use clearance::scene::{Obstacle, World};
use std::path::Path;
use std::sync::Arc;

use crate::random::Random;
use crate::worlds::{demo_arm, obstacle, state};

/// Distance of each link from each obstacle, by one query for each pair.
struct OneByOne {
    links: Vec<(BodyId, CollisionBody)>,
    obstacles: Vec<(BodyId, Pose, CollisionBody)>,
}

impl OneByOne {
    fn new(robot: &RobotModel, world: &World) -> Self {
        let links = robot.link_ids().filter_map(|id| {
            let shapes = robot.link(id).collisions.iter().map(|c| (&c.pose_ls, &c.shape));
            Some((BodyId::Link(id), CollisionBody::new(shapes)?))
        });
        let obstacles = world.ids().map(|id| {
            let obstacle = world.obstacle(id);
            let body = CollisionBody::new(obstacle.shapes.iter().map(|s| (&s.pose_os, &s.shape)));
            (BodyId::Obstacle(id), obstacle.pose_ro, body.unwrap())
        });
        Self { links: links.collect(), obstacles: obstacles.collect() }
    }

    fn distances(&self, robot: &RobotModel, q: &Configuration, limit: f64) -> Vec<(BodyId, BodyId, f64)> {
        let mut poses = LinkPoses::new(robot);
        robot.forward_kinematics(q, &mut poses);
        let mut scratch = Scratch::default();
        let mut found = Vec::new();
        for (link, a) in &self.links {
            let BodyId::Link(id) = link else { unreachable!() };
            for (obstacle, pose, b) in &self.obstacles {
                let pose_ab = poses.pose(*id).inverse() * pose;
                if let Some(near) = proximity::distance(a, b, &pose_ab, limit, &mut scratch) {
                    found.push((*link, *obstacle, near.distance));
                }
            }
        }
        found
    }
}

/// Distances, contacts and the boolean of one state; whether it is free.
fn assert_as_one_by_one(
    checker: &CollisionChecker,
    slow: &OneByOne,
    q: &Configuration,
    workspace: &mut Workspace,
) -> bool {
    let near = slow.distances(checker.robot(), q, 0.2);
    let touching: Vec<_> = near.iter().filter(|(_, _, d)| *d == 0.0).map(|(a, b, _)| (*a, *b)).collect();
    assert_eq!(checker.is_free(q, workspace), touching.is_empty());
    assert_eq!(checker.are_free(std::slice::from_ref(q)), [touching.is_empty()]);
    let report = checker.check(q, Question::PairDistances { limit: 0.2 }, workspace);
    assert_eq!(report.colliding_pairs, touching);
    assert_eq!(checker.check(q, Question::Pairs, workspace).colliding_pairs, touching);
    let told: Vec<_> = report.pair_distances.iter().map(|p| (p.a, p.b)).collect();
    assert_eq!(told, near.iter().map(|(a, b, _)| (*a, *b)).collect::<Vec<_>>());
    for (pair, (_, _, distance)) in report.pair_distances.iter().zip(&near) {
        assert!((pair.distance - distance).abs() < 1e-5, "{pair:?} {distance}");
    }
    touching.is_empty()
}

#[test]
fn a_large_world_is_as_all_its_pairs_one_by_one() {
    let robot = demo_arm();
    let mut random = Random::new(7);
    let mut world = World::default();
    for i in 0..600 {
        world.add(obstacle(format!("o{i}"), &mut random, 2.5, 0.15)).unwrap();
    }
    let settings = Settings { check_self: false, ..Settings::default() };
    let checker = CollisionChecker::new(robot.clone(), &world, settings).unwrap();
    let slow = OneByOne::new(&robot, &world);
    let (mut workspace, mut stream) = (checker.workspace(), checker.streaming_workspace());
    let states: Vec<_> = (0..60).map(|_| state(&robot, &mut random)).collect();
    let mut free = 0;
    for q in &states {
        free += usize::from(assert_as_one_by_one(&checker, &slow, q, &mut workspace));
        let least = checker.check(q, Question::Distance { limit: f64::INFINITY }, &mut workspace);
        let all = slow.distances(&robot, q, f64::INFINITY);
        let expected = all.iter().map(|(_, _, d)| *d).fold(f64::INFINITY, f64::min);
        assert!((least.nearest.unwrap().distance - expected).abs() < 1e-5);
        for question in [
            Question::Free,
            Question::Survey { influence_distance: 0.05, limit: 2.0 },
            Question::Distance { limit: f64::INFINITY },
        ] {
            let (cold, mut warm) =
                (checker.check(q, question, &mut workspace), checker.check(q, question, &mut stream));
            warm.work = cold.work;
            assert_eq!(cold, warm);
        }
    }
    assert!((5..55).contains(&free), "{free} of 60 are free: the world is too dense or too thin");
    let expected: Vec<_> = states.iter().map(|q| checker.is_free(q, &mut workspace)).collect();
    assert_eq!(checker.are_free(&states), expected);
}

#[test]
fn ten_thousand_primitives_and_a_thousand_meshes_come_move_and_go_in_place() {
    let robot = demo_arm();
    let mut random = Random::new(23);
    let mut world = World::default();
    let mesh = |name: String, random: &mut Random| {
        let size = random.within(0.02, 0.15);
        let rings = 3 + random.below(5);
        Obstacle::of_shape(name, random.pose(3.0), Shape::Mesh(random.blob(rings, size).into()))
    };
    for i in 0..1000 {
        world.add(mesh(format!("mesh{i}"), &mut random)).unwrap();
    }
    for i in 0..10_000 {
        world.add(obstacle(format!("o{i}"), &mut random, 6.0, 0.15)).unwrap();
    }
    let settings = Settings { check_self: false, ..Settings::default() };
    let mut checker = CollisionChecker::new(robot.clone(), &world, settings).unwrap();
    let mut workspace = checker.streaming_workspace();
    let mut free = 0;
    for round in 0..12 {
        for _ in 0..50 {
            let i = random.below(1000);
            let (name, other) = (format!("mesh{i}"), format!("o{}", random.below(10_000)));
            match random.below(3) {
                0 if world.id(&name).is_some() => drop(world.remove(&name).unwrap()),
                1 if world.id(&name).is_some() => world.move_to(&name, random.pose(1.0)).unwrap(),
                _ => drop(world.replace(mesh(name, &mut random)).unwrap()),
            }
            world.move_to(&other, random.pose(3.0)).unwrap();
        }
        checker.set_world(&world).unwrap();
        let q = state(&robot, &mut random);
        let slow = OneByOne::new(&robot, &world);
        free += u32::from(assert_as_one_by_one(&checker, &slow, &q, &mut workspace));
        assert!(
            round < 11 || (1..12).contains(&free),
            "{free} of 12 are free: the world is too dense or too thin"
        );
    }
}

/// Ground that waves above and beneath the reach of `two_link`, and dust farther up.
fn ground(random: &mut Random, points: u32, radius: f64) -> PointCloud {
    let (low, phase) = (random.within(0.12, 0.15), random.within(0.0, 3.0));
    #[expect(clippy::cast_possible_truncation)]
    let mut point = || {
        let (x, y) = (random.within(-2.3, 2.3), random.within(-2.3, 2.3));
        let wave = 0.05 * (2.0 * x + phase).sin() * (3.0 * y).cos();
        let over_base = if x.abs().max(y.abs()) < 0.4 { 0.2 } else { 0.0 };
        let dust = if random.below(100) == 0 { random.within(0.1, 2.0) } else { random.within(0.0, 0.01) };
        [x as f32, y as f32, (low + wave + over_base + dust) as f32]
    };
    PointCloud::new((0..points).map(|_| point()).collect(), radius).unwrap()
}

/// How far a point is from the surface of a link of `two_link`, by the formulas in its file; inside it is negative or zero.
fn distance_to_two_link(link: &str, p: Point) -> f64 {
    let box_at = |centre: Vector, half: Vector| ((p.coords - centre).abs() - half).map(|c| c.max(0.0)).norm();
    let on_axis = |x: f64, radius: f64| (p.coords - Vector::new(x, 0.0, 0.0)).norm() - radius;
    match link {
        "base" => box_at(Vector::zeros(), Vector::repeat(0.2)),
        "upper" => box_at(Vector::new(0.5, 0.0, 0.0), Vector::new(0.5, 0.05, 0.05)),
        // beyond its ends the rod is inside of a ball
        _ => on_axis(0.0, 0.1).min(on_axis(1.0, 0.1)).min(on_axis(p.x.clamp(0.0, 1.0), 0.01)),
    }
}

#[test]
fn a_cloud_of_a_million_points_is_as_its_points_one_by_one() {
    const RADIUS: f64 = 0.01;
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/two_link/two_link.urdf");
    let robot = Arc::new(RobotModel::load(&file, None, &[]).unwrap());
    let mut random = Random::new(29);
    let settings = Settings { check_self: false, ..Settings::default() };
    let mut world = World::default();
    let mut checker = CollisionChecker::new(robot.clone(), &world, settings).unwrap();
    let mut workspace = checker.streaming_workspace();
    let mut poses = LinkPoses::new(&robot);
    let mut free = 0;
    for _ in 0..2 {
        let cloud = Arc::new(ground(&mut random, 1_000_000, RADIUS));
        let place = Pose::translation(0.1, -0.05, 0.01);
        let shape = Shape::Points(Arc::clone(&cloud));
        world.replace(Obstacle::of_shape("ground", place, shape)).unwrap();
        checker.set_world(&world).unwrap();
        for _ in 0..6 {
            let q = state(&robot, &mut random);
            robot.forward_kinematics(&q, &mut poses);
            let expected = (robot.link_ids()).flat_map(|id| {
                let (link, to_link) = (&robot.link(id).name, poses.pose(id).inverse() * place);
                cloud.points().iter().map(move |p| {
                    distance_to_two_link(link, to_link * Point::from(p.map(f64::from))) - RADIUS
                })
            });
            let expected = expected.fold(f64::INFINITY, f64::min).max(0.0);
            let report = checker.check(&q, Question::Distance { limit: f64::INFINITY }, &mut workspace);
            let told = if report.is_free() { report.nearest.unwrap().distance } else { 0.0 };
            assert!((told - expected).abs() < 1e-6, "{q:?}: {told}, not {expected}");
            assert_eq!(checker.is_free(&q, &mut workspace), expected > 0.0);
            free += u32::from(expected > 0.0);
        }
    }
    assert!((2..11).contains(&free), "{free} of 12 are free");
}

#[test]
fn the_price_of_a_state_hardly_grows_with_the_world() {
    let robot = demo_arm();
    let mut random = Random::new(3);
    let states: Vec<_> = (0..50).map(|_| state(&robot, &mut random)).collect();
    let near: Vec<_> = (0..10).map(|i| obstacle(format!("near{i}"), &mut random, 0.8, 0.1)).collect();
    let volume_tests = |far: u32| {
        let mut world = World::default();
        for o in &near {
            world.add(o.clone()).unwrap();
        }
        let mut random = Random::new(5);
        for i in 0..far {
            let mut o = obstacle(format!("far{i}"), &mut random, 20.0, 0.1);
            o.pose_ro.translation.vector += Vector::new(30.0, 0.0, 0.0);
            world.add(o).unwrap();
        }
        let checker = CollisionChecker::new(robot.clone(), &world, Settings::default()).unwrap();
        let mut workspace = checker.workspace();
        let tests = |q| checker.check(q, Question::Free, &mut workspace).work.volume_tests;
        states.iter().map(tests).sum::<u64>()
    };
    let (few, many) = (volume_tests(0), volume_tests(10_000));
    // a thousand times as many objects are three or four nodes more to go down for each link
    assert!(many < 4 * few, "{few} volume tests among ten obstacles, {many} among ten thousand");
}
